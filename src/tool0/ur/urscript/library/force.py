"""Functions for force mode, freedrive, the tool, the payload and safety."""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal, TypeAlias, cast

from tool0.protocol.arm_motion import (
    EndForceMode,
    EndFreedrive,
    StartForceMode,
    StartFreedrive,
    ZeroWrench,
)
from tool0.protocol.control_box import SetPayload, SetTcp, StopProtectively
from tool0.protocol.state import Six
from tool0.ur.rtde.quantities import payload_moments
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import (
    Bool,
    Flags,
    Integer,
    Kind,
    Number,
    PoseLike,
    Spatial,
    Text,
    Vector,
)
from tool0.ur.urscript.values import Pose, Value, described
from tool0.ur.urscript_errors import ValueProblem

STANDARD_GRAVITY: Final = 9.82
"""Gravity in UR's programs [m/s²]. The difference from standard gravity is within the
tolerance of ``set_gravity``."""
_TOLERANCE: Final = 0.1
_ALL: Final = (True,) * 6
_SCREW: Final = (0.1, 0.1, 0.0, 0.17, 0.17, 0.17)
"""Tolerances of ``screw_driving`` along and about the axes without force [m, rad]."""
_BASE: Final = Pose((0.0,) * 6)


def _feature(value: Value) -> Value:
    if isinstance(value, Pose) or value in {"base", "tool"}:
        return value
    raise ValueProblem(f'a pose, "base" or "tool" is needed, not {described(value)}')


Feature: TypeAlias = Annotated[Value, Kind("a pose", _feature)]


async def force_mode(
    thread: Thread,
    task_frame: PoseLike,
    selection_vector: Flags,
    wrench: Spatial,
    type_: Integer,
    limits: Spatial,
) -> None:
    """Apply forces along some axes of a frame; move along the other axes."""
    if type_ not in {1, 2, 3}:
        raise ValueProblem(f"type is {type_}; it can be 1, 2 or 3")
    if min(limits) < 0.0:
        raise ValueProblem("the limits are not negative")
    execution = thread.execution
    request = StartForceMode(
        arm=thread.box.arm,
        frame=_six(task_frame),
        selection=selection_vector,
        wrench=wrench,
        kind=cast("Literal[1, 2, 3]", type_),
        limits=limits,
        tcp=thread.box.tcp,
        damping=execution.force_damping,
        gain_scaling=execution.force_gain,
    )
    await thread.box.call(request)


async def screw_driving(thread: Thread, f: Number, v_limit: Number) -> None:
    """Push along the TCP's z axis with a force [N] at a limited speed [m/s]."""
    if not v_limit > 0.0:
        raise ValueProblem(f"v_limit is {v_limit}; it is greater than 0")
    along_z = (False, False, True, False, False, False)
    frame, limits = Pose(thread.box.tcp_pose()), (*_SCREW[:2], v_limit, *_SCREW[3:])
    await force_mode(thread, frame, along_z, (0.0, 0.0, f, 0.0, 0.0, 0.0), 2, limits)


async def end_force_mode(thread: Thread) -> None:
    """Hold the arm's position along all axes again."""
    await thread.box.call(EndForceMode(arm=thread.box.arm))


def force_mode_set_damping(thread: Thread, damping: Number) -> None:
    """Set the damping (0 … 1) of the next force mode."""
    if not 0.0 <= damping <= 1.0:
        raise ValueProblem(f"damping is {damping}; it is from 0 to 1")
    thread.execution.force_damping = damping


def force_mode_set_gain_scaling(thread: Thread, scaling: Number) -> None:
    """Set the gain scaling (0 … 2) of the next force mode."""
    if not 0.0 <= scaling <= 2.0:
        raise ValueProblem(f"scaling is {scaling}; it is from 0 to 2")
    thread.execution.force_gain = scaling


def force_mode_get_damping(thread: Thread) -> float:
    """Return the damping of the next force mode."""
    return thread.execution.force_damping


def force_mode_get_gain_scaling(thread: Thread) -> float:
    """Return the gain scaling of the next force mode."""
    return thread.execution.force_gain


async def zero_ftsensor(thread: Thread) -> None:
    """Tare the reading of the force-torque sensor."""
    if thread.box.rtde_sensor.is_used:
        thread.box.rtde_sensor.tare()
        return
    await thread.box.call(ZeroWrench(arm=thread.box.arm))


async def freedrive_mode(
    thread: Thread, freeAxes: Flags = _ALL, feature: Feature = _BASE
) -> None:
    """Start freedrive, in which external forces move the arm along some axes."""
    pose = feature
    if feature == "base":
        pose = _BASE
    elif feature == "tool":
        pose = Pose(thread.box.tcp_pose())
    assert isinstance(pose, Pose)
    request = StartFreedrive(arm=thread.box.arm, axes=freeAxes, frame=_six(pose))
    await thread.box.call(request)


async def end_freedrive_mode(thread: Thread) -> None:
    """Hold the arm's position again."""
    await thread.box.call(EndFreedrive(arm=thread.box.arm))


async def set_tcp(thread: Thread, pose: PoseLike, tcp_name: Text = "") -> None:
    """Set the pose of the TCP in the flange's frame; the name has no effect."""
    del tcp_name
    box, tcp = thread.box, _six(pose)
    await box.call(SetTcp(arm=box.arm, pose=tcp))
    await thread.until_shown(lambda: box.tcp == tcp)


async def _set_payload(thread: Thread, mass: float, cog: Vector) -> None:
    if mass < 0.0:
        raise ValueProblem(f"the mass is {mass}; it is not negative")
    box = thread.box
    await box.call(SetPayload(arm=box.arm, mass=mass, center_of_gravity=cog))
    await thread.until_shown(lambda: box.state.payload.mass == mass)
    await box.call(ZeroWrench(arm=box.arm))


async def set_payload(thread: Thread, m: Number, cog: Vector | None = None) -> None:
    """Set mass [kg] and center of gravity (by default, the TCP); tare the sensor."""
    x, y, z, *_ = thread.box.tcp
    await _set_payload(thread, m, (x, y, z) if cog is None else cog)


async def set_payload_mass(thread: Thread, m: Number) -> None:
    """Set the mass of the payload [kg] and tare the sensor."""
    await _set_payload(thread, m, thread.box.state.payload.center_of_gravity)


async def set_payload_cog(thread: Thread, CoG: Vector) -> None:
    """Set the payload's center of gravity in the flange [m] and tare the sensor."""
    await _set_payload(thread, thread.box.state.payload.mass, CoG)


async def set_target_payload(
    thread: Thread,
    m: Number,
    cog: Vector,
    inertia: Spatial = (0.0,) * 6,
    transition_time: Number = 0,
) -> None:
    """Set mass and center of gravity; inertia and transition time are ignored."""
    if transition_time < 0.0 or min(inertia[:3]) < 0.0:
        raise ValueProblem("transition time and moments of inertia are not negative")
    await _set_payload(thread, m, cog)


def get_target_payload(thread: Thread) -> float:
    """Return the mass of the payload [kg]."""
    return thread.box.state.payload.mass


def get_target_payload_cog(thread: Thread) -> Value:
    """Return the payload's center of gravity in the flange's frame [m]."""
    return tuple(thread.box.state.payload.center_of_gravity)


def ft_rtde_input_enable(
    thread: Thread,
    enable: Bool,
    sensor_mass: Number = 0.0,
    sensor_measuring_offset: Vector = (0.0, 0.0, 0.0),
    sensor_cog: Vector = (0.0, 0.0, 0.0),
) -> None:
    """Select RTDE's external_force_torque or the wrist's built-in sensor.

    The sensor's mass has no effect, because the client sends the external wrench.
    """
    del sensor_mass, sensor_cog
    offset = sensor_measuring_offset if enable else None
    thread.box.rtde_sensor.set_offset(offset)


def get_freedrive_status() -> int:
    """Return 0; the resistance in freedrive does not increase near singularities."""
    return 0


def get_target_payload_inertia(thread: Thread) -> Value:
    """Return Ixx … Iyz at the payload's mass center, computed from the mass [kg·m²]."""
    return payload_moments(thread.box)


def position_deviation_warning(enabled: Bool, threshold: Number = 0.8) -> None:
    """Ignore the setting, because a protective stop has no prior warning."""
    del enabled
    if not 0.0 <= threshold <= 1.0:
        raise ValueProblem(f"threshold is {threshold}; it is from 0 to 1")


def set_gravity(d: Vector) -> None:
    """Accept the gravity of an upright base; other mountings are not supported."""
    x, y, z = d
    if math.hypot(x, y) > _TOLERANCE or abs(z - STANDARD_GRAVITY) > _TOLERANCE:
        raise ValueProblem(
            f"the base stands upright: [0, 0, {STANDARD_GRAVITY}] is needed"
        )


def get_gravity() -> Value:
    """Return the acceleration that opposes gravity in the base frame [m/s²]."""
    return (0.0, 0.0, STANDARD_GRAVITY)


async def protective_stop(thread: Thread) -> None:
    """Trigger a protective stop."""
    reason = "protective_stop() of the program"
    await thread.box.call(StopProtectively(arm=thread.box.arm, reason=reason))


def _six(pose: Pose) -> Six:
    a, b, c, d, e, f = pose
    return (a, b, c, d, e, f)


FUNCTIONS: Final[tuple[Function, ...]] = (
    function(force_mode, physical=True),
    function(screw_driving, physical=True),
    function(end_force_mode, "end_screw_driving"),
    function(freedrive_mode, physical=True),
    function(freedrive_mode, "teach_mode", physical=True),
    *(function(item) for item in (end_force_mode, end_freedrive_mode)),
    function(end_freedrive_mode, "end_teach_mode"),
    function(
        freedrive_mode, "freedrive_mode_no_incorrect_payload_check", physical=True
    ),
    *(function(item) for item in (force_mode_get_damping, force_mode_get_gain_scaling)),
    function(ft_rtde_input_enable),
    function(ft_rtde_input_enable, "enable_external_ft_sensor"),
    function(get_freedrive_status),
    function(get_target_payload_inertia),
    function(position_deviation_warning),
    *(function(item) for item in (force_mode_set_damping, force_mode_set_gain_scaling)),
    *(function(item) for item in (get_gravity, get_target_payload)),
    *(function(item) for item in (get_target_payload_cog, protective_stop)),
    *(function(item) for item in (set_gravity, set_payload, set_payload_cog)),
    *(function(item) for item in (set_payload_mass, set_target_payload, set_tcp)),
    function(zero_ftsensor),
)
