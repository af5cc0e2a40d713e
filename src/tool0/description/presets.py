"""What tool0 brings with a robot of its catalogue: poses, controllers, names."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from tool0.description.packages import find_package
from tool0.errors import DescriptionError, SourceLocation

Poses = Mapping[str, Mapping[str, float]]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PartName:
    """What a person calls a link or a joint."""

    en: str
    zh: str


def config_file(folder: str, file: str) -> Path:
    """Return the file of the arm, the gripper or the pair called ``folder``."""
    return find_package("tool0_description") / "config" / folder / file


def read_poses(arm: str, gripper: str | None, prefix: str) -> Poses:
    """Return joint positions [rad | m] by pose, for the joints with their prefix.

    A pose that both arm and gripper know, such as ``home``, places both.
    """
    poses: dict[str, dict[str, float]] = {}
    for folder in (arm,) if gripper is None else (arm, gripper):
        for name, position in _load(folder, "poses").items():
            pose = poses.setdefault(name, {})
            pose.update({prefix + joint: q for joint, q in position.items()})
    return poses


def read_part_names(
    arm: str, gripper: str | None, prefix: str
) -> Mapping[str, PartName]:
    """Return what people call the links and joints, those with their prefix."""
    return {
        prefix + part: PartName(en=names["en"], zh=names["zh"])
        for folder in ((arm,) if gripper is None else (arm, gripper))
        for part, names in _load(folder, "part_names").items()
    }


def read_controllers(
    arm: str,
    gripper: str | None,
    prefix: str,
    joints: Collection[str],
    file: str = "controllers.yaml",
) -> tuple[str, SourceLocation]:
    """Return a YAML file of controllers, and where its first line stands.

    Each of ``joints``, named without prefix, gets it wherever the YAML names it; no
    line moves, so that messages about the text hold for the file.
    """
    path = config_file(arm if gripper is None else f"{arm}_{gripper}", file)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise DescriptionError(
            f"there are no controllers for this robot: cannot read '{path}'; "
            "give a file of your own"
        ) from error
    if prefix:
        text = _with_prefix(text, prefix, joints)
    return text, SourceLocation(path, 1)


def _load(folder: str, what: str) -> Mapping[str, Any]:  # Any: as the YAML has it
    """Return what ``config/<folder>/<what>.yaml`` lists; nothing if there is none."""
    import yaml

    path = config_file(folder, f"{what}.yaml")
    if not path.is_file():
        return {}
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    data = yaml.load(path.read_text(encoding="utf-8"), loader)
    listed: Mapping[str, Any] = data[what]
    return listed


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
