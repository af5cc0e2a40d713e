"""Programs: steps for one arm and its gripper, as data.

Files, requests and the panel use the same structure.  Steps are numbered from 1, and
within loops the loop's number comes first: the second step of the loop that is step 3
has the number 3.2.
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
"""Fixed-axis roll, pitch, yaw [rad]."""
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
"""Numbers of the loops around a step, the outermost first, and of the step itself."""

MOST_STEPS: Final = 2000
"""Largest number of steps in a program, including those within loops."""
MOST_NESTED: Final = 10
"""Largest nesting depth of loops."""
_DEEPEST: Final = 50
"""Nesting depth of loops up to which recursion is safe."""


class ToolPose(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pose of the program's tool, or of the tool in the flange."""

    xyz: Place
    """Position in the frame ``relative_to`` [m]."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""
    relative_to: Name | None = None
    """Link in whose frame the pose is given; if left out, the robot's root.  For the
    program's ``tool``, a link fixed to the flange; if left out, the flange."""


class _Step(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"
):
    """Base class of all steps."""


class _Move(_Step, frozen=True, kw_only=True):
    """A move to one target: joint positions, a pose of the tool, or a named pose."""

    label: Annotated[str, Meta(max_length=200)] = ""
    """Name of the target for users, such as ``above cube``."""
    joints: dict[str, Radians] | None = None
    """Joint → position [rad], for all joints of the arm.  In a cell, the robot's prefix
    may be left out."""
    pose: ToolPose | None = None
    named_pose: Name | None = None
    """Name of one of the robot's own poses, such as ``home``, or of a saved pose; only
    the arm moves."""
    blend: Blend = 0.0
    """Radius around the target within which the next move may begin [m]."""


class MoveJointStep(_Move, frozen=True, kw_only=True, tag="move_joint"):
    """Move all joints synchronously, like URScript's ``movej``."""

    speed: Speed = 1.05
    """Speed of the joint that moves farthest [rad/s]."""
    acceleration: Acceleration = 1.4
    """Acceleration of the joint that moves farthest [rad/s²]."""
    plan: bool = False
    """Whether to go around obstacles, from rest to rest and without a blend, to any
    posture that reaches the target.  The path is planned when the step begins; speed
    and acceleration then limit each joint."""


class MoveLinearStep(_Move, frozen=True, kw_only=True, tag="move_linear"):
    """Move the tool on a straight line, like URScript's ``movel``."""

    speed: ToolSpeed = 0.25
    """Speed of the tool [m/s]."""
    acceleration: Acceleration = 1.2
    """Acceleration of the tool [m/s²]."""


class GripperStep(_Step, frozen=True, kw_only=True, tag="gripper"):
    """Move the gripper's pads and wait until they stop."""

    opening: Metres | Literal["open", "closed"]
    """Distance between the pads [m]."""
    speed: ToolSpeed | None = None
    """Speed of the pads relative to each other [m/s]; the gripper's maximum if left
    out."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Largest force at each pad [N]; the gripper's maximum if left out."""
    must_hold: bool = False
    """Whether the program ends with an error if the gripper holds nothing
    afterwards."""


class WaitStep(_Step, frozen=True, kw_only=True, tag="wait"):
    """Wait for a time, or until a digital input has a level."""

    duration: Duration | None = None
    """Time to wait [s]; with an input, the timeout after which the program ends with an
    error."""
    input: Pin | None = None
    """Pin number of a digital input of the arm's control box."""
    level: bool = True
    """Level that the input must have; true is high."""


class UntilStep(_Step, frozen=True, kw_only=True, tag="until"):
    """Move the tool on a line until it touches something."""

    direction: tuple[float, float, float]
    """Direction of the move; its length must not be zero."""
    frame: Literal["root", "tool"] = "root"
    """Frame in which the direction is given."""
    distance: Annotated[Metres, Meta(gt=0.0, le=10.0)]
    """Longest distance to move [m]."""
    speed: ToolSpeed = 0.02
    """Speed of the tool [m/s]."""
    acceleration: Acceleration = 1.2
    """Acceleration and deceleration of the tool [m/s²]."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Increase of the force on the tool against the direction at which to stop [N]; if
    left out, any contact of the tool stops the move."""
    must_touch: bool = True
    """Whether the program ends with an error if nothing was touched on the way."""


class PlaceObjectStep(_Step, frozen=True, kw_only=True, tag="place_object"):
    """Place an object of the scene immediately, at rest, to restore the scene."""

    name: Name
    """Name of the object."""
    xyz: Place
    """Position of the object's origin, in the robot's root [m]."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""


class SetOutputStep(_Step, frozen=True, kw_only=True, tag="set_output"):
    """Set a digital output of the arm's control box."""

    output: Pin
    """Pin number of a digital output of the arm's control box."""
    level: bool = True
    """Level of the output; true is high."""


class CommentStep(_Step, frozen=True, kw_only=True, tag="comment"):
    """A note for users; it does nothing."""

    text: Text
    """Text of the note."""


class LoopStep(_Step, frozen=True, kw_only=True, tag="loop"):
    """Repeat steps a number of times, while an input has a level, or forever."""

    steps: tuple[Step, ...] = ()
    """The repeated steps."""
    times: Annotated[int, Meta(ge=1, le=1_000_000)] | None = None
    """Number of iterations; if this and the input are left out, the loop is endless."""
    while_input: Pin | None = None
    """Pin of a digital input, instead of a number of iterations; the loop ends when the
    input does not have the level before an iteration."""
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
    """Steps for one arm and its gripper."""

    format: Literal[1] = 1
    """Version of the file format."""
    name: Name
    """Name of the program, under which it is also saved."""
    arm: Name | None = None
    """Name of the arm, as in ``list_arms``; the only arm of the robot if left out."""
    gripper: Name | None = None
    """Name of the gripper; if left out, the one that the arm carries."""
    tool: ToolPose = field(default_factory=lambda: ToolPose(xyz=(0.0, 0.0, 0.0)))
    """Pose of the tool in the flange; targets, speeds and blends apply to its
    origin."""
    collision: CollisionRule = "ignore"
    """Reaction to collisions.  With ``refuse``, the program fails before a move that
    would collide; ``until`` steps are not checked."""
    steps: tuple[Step, ...] = ()
    """Steps of the program, in order."""


def walk(
    steps: Sequence[Step], parents: StepPath = ()
) -> Iterator[tuple[StepPath, Step]]:
    """Yield every step with its path; loops come before their steps."""
    for number, step in enumerate(steps, 1):
        path = (*parents, number)
        yield path, step
        if isinstance(step, LoopStep):
            yield from walk(step.steps, path)


def require_shallow(program: Program) -> None:
    """Raise ControlError if loops are nested too deeply to walk through the program.

    If loops are nested less deeply but still too deeply, a check reports where.
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
    """Return a path in readable form, such as ``3.2``."""
    return ".".join(map(str, path))
