"""Programs, as data: sequences of steps for one arm and its gripper.

Files, requests and the panel use the same structure.  Steps are numbered from 1.  The
number of a step in a loop starts with that of the loop: if step 3 is a loop, its second
step has the number 3.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Final, Literal

from msgspec import Meta, Struct, field

from tool0.description.units import Metres, MetresPerSecond, Radians
from tool0.errors import ControlError
from tool0.protocol.request import CollisionRule

Name = Annotated[str, Meta(min_length=1, max_length=200)]
Text = Annotated[str, Meta(max_length=1000)]
Coordinate = Annotated[Metres, Meta(ge=-1000.0, le=1000.0)]
"""Coordinate of a position [m]."""
Place = tuple[Coordinate, Coordinate, Coordinate]
Angles = tuple[Radians, Radians, Radians]
"""Orientation: fixed-axis roll, pitch and yaw [rad]."""
Blend = Annotated[Metres, Meta(ge=0.0, le=10.0)]
"""Blend radius [m]."""
Speed = Annotated[float, Meta(gt=0.0, le=100.0)]
ToolSpeed = Annotated[MetresPerSecond, Meta(gt=0.0, le=100.0)]
Acceleration = Annotated[float, Meta(gt=0.0, le=1000.0)]
Duration = Annotated[float, Meta(ge=0.0, le=1e6)]
"""Duration [s]."""
Pin = Annotated[int, Meta(ge=0, le=17)]
"""Pin of the control box: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
StepPath = tuple[int, ...]
"""Numbers of the loops around a step, starting with the outermost loop, followed by the
number of the step."""

MOST_STEPS: Final = 2000
"""Maximum number of steps in a program, including the steps in loops."""
MOST_NESTED: Final = 10
"""Maximum nesting depth of loops in a valid program."""
_DEEPEST: Final = 50
"""Maximum nesting depth of loops for which recursion is safe."""


class ToolPose(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Target pose of the program's tool, or pose of the tool in the flange frame."""

    xyz: Place
    """Position in the frame of ``relative_to`` [m]."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Orientation: fixed-axis roll, pitch and yaw [rad]."""
    relative_to: Name | None = None
    """Link in whose frame the pose is given; the default is the robot's root.  For the
    program's ``tool``, the link must be fixed to the flange; the default is the
    flange."""


class _Step(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"
):
    """Base class of all steps."""


class _Move(_Step, frozen=True, kw_only=True):
    """A move to a target: joint positions, a pose of the tool, or a named pose."""

    label: Annotated[str, Meta(max_length=200)] = ""
    """Label of the target for users, such as ``above cube``."""
    joints: dict[str, Radians] | None = None
    """Joint → target position [rad], for all joints of the arm.  In a cell, the prefix
    of the robot can be left out."""
    pose: ToolPose | None = None
    named_pose: Name | None = None
    """Name of a built-in pose, such as ``home``, or of a saved pose; only the arm
    moves."""
    blend: Blend = 0.0
    """Radius around the target within which the next move can begin [m]."""


class MoveJointStep(_Move, frozen=True, kw_only=True, tag="move_joint"):
    """Move all joints synchronously, like URScript's ``movej``."""

    speed: Speed = 1.05
    """Maximum speed of the joint that moves farthest [rad/s]."""
    acceleration: Acceleration = 1.4
    """Acceleration of the joint that moves farthest [rad/s²]."""
    plan: bool = False
    """Whether to plan a path around obstacles to any posture that reaches the target.
    The path starts and ends at rest, without a blend.  The path is planned when the
    step begins; ``speed`` and ``acceleration`` then limit each joint."""


class MoveLinearStep(_Move, frozen=True, kw_only=True, tag="move_linear"):
    """Move the tool along a straight line, as URScript's ``movel`` does."""

    speed: ToolSpeed = 0.25
    """Speed of the tool [m/s]."""
    acceleration: Acceleration = 1.2
    """Acceleration of the tool [m/s²]."""


class GripperStep(_Step, frozen=True, kw_only=True, tag="gripper"):
    """Move the gripper's pads, and wait until the pads stop."""

    opening: Metres | Literal["open", "closed"]
    """Target distance between the pads [m]."""
    speed: ToolSpeed | None = None
    """Speed of the pads relative to each other [m/s]; the default is the gripper's
    maximum."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Maximum force at each pad [N]; the default is the gripper's maximum."""
    must_hold: bool = False
    """Whether the program ends with an error if the gripper does not hold an object
    after the step."""


class WaitStep(_Step, frozen=True, kw_only=True, tag="wait"):
    """Wait for a duration, or until a digital input has a given level."""

    duration: Duration | None = None
    """Duration of the wait [s].  With an input, the value is a timeout, after which the
    program ends with an error."""
    input: Pin | None = None
    """Pin number of a digital input of the arm's control box."""
    level: bool = True
    """Level that the input must have; true is high."""


class UntilStep(_Step, frozen=True, kw_only=True, tag="until"):
    """Move the tool along a straight line until contact."""

    direction: tuple[float, float, float]
    """Direction of the move; the vector can have any nonzero length."""
    frame: Literal["root", "tool"] = "root"
    """Frame in which the direction is given."""
    distance: Annotated[Metres, Meta(gt=0.0, le=10.0)]
    """Maximum distance of the move [m]."""
    speed: ToolSpeed = 0.02
    """Speed of the tool [m/s]."""
    acceleration: Acceleration = 1.2
    """Acceleration and deceleration of the tool [m/s²]."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Increase of the force on the tool, opposite to the direction of the move, that
    stops the move [N].  By default, any contact of the tool stops the move."""
    must_touch: bool = True
    """Whether the program ends with an error if the move ends without contact."""


class PlaceObjectStep(_Step, frozen=True, kw_only=True, tag="place_object"):
    """Place an object at a pose immediately and at rest, to restore the scene."""

    name: Name
    """Name of the object."""
    xyz: Place
    """Position of the object's origin in the robot's root frame [m]."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Orientation: fixed-axis roll, pitch and yaw [rad]."""


class SetOutputStep(_Step, frozen=True, kw_only=True, tag="set_output"):
    """Set a digital output of the arm's control box."""

    output: Pin
    """Pin number of a digital output of the arm's control box."""
    level: bool = True
    """Level of the output; true is high."""


class CommentStep(_Step, frozen=True, kw_only=True, tag="comment"):
    """A note for users; the step has no effect."""

    text: Text
    """Text of the note."""


class LoopStep(_Step, frozen=True, kw_only=True, tag="loop"):
    """Repeat steps n times, while an input has a given level, or endlessly."""

    steps: tuple[Step, ...] = ()
    """Steps that the loop repeats."""
    times: Annotated[int, Meta(ge=1, le=1_000_000)] | None = None
    """Number of iterations.  Without a number of iterations and without an input, the
    loop is endless."""
    while_input: Pin | None = None
    """Pin number of a digital input, instead of a number of iterations.  The loop ends
    if the input does not have the given ``level`` at the start of an iteration."""
    level: bool = True
    """Level of the input at which the loop continues; true is high."""


Step = (
    MoveJointStep
    | MoveLinearStep
    | GripperStep
    | WaitStep
    | UntilStep
    | PlaceObjectStep
    | SetOutputStep
    | CommentStep
    | LoopStep
)
MoveStep = MoveJointStep | MoveLinearStep


class Program(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A program: steps for one arm and its gripper."""

    format: Literal[1] = 1
    """Version of the file format."""
    name: Name
    """Name of the program, under which it is saved."""
    arm: Name | None = None
    """Name of the arm in ``list_arms``; required only if the robot has several arms."""
    gripper: Name | None = None
    """Name of the gripper; the default is the gripper on the arm."""
    tool: ToolPose = field(default_factory=lambda: ToolPose(xyz=(0.0, 0.0, 0.0)))
    """Pose of the tool in the flange frame; targets, speeds and blends apply to the
    origin of the tool."""
    collision: CollisionRule = "ignore"
    """Reaction to collisions.  With ``refuse``, the program fails before a move that
    would collide; ``until`` steps are not checked."""
    steps: tuple[Step, ...] = ()
    """Steps of the program, in order."""


def walk(
    steps: Sequence[Step], parents: StepPath = ()
) -> Iterator[tuple[StepPath, Step]]:
    """Yield every step with its path; a loop comes before its steps."""
    for number, step in enumerate(steps, 1):
        path = (*parents, number)
        yield path, step
        if isinstance(step, LoopStep):
            yield from walk(step.steps, path)


def require_shallow(program: Program) -> None:
    """Raise ControlError if loops are nested too deeply for recursion.

    The check of the program also rejects less deeply nested loops that are still
    invalid, and reports their location.
    """
    steps: Sequence[Step] = program.steps
    for _ in range(_DEEPEST + 1):
        loops = [step for step in steps if isinstance(step, LoopStep)]
        steps = [step for loop in loops for step in loop.steps]
    if steps:
        raise ControlError(
            f"the program '{program.name}' has more than {MOST_NESTED} loops within "
            "each other"
        )


def path_text(path: Sequence[int]) -> str:
    """Return the path of a step as text, such as ``3.2``."""
    return ".".join(map(str, path))
