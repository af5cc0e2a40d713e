"""A program: steps for one arm and its gripper, as data.

A file, a request and the panel have the same structure.  A step is named by its number
from 1 on, with those of the loops around it: step 2 of the loop that is step 3 is 3.2.
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
"""Number at the control box: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
StepPath = tuple[int, ...]
"""The numbers of a step and of the loops around it, from the outermost on."""

MOST_STEPS: Final = 2000
"""Largest number of steps of a program, those within loops included."""
MOST_NESTED: Final = 10
"""Loops within each other."""
_DEEPEST: Final = 50
"""Loops within each other that recursion still takes."""


class ToolPose(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pose of the program's tool."""

    xyz: Place
    """Position in the frame ``relative_to`` [m]."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""
    relative_to: Name | None = None
    """The link in whose frame it is; the robot's root, if left out; for the tool, a
    link that is fixed to the flange, and the flange, if left out."""


class _Step(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"
):
    """The base of every step."""


class _Move(_Step, frozen=True, kw_only=True):
    """A move to one target: joint positions, a pose of the tool, or a named pose."""

    label: Annotated[str, Meta(max_length=200)] = ""
    """Name of the target for users, such as ``above cube``."""
    joints: dict[str, Radians] | None = None
    """Joint → position [rad], for all joints of the arm.  In a cell, the robot's prefix
    may be left out."""
    pose: ToolPose | None = None
    named_pose: Name | None = None
    """Name of a pose of the robot, such as ``home``, or of a saved one; only the arm
    moves."""
    blend: Blend = 0.0
    """Radius around the target within which the next move may begin [m]."""


class MoveJointStep(_Move, frozen=True, kw_only=True, tag="move_joint"):
    """Turn all joints in proportion, as URScript's ``movej``."""

    speed: Speed = 1.05
    """Speed of the joint that turns most [rad/s]."""
    acceleration: Acceleration = 1.4
    """Acceleration of the joint that turns most [rad/s²]."""
    plan: bool = False
    """Go around obstacles, from rest to rest and without a blend, to any posture that
    reaches the target.  The way is planned when the step begins; speed and acceleration
    are limits of each joint."""


class MoveLinearStep(_Move, frozen=True, kw_only=True, tag="move_linear"):
    """Move the tool on a straight line, as URScript's ``movel``."""

    speed: ToolSpeed = 0.25
    """Speed of the tool [m/s]."""
    acceleration: Acceleration = 1.2
    """Acceleration of the tool [m/s²]."""


class GripperStep(_Step, frozen=True, kw_only=True, tag="gripper"):
    """Move the gripper's pads, and wait until they stand still."""

    opening: Metres | Literal["open", "closed"]
    """Distance between the pads [m]."""
    speed: ToolSpeed | None = None
    """Speed of the pads relative to each other [m/s]; the fastest, if left out."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Largest force at each pad [N]; the strongest, if left out."""
    must_hold: bool = False
    """Whether the program ends with an error if the gripper holds nothing then."""


class WaitStep(_Step, frozen=True, kw_only=True, tag="wait"):
    """Wait for a time, or until a digital input has a level."""

    duration: Duration | None = None
    """Time to wait [s]; with an input, the longest wait: the program ends with an error
    after it."""
    input: Pin | None = None
    """Number of an input of the arm's control box."""
    level: bool = True
    """Level that the input must have; high is true."""


class UntilStep(_Step, frozen=True, kw_only=True, tag="until"):
    """Move the tool on a line until it touches something."""

    direction: tuple[float, float, float]
    """Direction of the move; its length must not be zero."""
    frame: Literal["root", "tool"] = "root"
    """Frame whose axes the direction has."""
    distance: Annotated[Metres, Meta(gt=0.0, le=10.0)]
    """The longest way [m]."""
    speed: ToolSpeed = 0.02
    """Speed of the tool [m/s]."""
    acceleration: Acceleration = 1.2
    """Acceleration and deceleration of the tool [m/s²]."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Stop at this force on the tool against the direction [N], above that at the
    start; at any contact of the tool, if left out."""
    must_touch: bool = True
    """Whether the program ends with an error if nothing was touched on the way."""


class PlaceObjectStep(_Step, frozen=True, kw_only=True, tag="place_object"):
    """Place an object of the scene at once, at rest: to set up a scene again."""

    name: Name
    """Name of the object."""
    xyz: Place
    """Position of the object's origin, in the robot's root [m]."""
    rpy: Angles = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""


class SetOutputStep(_Step, frozen=True, kw_only=True, tag="set_output"):
    """Set a digital output of the arm's control box."""

    output: Pin
    """Number of an output of the arm's control box."""
    level: bool = True
    """High is true."""


class CommentStep(_Step, frozen=True, kw_only=True, tag="comment"):
    """A note for users; nothing happens."""

    text: Text
    """The note."""


class LoopStep(_Step, frozen=True, kw_only=True, tag="loop"):
    """Repeat steps: a number of times, while an input has a level, or forever."""

    steps: tuple[Step, ...] = ()
    """The repeated steps."""
    times: Annotated[int, Meta(ge=1, le=1_000_000)] | None = None
    """Number of times; forever, without it and an input."""
    while_input: Pin | None = None
    """Instead of a number: before each time, this digital input must have the level."""
    level: bool = True
    """Level of the input for which the loop repeats; high is true."""


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
    """Version of the file's format."""
    name: Name
    """Name of the program, also when it is saved."""
    arm: Name | None = None
    """Name of the arm, as in ``list_arms``; the only arm of the robot if left out."""
    gripper: Name | None = None
    """The one that the arm carries, if left out."""
    tool: ToolPose = field(default_factory=lambda: ToolPose(xyz=(0.0, 0.0, 0.0)))
    """The tool in the flange: targets, speeds and blends are those of its origin."""
    collision: CollisionRule = "ignore"
    """Reaction to collisions.  With ``refuse``, the program fails before a move on
    which the arm would collide; moves with ``until`` are not checked."""
    steps: tuple[Step, ...] = ()
    """Executed one after the other."""


def walk(
    steps: Sequence[Step], parents: StepPath = ()
) -> Iterator[tuple[StepPath, Step]]:
    """Yield every step with its path, a loop before its steps."""
    for number, step in enumerate(steps, 1):
        path = (*parents, number)
        yield path, step
        if isinstance(step, LoopStep):
            yield from walk(step.steps, path)


def require_shallow(program: Program) -> None:
    """Raise ControlError if loops are so deep that a program cannot be walked through.

    Of fewer that are still too many, a check says where they are.
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
    """Return a path as people write it: ``3.2``."""
    return ".".join(map(str, path))
