"""``tool0 describe``: print the robot, its controllers or the sources of its values."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tool0.cli import options
from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import columns, json_text
from tool0.description.config import DescriptionConfig
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.cli.outputs import JointOutput, TreeOutput
    from tool0.description.catalogue import CataloguePart
    from tool0.description.model import Joint, RobotModel
    from tool0.description.robot import RobotDescription

READERS = options.READERS

Form = Literal["tree", "table", "urdf", "mjcf", "controllers", "sources"]


def describe(
    form: Annotated[Form, Option(is_positional=True)],
    description: DescriptionConfig = DescriptionConfig(),
    output: Path | None = None,
    *,
    gripper_action: bool = False,
    as_json: AsJson = False,
) -> None:
    """Write the robot as a tree, a table of joints, URDF or MJCF, or its controllers.

    ``controllers`` prints the built-in ros_control YAML, which contains all gains and
    their sources.  Save this YAML, change it, and pass it to ``tool0 bringup
    --controllers-file``.  With ``--ros2-control``, ``controllers`` prints the YAML of
    ros2_control.  ``sources`` prints the ratings of each part, and lists the values
    that have no published source.

    Args:
        form: Kind of output to write.
        output: File to write; the default is standard output.
        gripper_action: In the output of ``controllers``, use a GripperActionController
            for grippers.
        as_json: Write the tree, the table or the sources as one JSON object.
    """
    from tool0.description.loading import load_description

    if as_json and form not in ("tree", "table", "sources"):
        raise ConfigError(f"--json is for tree, table and sources, not for {form}")
    robot = load_description(description)
    if as_json:
        text = json_text(plain_sources(robot) if form == "sources" else plain(robot))
    else:
        text = _render(robot, form, gripper_action=gripper_action)
    if output is None:
        if form in ("urdf", "mjcf"):
            encoding = sys.stdout.encoding
            text = text.encode(encoding, "xmlcharrefreplace").decode(encoding)
        print(text, end="")
    else:
        try:
            output.write_text(text, encoding="utf-8")
        except OSError as error:
            raise ConfigError(f"cannot write '{output}': {error.strerror}") from None


def _render(description: RobotDescription, form: Form, *, gripper_action: bool) -> str:
    match form:
        case "tree":
            return tree(description.model)
        case "table":
            return table(description.model)
        case "urdf":
            return description.urdf
        case "mjcf":
            from tool0.engines.mujoco.gl import import_mujoco

            import_mujoco()
            from tool0.engines.mujoco.model import to_mjcf

            return to_mjcf(description.model)
        case "controllers":
            from tool0.control.default_controllers import controllers_yaml

            return controllers_yaml(description, gripper_action=gripper_action)
        case "sources":
            return sources(description)


def tree(model: RobotModel) -> str:
    """Return a line for each joint and its child link, indented below its parent."""
    rows = [
        (f"{branch}{joint.name}", joint.type.value, f"─> {joint.child}")
        for branch, joint in _branches(model, model.root, "")
    ]
    return f"{model.root}\n{columns(rows)}"


def _branches(model: RobotModel, link: str, indent: str) -> Iterator[tuple[str, Joint]]:
    joints = model.child_joints[link]
    for joint in joints:
        is_last = joint is joints[-1]
        yield indent + ("└─ " if is_last else "├─ "), joint
        below = indent + ("   " if is_last else "│  ")
        yield from _branches(model, joint.child, below)


def table(model: RobotModel) -> str:
    """Return a table of the movable joints: type, axis, limits and drive."""
    heads = ("joint", "type", "axis", "lower", "upper", "velocity", "effort", "driven")
    units = ("", "", "", "rad|m", "rad|m", "/s", "N·m|N", "")
    rows = [_row(model, joint) for joint in model.movable_joints]
    return columns([heads, units, *rows])


def _row(model: RobotModel, joint: Joint) -> Sequence[str]:
    limits = joint.limits
    bounds = (limits.lower, limits.upper, limits.velocity, limits.effort)
    return (
        joint.name,
        joint.type.value,
        " ".join(f"{value:g}" for value in joint.axis),
        *(f"{value:.6g}" for value in bounds),
        _drive(model, joint),
    )


def sources(description: RobotDescription) -> str:
    """Return the ratings of each part, and its values without a published source."""
    if not description.robots:
        return f"{description.source.name}: your own file, without specifications\n"
    parts = dict.fromkeys(part for robot in description.robots for part in robot.parts)
    return "\n".join(map(_specifications, parts))


def plain(description: RobotDescription) -> TreeOutput:
    """Return the joints with their limits and drives, for JSON."""
    model = description.model
    return {
        "root": model.root,
        "joints": [_plain_joint(model, joint) for joint in model.joints],
    }


def _plain_joint(model: RobotModel, joint: Joint) -> JointOutput:
    transmission = model.transmission_by_joint.get(joint.name)
    interfaces = transmission.interfaces if transmission is not None else ()
    limits = joint.limits
    return {
        "name": joint.name,
        "type": joint.type.value,
        "parent": joint.parent,
        "child": joint.child,
        "axis": joint.axis,
        "lower": limits.lower,
        "upper": limits.upper,
        "velocity": limits.velocity,
        "effort": limits.effort,
        "driven": [item.value.partition("/")[2] for item in interfaces],
        "mimic": joint.mimic,
    }


def plain_sources(description: RobotDescription) -> dict[str, object]:
    """Return the specifications of each part by the part's name, for JSON."""
    parts = {part for robot in description.robots for part in robot.parts}
    return {part.name: dict(part.load("specifications")) for part in parts}


def _specifications(part: CataloguePart) -> str:
    facts = dict(part.load("specifications"))
    if not facts:
        return f"{part.name}: no specifications.yaml in {part.folder}\n"
    unsourced = facts.pop("unsourced", None) or {}
    rows = [
        (f"  {key}", "-" if value is None else str(value))
        for key, value in facts.items()
    ]
    text = f"{part.name}\n{columns(rows)}"
    if unsourced:
        text += "  without a published source:\n"
        text += columns([(f"    {key}", reason) for key, reason in unsourced.items()])
    return text


def _drive(model: RobotModel, joint: Joint) -> str:
    if joint.mimic is not None:
        offset = f" {joint.mimic.offset:+g}" if joint.mimic.offset else ""
        free = " (passive)" if joint.passive else ""
        return f"{joint.mimic.multiplier:+g} · {joint.mimic.joint}{offset}{free}"
    transmission = model.transmission_by_joint.get(joint.name)
    if transmission is None:
        return "-"
    names = (item.value.partition("/")[2] for item in transmission.interfaces)
    return ", ".join(names)
