"""Generates the message classes that the ROS interface imports.

If the packages ``control_msgs``, ``controller_manager_msgs`` and ``gazebo_msgs`` are
installed, they are used.  A missing package is generated once from tool0's definitions
and stored in the cache.  The result is a Python package for ``import`` and also a ROS
package for ``rosmsg`` and similar commands.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator
from compileall import compile_dir
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path

from tool0.errors import RosUnavailableError
from tool0.installation.ros1.library import SET_UP, import_ros, message_folders
from tool0.user_data import cache_folder, locked

DEFINITIONS = Path(__file__).parent / "definitions"
"""Folder of the definitions.  The folder contains one folder per ROS package, with
msg/, srv/, action/ and Python modules."""
EMBEDDED_PACKAGES = ("std_msgs", "geometry_msgs", "trajectory_msgs", "actionlib_msgs")
"""Installed packages whose messages are used in tool0's definitions."""
_SECTIONS = re.compile(r"^---.*\n", re.MULTILINE)
_CLASSES_OF_SECTIONS = {
    ".msg": ("",),
    ".srv": ("Request", "Response"),
    ".action": ("Goal", "Result", "Feedback"),
}
"""Suffixes that form the class names for a file's sections, by the suffix of the
file."""
_KINDS = ("msg", "srv", "action")
"""Names of the folders of definitions, which are also the suffixes of the files in
them."""
_FIELD = re.compile(r"^\S+ (\w+)$", re.MULTILINE)
"""Pattern of a line that defines a field and not a constant, in tool0's definitions."""
_MANIFEST = """\
<package format="2">
  <name>{0}</name>
  <version>0.0.0</version>
  <description>{0} as tool0 defines it</description>
  <maintainer email="tool0@example.org">The tool0 authors</maintainer>
  <license>Apache-2.0</license>
</package>
"""
_SHELL_VARIABLES = ("PYTHONPATH", "ROS_PACKAGE_PATH")


def import_messages() -> None:
    """Make rospy and all message packages importable.  Repeated calls have no effect.

    Raises:
        RosUnavailableError: If there is no rospy, or if an installed package lacks
            message types.
    """
    import_ros()
    absent = absent_packages()
    for package in package_names():
        if package not in absent:
            _check_installed(package)
    if not absent:
        return
    try:
        folder = generated_packages(absent)
    except OSError as error:
        folder = _temporary_packages(absent, error)
    sys.path[:] = [*_path(), str(folder)]
    importlib.invalidate_caches()


def package_names() -> tuple[str, ...]:
    """Return the names of the packages for which tool0 has definitions."""
    folders = {file.parent.parent for kind in _KINDS for file in _files("*", kind)}
    return tuple(sorted(folder.name for folder in folders))


def definition_files(package: str) -> list[Path]:
    """Return the sorted files that define the package's types."""
    return sorted(file for kind in _KINDS for file in _files(package, kind))


def _files(package: str, kind: str) -> Iterator[Path]:
    """Yield the definition files of a kind.

    Files that pip has compiled are omitted.
    """
    return DEFINITIONS.glob(f"{package}/{kind}/*.{kind}")


def module_files(package: str) -> list[Path]:
    """Return the Python modules that the package has in addition to its types."""
    return sorted(DEFINITIONS.joinpath(package).glob("*.py"))


def absent_packages() -> tuple[str, ...]:
    """Return tool0's message packages that are not installed.

    rospy must be importable.  A package that an earlier run generated is not treated as
    installed.
    """
    specs = {name: PathFinder.find_spec(name, _path()) for name in package_names()}
    # The spec of a folder without __init__.py has no origin.
    return tuple(n for n, spec in specs.items() if spec is None or spec.origin is None)


def _path() -> list[str]:
    return [entry for entry in sys.path if not is_generated(entry)]


def is_generated(entry: str) -> bool:
    """Return whether ``generated_packages`` created an entry of the search path."""
    return Path(entry).parent == _cache()


def _cache() -> Path:
    return cache_folder() / "ros1"


def shell_exports() -> list[str]:
    """Return shell commands that add the missing message packages to the paths.

    The commands are for a POSIX shell.  The commands append the packages to the current
    values of variables, without duplicates.  The list is empty if all packages are
    installed.

    Raises:
        RosUnavailableError: If there is no rospy, or if the cache cannot be written.
    """
    import_ros()
    absent = absent_packages()
    if not absent:
        return []
    try:
        folder = generated_packages(absent)
    except OSError as error:
        raise RosUnavailableError(
            f"cannot write the cache: {error}; set XDG_CACHE_HOME to another folder"
        ) from None
    lines = []
    for variable in _SHELL_VARIABLES:
        entries = os.environ.get(variable, "").split(os.pathsep)
        kept = [entry for entry in entries if entry and not is_generated(entry)]
        value = os.pathsep.join([*kept, str(folder)])
        lines.append(f"export {variable}={shlex.quote(value)}")
    return lines


# --- generation ---


def generated_packages(packages: tuple[str, ...]) -> Path:
    """Return the folder with ``packages``, which are generated if necessary.

    The folder is an entry for both PYTHONPATH and ROS_PACKAGE_PATH.

    Raises:
        RosUnavailableError: If genpy cannot generate the packages.
        OSError: If the folder does not exist and the cache cannot be written.
    """
    folder = _cache() / _key(packages)
    if folder.is_dir():
        return folder
    folder.parent.mkdir(parents=True, exist_ok=True)
    with locked(folder.parent / "lock"):
        # another process may have created the folder in the meantime
        if not folder.is_dir():
            new = Path(tempfile.mkdtemp(prefix="new-", dir=folder.parent))
            try:
                generate(packages, new)
                new.rename(folder)
            except BaseException:
                shutil.rmtree(new, ignore_errors=True)
                raise
            # Importing bytecode is 5 times as fast as importing source code.  Python
            # does not write bytecode if PYTHONDONTWRITEBYTECODE is set.
            compile_dir(folder, quiet=2)
    return folder


def _key(packages: tuple[str, ...]) -> str:
    """Return a hash of everything on which the result depends."""
    generator = importlib.util.find_spec("genpy.generator")
    if generator is None or generator.origin is None:
        raise RosUnavailableError(f"genpy, which ROS 1 needs, is missing; {SET_UP}")
    files = [Path(generator.origin), Path(__file__)]
    for package in packages:
        files += definition_files(package) + module_files(package)
    digest = hashlib.sha256(f"{sys.version_info[:2]} {packages}".encode())
    for file in files:
        digest.update(f"\0{file.name}\0".encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def _temporary_packages(packages: tuple[str, ...], cause: OSError) -> Path:
    """Generate the packages in a temporary folder, which is removed at exit."""
    import atexit

    try:
        folder = Path(tempfile.mkdtemp(prefix="tool0-ros1-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        generate(packages, folder)
    except OSError as error:
        raise RosUnavailableError(
            f"the classes of {', '.join(packages)} can be written neither to the cache "
            f"({cause}) nor to a temporary folder ({error}); XDG_CACHE_HOME and TMPDIR "
            "name others"
        ) from None
    return folder


def generate(packages: tuple[str, ...], folder: Path) -> None:
    """Generate ROS packages with Python classes in the empty folder ``folder``.

    Raises:
        RosUnavailableError: If genpy cannot generate the packages.
        OSError: If the folder cannot be written.
    """
    from genpy.generate_initpy import write_modules
    from genpy.generator import MsgGenerator, SrvGenerator

    search = {
        name: [str(found) for found in message_folders(name)]
        for name in EMBEDDED_PACKAGES
    }
    for package in packages:
        home = folder / package
        _write_definitions(package, home)
        search[package] = [str(home / "msg")]
        for generator, kind in ((MsgGenerator(), "msg"), (SrvGenerator(), "srv")):
            target = home / kind
            files = [str(file) for file in sorted(target.glob(f"*.{kind}"))]
            if generator.generate_messages(package, files, str(target), search):
                raise RosUnavailableError(
                    f"genpy cannot make the {kind}s of {package}; it needs the message "
                    f"definitions of {', '.join(EMBEDDED_PACKAGES)}; {SET_UP}"
                )
            write_modules(str(target))


def _write_definitions(package: str, home: Path) -> None:
    """Write the definitions as a ROS package.  Actions are also written as messages."""
    for file in definition_files(package):
        texts = {file: file.read_text(encoding="utf-8")}
        if file.suffix == ".action":
            texts |= _messages_of_action(file.stem, texts[file])
        for name, text in texts.items():
            target = home / name.suffix.removeprefix(".") / name.name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
    for module in module_files(package):
        shutil.copyfile(module, home / module.name)
    (home / "__init__.py").touch()
    (home / "package.xml").write_text(_MANIFEST.format(package), encoding="utf-8")


def _messages_of_action(name: str, text: str) -> dict[Path, str]:
    """Return the seven messages that actionlib defines for an action."""
    goal, result, feedback = _SECTIONS.split(text)
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


# --- a package that is installed ---


def _check_installed(package: str) -> None:
    """Raise RosUnavailableError if the package lacks any of tool0's types or fields."""
    for file in definition_files(package):
        module = f"{package}.{'srv' if file.suffix == '.srv' else 'msg'}"
        for name, fields in _classes(file):
            try:
                found = getattr(import_module(module), name)
            except (ImportError, AttributeError):
                raise _mismatch(package, f"{name} is not in it") from None
            if not hasattr(found, "_md5sum"):
                raise _mismatch(package, f"{name} is not of ROS 1")
            if missing := [one for one in fields if one not in found.__slots__]:
                raise _mismatch(package, f"{name} has no field {missing[0]}")


def _classes(file: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the name and the fields of each class that the file defines."""
    sections = _SECTIONS.split(file.read_text(encoding="utf-8"))
    for ending, text in zip(_CLASSES_OF_SECTIONS[file.suffix], sections, strict=True):
        yield f"{file.stem}{ending}", _FIELD.findall(text)


def _mismatch(package: str, reason: str) -> RosUnavailableError:
    where = getattr(import_module(package), "__file__", None)
    return RosUnavailableError(
        f"the installed {package} differs: {reason} ({where}); install Noetic's, "
        "or remove that folder from PYTHONPATH: tool0 then generates its own"
    )
