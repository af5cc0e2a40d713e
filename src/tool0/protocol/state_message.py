"""A robot's state in the form that connections send; readers choose its fields."""

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
"""Names of the fields that a reader of states can choose."""

Rows = tuple[tuple[float, ...], ...]


class RareChanges(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Fields that rarely change; absent if unchanged since the previous message."""

    is_paused: bool | UnsetType = UNSET
    """Whether simulated time is paused."""
    is_stopped: bool | UnsetType = UNSET
    """Whether the emergency stop is engaged."""
    fault: str | UnsetType | None = UNSET
    """Reason why the simulation has stopped until a reset."""
    speed: float | UnsetType | None = UNSET
    """Requested simulated time per wall time; null for as fast as possible."""
    stalls: tuple[Stall, ...] | UnsetType = UNSET
    """Joints that push at their effort limit without moving, each as [joint, effort,
    [[link, touched body], …], lag]."""
    gripping: tuple[str, ...] | UnsetType = UNSET
    """Names of the grippers whose fingers press on something from two sides."""
    real_time_factor: float | UnsetType = UNSET
    """Simulated time per wall time, over about the last second."""
    overruns: int | UnsetType = UNSET
    """Number of ticks since the start that began more than one control period late."""
    late_ticks: int | UnsetType = UNSET
    """Number of such ticks in about the last second of wall time."""
    controllers: tuple[ControllerStatus, ...] | UnsetType = UNSET
    """Status of every loaded controller."""
    control_boxes: tuple[ControlBoxState, ...] | UnsetType = UNSET
    """Control box of each arm."""
    scene: tuple[ObjectInfo, ...] | UnsetType = UNSET
    """Objects around the robot; changes when an object is added or removed."""


class ControllerMotion(Struct, frozen=True, kw_only=True):
    """Motion of a trajectory controller's joints, in the controller's order."""

    reference: Rows
    """Desired positions, velocities and accelerations [rad | m, per s, per s²]."""
    feedback: Rows
    """Measured positions and velocities [rad | m, per s]."""
    error: Rows
    """Errors of positions and velocities: ``reference`` minus ``feedback``."""
    time_from_start: float
    """Time on the trajectory [s]."""
    speed_scaling: float
    """Trajectory time per simulated time."""


@final
class StateMessage(RareChanges, frozen=True, kw_only=True, tag="state"):
    """The robot at one instant: the fields that the reader subscribed to.

    Sequences with one number per joint are in the order of ``joint_names``.
    """

    time: float
    """Simulated time [s]."""
    tick: int
    """Control periods since the start or the last reset."""
    missed: int = 0
    """Number of states before this one that a slow reader has lost."""
    joint_names: tuple[str, ...] | UnsetType = UNSET
    """Names of all movable joints; absent if unchanged."""
    position: tuple[float, ...] | UnsetType = UNSET
    """Measured positions [rad | m]."""
    velocity: tuple[float, ...] | UnsetType = UNSET
    """Measured velocities [rad/s | m/s]."""
    effort: tuple[float, ...] | UnsetType = UNSET
    """Efforts applied during the last step [N·m | N]."""
    desired: tuple[float | None, ...] | UnsetType = UNSET
    """Setpoints at this instant [rad | m]; null for joints that no controller moves by
    position."""
    desired_velocity: tuple[float | None, ...] | UnsetType = UNSET
    """Velocities of the setpoints [rad/s | m/s]; null for the same joints."""
    target: tuple[float | None, ...] | UnsetType = UNSET
    """End positions of the motions [rad | m]; null for the same joints."""
    command: tuple[float, ...] | UnsetType = UNSET
    """The last command of each joint, in the unit of its interface."""
    motions: Mapping[str, ControllerMotion] | UnsetType = UNSET
    """Motions of the subscribed trajectory controllers that are running, by name."""
    arms: Mapping[str, ArmSample] | UnsetType = UNSET
    """Motion of each arm and its source, by name."""
    wrenches: Mapping[str, Wrench] | UnsetType = UNSET
    """Wrench of each arm by name: the ``wrench`` of ``arms`` alone."""
    objects: tuple[tuple[Vector3, Quaternion], ...] | UnsetType = UNSET
    """Position [m] and orientation of each object of ``scene``, in its order, in the
    robot's root."""
    object_velocities: tuple[tuple[Vector3, Vector3], ...] | UnsetType = UNSET
    """Linear [m/s] and angular velocity [rad/s] of each object of ``scene``, in its
    order, in the axes of the root."""
    contacts: tuple[Contact, ...] | UnsetType = UNSET
    """Contacts with their forces, in the axes of the root."""
    scene_number: int | UnsetType = UNSET
    """Number of the ``scene`` to which ``objects`` belong; only in the panel's view."""


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
"""Fields that every snapshot has; the others are computed on demand."""


@final
class StateMask:
    """The fields that a reader of states wants."""

    def __init__(
        self,
        fields: Collection[StateField],
        controllers: Collection[str] = (),
        arms: Collection[str] = (),
    ) -> None:
        """Choose the fields.

        Args:
            fields: Names of the fields.
            controllers: Controllers in ``motions``; if left out, all.
            arms: Arms in ``arms`` and ``wrenches``; if left out, all.
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

    ``missed`` is the number of snapshots in between that the reader has lost.
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
    """Return the named fields that changed since ``before``, in their sent form."""
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
    """Return the snapshot in a message that follows ``before`` in a stream.

    The snapshot contains only the requested fields, and never ``motions``.
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
    """Return an arm's motion in its sent form, with its controller's setpoint."""
    return structs.replace(
        sample,
        joint_names=UNSET,
        setpoint=sample.setpoint or _arm_setpoint(snapshot, sample),
    )


# ---- what is computed of a snapshot --------------------------------------------------


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
    """Return the samples of the wanted arms that the snapshot contains."""
    samples = snapshot.arms
    return {name: samples[name] for name in mask.arms or samples if name in samples}


def _arms(snapshot: Snapshot, mask: StateMask) -> dict[str, ArmSample]:
    sampled = _sampled(snapshot, mask)
    return {name: filled(snapshot, sample) for name, sample in sampled.items()}


def _wrenches(snapshot: Snapshot, mask: StateMask) -> dict[str, Wrench]:
    sampled = _sampled(snapshot, mask)
    return {name: sample.wrench for name, sample in sampled.items()}


def _arm_setpoint(snapshot: Snapshot, sample: ArmSample) -> ArmSetpoint:
    """Return an arm's motion: a controller's desired motion, or the measured one."""
    joints = sample.joint_names
    assert not isinstance(joints, UnsetType)  # a sample of this process
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


# ---- what is read from a message -----------------------------------------------------

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
