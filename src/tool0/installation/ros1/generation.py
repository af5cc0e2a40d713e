"""From message definitions to a folder of ROS packages with their Python classes.

A package made here is two things at once: a Python package for ``import``, and a ROS
package (package.xml, msg/, srv/, action/) for ``rosmsg`` and its like.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from tool0.errors import RosUnavailableError

DEFINITIONS = Path(__file__).parent / "definitions"
"""One folder a ROS package, holding msg/, srv/ and action/."""

SECTIONS = re.compile(r"^---.*\n", re.MULTILINE)
_NAMED_ELSEWHERE = re.compile(r"^(\w+)/(\w+)(?:\[\d*\])?\s", re.MULTILINE)
_EMBEDDED = re.compile(r"^=+\nMSG: (\S+)\n", re.MULTILINE)
"""What genpy puts between a message's own text and those that it embeds."""


def package_names() -> tuple[str, ...]:
    """Return the packages that there are definitions of."""
    return tuple(sorted(folder.name for folder in DEFINITIONS.iterdir()))


def definition_files(package: str) -> list[Path]:
    """Return the files that define the package's types, sorted."""
    return sorted(DEFINITIONS.joinpath(package).glob("*/*.*"))


def generate(packages: tuple[str, ...], folder: Path) -> None:
    """Make ROS packages with Python classes in ``folder``, which exists and is empty.

    Raises:
        RosUnavailableError: If genpy cannot make them.
        OSError: If the folder cannot be written.
    """
    embedded = folder / ".embedded"
    for package in packages:
        _write_definitions(package, folder / package)
        _write_embedded(package, embedded)
    search = {found.name: [str(found)] for found in embedded.iterdir()}
    for package in packages:
        _generate_classes(folder / package, search)
    for file in sorted(embedded.rglob("*"), reverse=True):
        file.rmdir() if file.is_dir() else file.unlink()
    embedded.rmdir()


def _write_definitions(package: str, home: Path) -> None:
    """Lay the definitions out as a ROS package, actions also as messages."""
    for file in definition_files(package):
        texts = {file: file.read_text(encoding="utf-8")}
        if file.suffix == ".action":
            texts |= _messages_of_action(file.stem, texts[file])
        for name, text in texts.items():
            target = home / name.suffix.removeprefix(".") / name.name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
    (home / "__init__.py").touch()
    (home / "package.xml").write_text(
        f'<package format="2">\n  <name>{package}</name>\n  <version>0.0.0</version>\n'
        f"  <description>{package} as tool0 defines it</description>\n"
        '  <maintainer email="nobody@invalid">tool0</maintainer>\n'
        "  <license>Apache-2.0</license>\n</package>\n",
        encoding="utf-8",
    )


def _messages_of_action(name: str, text: str) -> dict[Path, str]:
    """Return the seven messages that an action stands for, as actionlib has them."""
    goal, result, feedback = SECTIONS.split(text)
    status = "Header header\nactionlib_msgs/GoalStatus status\n"
    texts = {
        "Goal": goal,
        "Result": result,
        "Feedback": feedback,
        "ActionGoal": "Header header\nactionlib_msgs/GoalID goal_id\n"
        f"{name}Goal goal\n",
        "ActionResult": f"{status}{name}Result result\n",
        "ActionFeedback": f"{status}{name}Feedback feedback\n",
        "Action": f"{name}ActionGoal action_goal\n{name}ActionResult action_result\n"
        f"{name}ActionFeedback action_feedback\n",
    }
    return {Path(f"{name}{kind}.msg"): body for kind, body in texts.items()}


def _write_embedded(package: str, folder: Path) -> None:
    """Write the definitions of other packages that ``package`` embeds.

    They are taken from the installed classes, which are sure to be there: their .msg
    files are another package on Debian, and a search of another path.
    """
    wanted = {("std_msgs", "Header"), ("actionlib_msgs", "GoalID")}
    wanted.add(("actionlib_msgs", "GoalStatus"))
    for file in definition_files(package):
        text = file.read_text(encoding="utf-8")
        wanted.update(_NAMED_ELSEWHERE.findall(text))
    for name, text in _texts({pair for pair in wanted if pair[0] != package}):
        target = folder / f"{name}.msg"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")


def _texts(wanted: set[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """Yield the name and text of each message, and of those embedded in it."""
    from importlib import import_module

    for package, name in sorted(wanted):
        try:
            message = getattr(import_module(f"{package}.msg"), name)
        except (ImportError, AttributeError) as error:
            raise RosUnavailableError(
                f"ROS 1 needs the messages of {package}: {error}"
            ) from None
        own, *others = _EMBEDDED.split(message._full_text)
        yield f"{package}/{name}", own
        yield from zip(others[::2], others[1::2], strict=True)


def _generate_classes(home: Path, search: dict[str, list[str]]) -> None:
    from genpy.generate_initpy import write_modules
    from genpy.generator import MsgGenerator, SrvGenerator

    paths = {**search, home.name: [str(home / "msg")]}
    for generator, kind in ((MsgGenerator(), "msg"), (SrvGenerator(), "srv")):
        target = home / kind
        files = [str(file) for file in sorted(target.glob(f"*.{kind}"))]
        if generator.generate_messages(home.name, files, str(target), paths):
            raise RosUnavailableError(f"genpy cannot make the {kind}s of {home.name}")
        write_modules(str(target))
