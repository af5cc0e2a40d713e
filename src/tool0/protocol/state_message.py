"""A robot's state in the form that connections send, with the selected fields."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Final, Literal, final

from msgspec import UNSET, Struct, UnsetType, structs

from tool0.description.scene import SceneObject
from tool0.description.scene_state import Contact, ObjectState, Wrench
from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.controllers import ControllerStatus
from tool0.protocol.objects import ObjectInfo, info_of, object_of
from tool0.protocol.request import Quaternion, Vector3
from tool0.protocol.state import ArmSample, ArmSetpoint, JointSetpoint, Snapshot, Stall

StateField = Literal[
    "joint_names",
    "position",
    "velocity",
    "effort",
    "desired",
    "desired_velocity",
    "target",
    "command",
    "motions",
    "arms",
    "wrenches",
    "objects",
    "object_velocities",
    "contacts",
    "is_paused",
    "is_stopped",
    "fault",
    "speed",
    "stalls",
    "gripping",
    "real_time_factor",
    "overruns",
    "late_ticks",
    "controllers",
    "control_boxes",
    "scene",
]
"""Names of the fields that a reader of states can select."""

Rows = tuple[tuple[float, ...], ...]


class RareChanges(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Fields that rarely change; a field is absent if it has not changed."""

    is_paused: bool | UnsetType = UNSET
    """Whether simulated time is paused."""
    is_stopped: bool | UnsetType = UNSET
    """Whether the emergency stop is engaged."""
    fault: str | UnsetType | None = UNSET
    """Reason why the simulation is stopped until a reset; null if it is not stopped."""
    speed: float | UnsetType | None = UNSET
    """Requested ratio of simulated time to wall time; null if time passes as fast as
    possible."""
    stalls: tuple[Stall, ...] | UnsetType = UNSET
    """Joints that push at their effort limit without moving, each as [joint, effort,
    [[link, touched body], …], lag]."""
    gripping: tuple[str, ...] | UnsetType = UNSET
    """Names of the grippers that press on an object from two sides."""
    real_time_factor: float | UnsetType = UNSET
    """Ratio of simulated time to wall time, measured over roughly the last second."""
    overruns: int | UnsetType = UNSET
    """Number of ticks that have begun more than one control period late since the
    start."""
    late_ticks: int | UnsetType = UNSET
    """Number of ticks that began more than one control period late over roughly the
    last second of wall time."""
    controllers: tuple[ControllerStatus, ...] | UnsetType = UNSET
    """Status of every loaded controller."""
    control_boxes: tuple[ControlBoxState, ...] | UnsetType = UNSET
    """Control box of each arm."""
    scene: tuple[ObjectInfo, ...] | UnsetType = UNSET
    """Objects around the robot; the field changes when an object is added or
    removed."""


class ControllerMotion(Struct, frozen=True, kw_only=True):
    """Motion of the joints of a trajectory controller, in the controller's order."""

    reference: Rows
    """Desired positions [rad | m], velocities [rad/s | m/s] and accelerations [rad/s² |
    m/s²]."""
    feedback: Rows
    """Measured positions [rad | m] and velocities [rad/s | m/s]."""
    error: Rows
    """Errors of positions [rad | m] and velocities [rad/s | m/s]: ``reference`` minus
    ``feedback``."""
    time_from_start: float
    """Time on the trajectory [s]."""
    speed_scaling: float
    """Ratio of trajectory time to simulated time."""


@final
class StateMessage(RareChanges, frozen=True, kw_only=True, tag="state"):
    """The state of the robot at one instant: the fields that the reader requested.

    A sequence with one number per joint is in the order of ``joint_names``.
    """

    time: float
    """Simulated time [s]."""
    tick: int
    """Number of control periods since the start or the last reset."""
    missed: int = 0
    """Number of states that were lost before this state because the reader was slow."""
    joint_names: tuple[str, ...] | UnsetType = UNSET
    """Names of all movable joints; absent if the names have not changed."""
    position: tuple[float, ...] | UnsetType = UNSET
    """Measured positions [rad | m]."""
    velocity: tuple[float, ...] | UnsetType = UNSET
    """Measured velocities [rad/s | m/s]."""
    effort: tuple[float, ...] | UnsetType = UNSET
    """Efforts applied during the last step [N·m | N]."""
    desired: tuple[float | None, ...] | UnsetType = UNSET
    """Position setpoints at this instant [rad | m]; null for joints whose position no
    controller commands."""
    desired_velocity: tuple[float | None, ...] | UnsetType = UNSET
    """Velocities of the setpoints [rad/s | m/s]; null for joints whose position no
    controller commands."""
    target: tuple[float | None, ...] | UnsetType = UNSET
    """End positions of the motions [rad | m]; null for joints whose position no
    controller commands."""
    command: tuple[float, ...] | UnsetType = UNSET
    """The last command of each joint, in the unit of its interface."""
    motions: Mapping[str, ControllerMotion] | UnsetType = UNSET
    """Motions of the subscribed trajectory controllers that are running, by name."""
    arms: Mapping[str, ArmSample] | UnsetType = UNSET
    """Motion of each arm and the source of the motion, by arm name."""
    wrenches: Mapping[str, Wrench] | UnsetType = UNSET
    """Wrench of each arm by arm name: only the field ``wrench`` of ``arms``."""
    objects: tuple[tuple[Vector3, Quaternion], ...] | UnsetType = UNSET
    """Position [m] and orientation of each object in the robot's root frame, in the
    order of ``scene``."""
    object_velocities: tuple[tuple[Vector3, Vector3], ...] | UnsetType = UNSET
    """Linear [m/s] and angular velocity [rad/s] of each object in the axes of the
    robot's root frame, in the order of ``scene``."""
    contacts: tuple[Contact, ...] | UnsetType = UNSET
    """Contacts with their forces, in the axes of the robot's root frame."""
    scene_number: int | UnsetType = UNSET
    """Number of the ``scene`` that ``objects`` refers to; only in the panel's view."""


_SETPOINTS: Final = ("desired", "desired_velocity", "target")
_NO_SETPOINT: Final = (None, None, None)
_RARE: Final = ("joint_names", *RareChanges.__struct_fields__)
_COPIED: Final = ("position", "velocity", "effort", "command", "contacts")
SNAPSHOT_FIELDS: Final[tuple[StateField, ...]] = (
    *("joint_names", "position", "velocity", "effort"),
    *("desired", "desired_velocity", "target", "objects", "object_velocities"),
    *("is_paused", "is_stopped", "fault", "speed", "stalls", "gripping"),
    *("real_time_factor", "overruns", "late_ticks"),
    *("controllers", "control_boxes", "scene"),
)
"""Fields that every snapshot has; the other fields are computed on demand."""


@final
class StateMask:
    """The fields that a reader of states has selected."""

    def __init__(
        self,
        fields: Collection[StateField],
        controllers: Collection[str] = (),
        arms: Collection[str] = (),
    ) -> None:
        """Select the fields.

        Args:
            fields: Names of the fields.
            controllers: Controllers in ``motions``; the default is all controllers.
            arms: Arms in ``arms`` and ``wrenches``; the default is all arms.
        """
        self.controllers = controllers
        self.arms = arms
        self.needs_commands = "command" in fields
        self.needs_arms = "arms" in fields or "wrenches" in fields
        self.needs_contacts = "contacts" in fields
        self.rare = tuple(name for name in _RARE if name in fields)
        self.copied = tuple(name for name in _COPIED if name in fields)
        self.setpoints = tuple(
            (name, k) for k, name in enumerate(_SETPOINTS) if name in fields
        )
        self.computed = tuple(item for item in _COMPUTED.items() if item[0] in fields)


def state_message(
    snapshot: Snapshot,
    mask: StateMask,
    before: Snapshot | None = None,
    *,
    missed: int = 0,
) -> StateMessage:
    """Return the subscribed fields of a snapshot that follows ``before`` in a stream.

    ``missed`` is the number of snapshots between ``before`` and ``snapshot`` that the
    reader has lost.
    """
    found = changes(snapshot, before, mask.rare)
    for name in mask.copied:
        found[name] = getattr(snapshot, name)
    if mask.setpoints:
        setpoints = snapshot.setpoints()
        rows = [setpoints.get(joint, _NO_SETPOINT) for joint in snapshot.joint_names]
        for name, k in mask.setpoints:
            found[name] = tuple([row[k] for row in rows])
    for name, compute in mask.computed:
        found[name] = compute(snapshot, mask)
    return StateMessage(time=snapshot.time, tick=snapshot.tick, missed=missed, **found)


def changes(
    snapshot: Snapshot, before: Snapshot | None, names: Collection[str]
) -> dict[str, Any]:
    """Return the named fields that have changed since ``before``, in the sent form."""
    found = {}
    for name in names:
        value = getattr(snapshot, name)
        if before is not None:
            old = getattr(before, name)
            if value is old or value == old:
                continue
        found[name] = tuple(map(info_of, value)) if name == "scene" else value
    return found


def snapshot_of(message: StateMessage, before: Snapshot | None = None) -> Snapshot:
    """Return the snapshot that a message contains.

    ``before`` is the previous snapshot of the stream.  The snapshot contains only the
    requested fields, and never contains ``motions``.
    """
    found = {
        name: value for name in _READ if (value := getattr(message, name)) is not UNSET
    }
    scene = () if before is None else before.scene
    if not isinstance(message.scene, UnsetType):
        scene = tuple(map(object_of, message.scene))
    kept = {} if before is None else {name: getattr(before, name) for name in _KEPT}
    names = found.get("joint_names", kept.get("joint_names", ()))
    return Snapshot(
        **{
            **_NOTHING,
            **kept,
            **found,
            "scene": scene,
            "objects": _objects(message, scene),
            "received_setpoints": _received(message, names),
        }
    )


def filled(snapshot: Snapshot, sample: ArmSample) -> ArmSample:
    """Return an arm's motion in the sent form, with the controller's setpoint."""
    return structs.replace(
        sample,
        joint_names=UNSET,
        setpoint=sample.setpoint or _arm_setpoint(snapshot, sample),
    )


# ---- fields that are computed from a snapshot ----------------------------------------


def _motions(snapshot: Snapshot, mask: StateMask) -> dict[str, ControllerMotion]:
    running = snapshot.controller_setpoints
    wanted = mask.controllers or running
    return {name: _motion(snapshot, name) for name in wanted if name in running}


def _motion(snapshot: Snapshot, controller: str) -> ControllerMotion:
    state = snapshot.controller_setpoints[controller].state()
    desired, actual, error = state.desired, state.actual, state.error
    return ControllerMotion(
        reference=(desired.positions, desired.velocities, desired.accelerations),
        feedback=(actual.positions, actual.velocities),
        error=(error.positions, error.velocities),
        time_from_start=actual.time_from_start,
        speed_scaling=state.speed_scaling,
    )


def _sampled(snapshot: Snapshot, mask: StateMask) -> dict[str, ArmSample]:
    """Return the samples of the selected arms that the snapshot contains."""
    samples = snapshot.arms
    return {name: samples[name] for name in mask.arms or samples if name in samples}


def _arms(snapshot: Snapshot, mask: StateMask) -> dict[str, ArmSample]:
    sampled = _sampled(snapshot, mask)
    return {name: filled(snapshot, sample) for name, sample in sampled.items()}


def _wrenches(snapshot: Snapshot, mask: StateMask) -> dict[str, Wrench]:
    sampled = _sampled(snapshot, mask)
    return {name: sample.wrench for name, sample in sampled.items()}


def _arm_setpoint(snapshot: Snapshot, sample: ArmSample) -> ArmSetpoint:
    """Return the desired motion of the arm's controller, or the measured motion."""
    joints = sample.joint_names
    assert not isinstance(joints, UnsetType)  # the sample is from this process
    for setpoint in snapshot.controller_setpoints.values():
        motion = setpoint.desired_motion(joints, snapshot.time)
        if motion is not None:
            return motion
    index = snapshot.joint_names.index
    return ArmSetpoint(
        tuple(snapshot.position[index(joint)] for joint in joints),
        tuple(snapshot.velocity[index(joint)] for joint in joints),
        (0.0,) * len(joints),
    )


_COMPUTED: Final[Mapping[str, Callable[[Snapshot, StateMask], Any]]] = {
    "motions": _motions,
    "arms": _arms,
    "wrenches": _wrenches,
    "objects": lambda snapshot, mask: tuple(
        (item.position, item.quat_wxyz) for item in snapshot.objects
    ),
    "object_velocities": lambda snapshot, mask: tuple(
        (item.linear, item.angular) for item in snapshot.objects
    ),
}


# ---- fields that are read from a message ---------------------------------------------

_KEPT: Final = tuple(name for name in _RARE if name != "scene")
_READ: Final = (*_KEPT, *_COPIED, "time", "tick", "arms")
_NOTHING: Final[Mapping[str, Any]] = dict.fromkeys(
    ("joint_names", "position", "velocity", "effort", "controllers"), ()
)


def _objects(
    message: StateMessage, scene: tuple[SceneObject, ...]
) -> tuple[ObjectState, ...]:
    poses, velocities = message.objects, message.object_velocities
    if isinstance(poses, UnsetType):
        return ()
    if isinstance(velocities, UnsetType):
        return tuple(
            ObjectState(item.name, *pose)
            for item, pose in zip(scene, poses, strict=True)
        )
    return tuple(
        ObjectState(item.name, *pose, *velocity)
        for item, pose, velocity in zip(scene, poses, velocities, strict=True)
    )


def _received(
    message: StateMessage, joint_names: tuple[str, ...]
) -> dict[str, JointSetpoint]:
    columns: list[Any] = [getattr(message, name) for name in _SETPOINTS]
    if UNSET in columns:
        return {}
    rows = zip(joint_names, *columns, strict=True)
    return {
        joint: JointSetpoint(*setpoint)
        for joint, *setpoint in rows
        if setpoint[0] is not None
    }
