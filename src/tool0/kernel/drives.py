"""Tables and state of the drives of a robot, for ``drives.c``.

The classes mirror the structures in ``drives.h``.  The fields are documented in
``drives.h``.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from ctypes import POINTER, c_double, c_int, c_longlong
from typing import Any, final

from tool0.description.bodies import DynamicBody
from tool0.description.drive_limits import DriveLimits
from tool0.description.model import JointLimits, LinearOpening, SafetyController
from tool0.hardware.limits import DriveBounds
from tool0.hardware.robot_hardware import (
    POSE_PERIOD,
    DriveSetup,
    DriveState,
    DriveTable,
    RobotHardware,
)
from tool0.hardware.servos import (
    BANDWIDTH,
    BLOCKED,
    DAMPING_RATIO,
    INTEGRAL_RATE,
    STANDSTILL,
    STIFF_BANDWIDTH,
    STOPPED,
    ServoKind,
    ServoLaw,
    ServoState,
)
from tool0.hardware.speed_governor import (
    LARGEST_TURN,
    SWEEPS,
    TOLERANCE,
    GovernorSetup,
    GovernorState,
)


def _integers(*names: str) -> list[tuple[str, Any]]:
    return [(name, c_int) for name in names]


def _numbers(*names: str) -> list[tuple[str, Any]]:
    return [(name, c_double) for name in names]


@final
class Body(ctypes.Structure):
    """Structure ``DriveBody`` of ``drives.h``."""

    _fields_ = (
        *_integers("parent", "is_prismatic", "master", "joint"),
        *_numbers("multiplier", "mass"),
        ("placement", c_double * 12),
        ("center", c_double * 3),
        ("tensor", c_double * 9),
        *_numbers("armature"),
    )


class _Spring(ctypes.Structure):
    _fields_ = (
        *_integers("joint", "master"),
        *_numbers("multiplier", "stiffness", "reference"),
    )


class _Window(ctypes.Structure):
    _fields_ = (
        *_integers("is_soft"),
        *_numbers("velocity", "k_position", "soft_lower", "soft_upper"),
    )


class _Bounds(ctypes.Structure):
    _fields_ = (
        *_integers("joint", "limits_effort"),
        *_numbers("effort", "velocity", "lower", "upper"),
        *_numbers("rotor", "ease", "k_velocity"),
        ("window", _Window),
    )


class _Table(ctypes.Structure):
    _fields_ = (
        *_integers("n_joints", "n_bodies", "n_springs", "n_drives", "n_compensated"),
        *_integers("pose_period", "steps_per_command"),
        *_numbers("dt", "gravity"),
        *_numbers("damping_ratio", "velocity_bandwidth", "integral_rate"),
        *_numbers("stopped", "blocked", "standstill"),
        ("bodies", POINTER(Body)),
        ("springs", POINTER(_Spring)),
        ("bounds", POINTER(_Bounds)),
        ("compensated", POINTER(c_int)),
    )


class _Goal(ctypes.Structure):
    _fields_ = (
        *_integers("is_limited", "is_linear", "is_force"),
        *_numbers("grip", "speed", "pad_cos", "pad_sin", "pad_slope"),
    )


class _Servo(ctypes.Structure):
    _fields_ = (
        *_integers("joint", "kind", "is_stiff"),
        *_numbers("bandwidth", "lower", "upper", "integral_rate", "fastest"),
        ("window", _Window),
        *_numbers("target", "integral", "speed"),
    )


class _Governed(ctypes.Structure):
    _fields_ = (("joint", c_int), *_numbers("speed", "fast", "effort"))


class _Governor(ctypes.Structure):
    _fields_ = (
        *_integers("n_drives", "n_free", "has_mobility", "has_before", "sweeps"),
        *_integers("is_new"),
        *_numbers("tolerance", "largest_turn"),
        ("drives", POINTER(_Governed)),
        ("free", POINTER(c_int)),
        ("mobility", POINTER(c_double)),
        ("posture", POINTER(c_double)),
        ("before", POINTER(c_double)),
    )


class Drives(ctypes.Structure):
    """Structure ``Drives`` of ``drives.h``, for one copy of a robot."""

    _fields_ = (
        ("table", POINTER(_Table)),
        ("steps", c_longlong),
        ("masses_at", c_longlong),
        *_integers("has_compensation", "n_servos", "has_masses", "n_brakes"),
        ("gravity", POINTER(c_double)),
        ("before", POINTER(c_double)),
        ("compensation", POINTER(c_double)),
        ("goals", POINTER(_Goal)),
        ("servos", POINTER(_Servo)),
        ("masses", POINTER(c_double)),
        ("brakes", POINTER(c_int)),
        ("governed", POINTER(c_int)),
        ("governor", _Governor),
    )


@final
class NativeDrives:
    """Drives of one robot, in the memory that ``drives.c`` reads and writes.

    ``drives_efforts`` changes only values that are in ``RobotHardware.state``.  The
    setup is never changed.
    """

    struct: Drives
    """Argument of ``drives_efforts``."""

    def __init__(self, hardware: RobotHardware) -> None:
        """Allocate the memory, and copy the state of ``hardware``."""
        table = hardware.table
        self._hardware = hardware
        self._bounds = {drive.joint: drive for drive in table.bounds}
        self._rotors = {drive.joint for drive in table.bounds if drive.rotor < math.inf}
        self._setup = DriveSetup({}, {}, GovernorSetup(), (), (), [])
        n_joints, n_drives = len(hardware.joint_names), len(table.bounds)
        self._gravity: ctypes.Array[Any] = (c_double * n_joints)()
        self._before: ctypes.Array[Any] = (c_double * n_joints)(*[math.nan] * n_joints)
        self._compensation: ctypes.Array[Any] = (c_double * len(table.compensated))()
        self._goals = (_Goal * n_joints)()
        self._servos = (_Servo * n_drives)()
        self._masses: ctypes.Array[Any] = (c_double * n_drives**2)()
        self._brakes: ctypes.Array[Any] = (c_int * n_drives)()
        self._governed: ctypes.Array[Any] = (c_int * n_joints)()
        self._governor_drives = (_Governed * n_drives)()
        self._free: ctypes.Array[Any] = (c_int * n_drives)()
        self._mobility: ctypes.Array[Any] = (c_double * n_drives**2)()
        self._posture: ctypes.Array[Any] = (c_double * n_drives)()
        self._velocity: ctypes.Array[Any] = (c_double * n_joints)()
        self._table = table
        self.struct = Drives(
            ctypes.pointer(_table(n_joints, table)),
            *(0, -1, 0, 0, 0, 0),
            *(self._gravity, self._before, self._compensation),
            *(self._goals, self._servos, self._masses, self._brakes),
            self._governed,
            _Governor(
                *(0, 0, 0, 0, SWEEPS, 0, TOLERANCE, LARGEST_TURN),
                *(self._governor_drives, self._free, self._mobility),
                *(self._posture, self._velocity),
            ),
        )
        self.load()

    def load(self) -> None:
        """Copy the state of the hardware to this memory."""
        hardware, struct = self._hardware, self.struct
        setup, state, table = hardware.setup, hardware.state, hardware.table
        if table is not self._table:
            self._table = table
            struct.table = ctypes.pointer(_table(len(self._gravity), table))
        if setup != self._setup:
            self._load_setup(setup)
        struct.steps, struct.masses_at = state.steps, -1
        struct.has_compensation = bool(state.compensation)
        self._gravity[:] = state.gravity
        if state.compensation:
            self._compensation[:] = state.compensation
        for i, velocity in state.velocities.items():
            self._before[i] = math.nan if velocity is None else velocity
        before = state.governor.before
        struct.governor.has_before = bool(before)
        if before:
            self._velocity[:] = list(before)
        for servo, memory in zip(self._servos, state.servos, strict=False):
            servo.target, servo.integral, servo.speed = memory

    def store(self) -> None:
        """Copy the state in this memory to the hardware."""
        struct, before = self.struct, self._before
        if struct.masses_at >= 0:
            self._keep_masses()
        if struct.governor.is_new:
            self._keep_mobility()
        bounded = self._rotors | self._setup.drive_limits.keys()
        state = DriveState(
            struct.steps,
            self._gravity[:],
            self._compensation[:] if struct.has_compensation else [],
            {i: None if math.isnan(v := before[i]) else v for i in bounded},
            GovernorState(self._velocity[:] if struct.governor.has_before else ()),
            [
                ServoState(servo.target, servo.integral, servo.speed)
                for servo in self._servos[: struct.n_servos]
            ],
        )
        self._hardware.restore(self._setup, state)

    def _keep_masses(self) -> None:
        """Copy to the setup the masses that were computed in this memory."""
        n = self.struct.n_servos
        masses = tuple(self._masses[k * n : (k + 1) * n] for k in range(n))
        fastest = [servo.fastest for servo in self._servos[:n]]
        self._setup = self._setup._replace(masses=masses, fastest=fastest)
        self.struct.masses_at = -1

    def _keep_mobility(self) -> None:
        """Copy to the setup the mobility that was computed in this memory."""
        n = self.struct.governor.n_free
        mobility = tuple(tuple(self._mobility[k * n : (k + 1) * n]) for k in range(n))
        posture = tuple(self._posture[:n])
        governor = self._setup.governor._replace(mobility=mobility, posture=posture)
        self._setup = self._setup._replace(governor=governor)
        self.struct.governor.is_new = 0

    @property
    def drive_limits(self) -> Mapping[int, DriveLimits]:
        """Drive limits of the current goals by joint number."""
        return self._setup.drive_limits

    def set_drive_limits(self, index: int, limits: DriveLimits | None) -> None:
        """Limit a drive as ``RobotHardware`` does, but only in this copy."""
        current = dict(self._setup.drive_limits)
        current.pop(index, None)
        if limits is not None:
            current[index] = limits
        self._setup = self._setup._replace(drive_limits=current)
        self._set_goal(index, limits)
        if limits is not None:
            return
        for servo in self._servos[: self.struct.n_servos]:
            if servo.joint == index:
                self._gravity[index] = 0.0
                if servo.kind == ServoKind.POSITION:
                    servo.speed = math.inf

    def _load_setup(self, setup: DriveSetup) -> None:
        before, self._setup = self._setup, setup
        for i in before.drive_limits.keys() | setup.drive_limits.keys():
            self._set_goal(i, setup.drive_limits.get(i))
        struct = self.struct
        struct.n_brakes = len(setup.brakes)
        self._brakes[: len(setup.brakes)] = list(setup.brakes)
        if setup.governor != before.governor:
            self._load_governor(setup.governor)
        struct.n_servos, struct.has_masses = len(setup.servos), bool(setup.masses)
        if setup.servos != before.servos:
            for k, (i, law) in enumerate(setup.servos):
                self._servos[k] = _servo(i, law)
        if setup.masses:
            for servo, fastest in zip(self._servos, setup.fastest, strict=False):
                servo.fastest = fastest
            values = [value for row in setup.masses for value in row]
            self._masses[: len(values)] = values

    def _load_governor(self, setup: GovernorSetup) -> None:
        governor = self.struct.governor
        governor.n_drives, governor.n_free = len(setup.drives), len(setup.free)
        self._governed[:] = [0] * len(self._governed)
        for k, drive in enumerate(setup.drives):
            self._governor_drives[k] = _Governed(*drive)
            self._governed[drive.joint] = 1
        self._free[: len(setup.free)] = list(setup.free)
        values = [value for row in setup.mobility for value in row]
        self._mobility[: len(values)] = values
        self._posture[: len(setup.posture)] = list(setup.posture)
        governor.has_mobility = bool(values)

    def _set_goal(self, index: int, limits: DriveLimits | None) -> None:
        if limits is not None:
            self._goals[index] = goal_limits(limits)
            return
        self._goals[index] = _Goal()
        if index not in self._rotors:
            # No speed limiter stores the velocity of this joint.
            self._before[index] = math.nan


def native_bodies(
    bodies: Sequence[DynamicBody], joints: Sequence[int]
) -> ctypes.Array[Body]:
    """Return bodies for C; ``joints`` contains the joint numbers in the engine."""
    return (Body * len(bodies))(
        *(
            Body(
                body.parent,
                body.is_prismatic,
                body.master,
                joint,
                body.multiplier,
                body.mass,
                body.placement,
                body.center,
                body.tensor,
                body.armature,
            )
            for body, joint in zip(bodies, joints, strict=True)
        )
    )


def _table(n_joints: int, table: DriveTable) -> _Table:
    dynamics = table.dynamics
    bodies = native_bodies(dynamics.bodies, table.to_model)
    springs = [_Spring(*spring) for spring in dynamics.springs]
    bounds = [_drive(drive) for drive in table.bounds]
    n_compensated = len(table.compensated)
    return _Table(
        n_joints,
        len(bodies),
        len(springs),
        len(bounds),
        n_compensated,
        POSE_PERIOD,
        table.steps_per_command,
        table.dt,
        dynamics.gravity,
        DAMPING_RATIO,
        BANDWIDTH,
        INTEGRAL_RATE,
        STOPPED,
        BLOCKED,
        STANDSTILL,
        bodies,
        (_Spring * len(springs))(*springs),
        (_Bounds * len(bounds))(*bounds),
        (c_int * n_compensated)(*table.compensated),
    )


def _drive(drive: DriveBounds) -> _Bounds:
    return _Bounds(
        drive.joint,
        drive.soft is not None,
        drive.effort,
        drive.velocity,
        drive.lower,
        drive.upper,
        drive.rotor,
        drive.ease,
        drive.soft.k_velocity if drive.soft else 0.0,
        _window(drive.hard, drive.soft),
    )


def _window(hard: JointLimits, soft: SafetyController | None) -> _Window:
    if soft is None:
        return _Window(False, hard.velocity)
    limits = soft.soft_lower_limit, soft.soft_upper_limit
    return _Window(True, hard.velocity, soft.k_position, *limits)


def _servo(joint: int, law: ServoLaw) -> _Servo:
    return _Servo(
        joint,
        law.kind,
        law.is_stiff,
        STIFF_BANDWIDTH if law.is_stiff else BANDWIDTH,
        law.limits.lower,
        law.limits.upper,
        law.integral_rate,
        0.0,
        _window(law.limits, law.soft),
    )


def goal_limits(limits: DriveLimits) -> _Goal:
    """Return the limits of a goal as the structure ``DriveGoal`` of ``drives.h``."""
    effort = math.inf if limits.effort is None else limits.effort
    goal = _Goal(
        is_limited=True,
        is_force=limits.force is not None,
        grip=effort if limits.force is None else limits.force,
        speed=math.inf if limits.speed is None else limits.speed,
    )
    law = limits.gripper.law
    if isinstance(law, LinearOpening):
        goal.is_linear, goal.pad_slope = True, law.pad_slope
    else:
        goal.pad_cos, goal.pad_sin = law.pad_cos, law.pad_sin
    return goal
