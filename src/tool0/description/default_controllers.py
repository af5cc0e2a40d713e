"""The built-in controllers of a robot."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from tool0.description.packages import find_package
from tool0.description.robot import RobotDescription
from tool0.errors import DescriptionError, SourceLocation


def config_file(folder: str, file: str) -> Path:
    """Return a file of the pair in ``folder``."""
    return find_package("tool0_description") / "config" / folder / file


def default_controllers(
    description: RobotDescription, file: str = "controllers.yaml"
) -> tuple[str, SourceLocation]:
    """Return the YAML of a robot's controllers, and the location of its first line.

    Its joints have the robot's prefix; line breaks are unchanged, so line numbers in
    messages are those of the file.  ``file`` may be
    ``controllers_gripper_action.yaml``, which drives the gripper by an action.

    Raises:
        DescriptionError: If there are none, as for your own robot file.
    """
    if not description.robots:
        raise DescriptionError(
            f"there are no built-in controllers for '{description.source}'; "
            "give a file of controllers"
        )
    texts = []
    for robot in description.robots:
        path = config_file("_".join(part.name for part in robot.parts), file)
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise DescriptionError(
                f"there are no controllers for this robot: cannot read '{path}'; "
                "give a file of controllers"
            ) from error
        if robot.prefix:
            joints = {
                transmission.joint.removeprefix(robot.prefix)
                for transmission in description.model.transmissions
                if transmission.joint.startswith(robot.prefix)
            }
            if robot.name:
                joints |= set(yaml_keys(text)) - {"joint_state_controller"}
            text = _with_prefix(text, robot.prefix, joints)
            text = text.replace("arm_joints", f"{robot.prefix}arm_joints")
        texts.append(text)
    return "\n".join(texts), SourceLocation(path, 1)


def yaml_keys(text: str) -> Collection[str]:
    """Return the names at the top."""
    import yaml

    return list(yaml.safe_load(text))


def all_default_controllers() -> Iterator[tuple[str, SourceLocation]]:
    """Yield the YAML of all built-in controllers, those of most parts first."""
    paths = (find_package("tool0_description") / "config").glob("*/controllers.yaml")
    folders = sorted(
        (path.parent.name for path in paths), key=lambda name: (-name.count("_"), name)
    )
    for path in (config_file(folder, "controllers.yaml") for folder in folders):
        yield path.read_text(encoding="utf-8"), SourceLocation(path, 1)


def _with_prefix(text: str, prefix: str, joints: Collection[str]) -> str:
    """Return YAML ``text`` with ``prefix`` before each scalar that is a joint."""
    import yaml

    starts = [
        token.start_mark.index
        for token in yaml.scan(text, yaml.SafeLoader)
        if isinstance(token, yaml.ScalarToken) and token.value in joints
    ]
    for start in reversed(starts):
        after_quote = start + (text[start] in "\"'")
        text = text[:after_quote] + prefix + text[after_quote:]
    return text
