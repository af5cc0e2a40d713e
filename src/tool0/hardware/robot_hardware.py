"""Joint commands in, joint efforts out: interfaces, servos, limits and brakes.

A joint is driven in one of three ways: by its controller's effort; by its controller's
position or velocity, through a servo; or by the brake, when nobody claims it.

Gazebo's position interface teleports the joint unless gains are given; ours never
does.  A servo's effort is gravity compensation plus a PD law on the joint's own
inertia, so that every joint answers alike whatever hangs on it, plus a slow integral
against payloads.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from operator import mul, truediv
from typing import final

from tool0.description.model import Interface, JointLimits, RobotModel, SafetyController
from tool0.description.transform import Vector3
from tool0.errors import ModelError, did_you_mean
from tool0.hardware.bodies import STANDARD_GRAVITY, JointDynamics
from tool0.hardware.engine import JointState
from tool0.hardware.limits import (
    DriveLimits,
    EffortLimiter,
    EffortLimits,
    velocity_window,
)

POSE_PERIOD = 64
"""Steps after which values that depend on the pose alone and need not be exact are
renewed: the mass matrix of servos, and gravity compensation.  In 64 ms the fastest
wrist turns 0.2 rad."""


@final
class RobotHardware:
    """The drives of the robot, as controllers see them.

    Every sequence has shape (n_joints,), ordered as ``joint_names``.
    """

    def __init__(
        self,
        model: RobotModel,
        joint_names: Sequence[str],
        dt: float,
        limits: Mapping[str, JointLimits] | None = None,
        gravity: Vector3 = STANDARD_GRAVITY,
    ) -> None:
        """Build the drives of the engine's ``joint_names`` for steps of ``dt`` [s].

        ``limits``, by joint, replace those of the URDF; ``gravity`` [m/s²] is in the
        axes of the robot's root.
        """
        overrides = dict(limits or {})
        for name in overrides:
            if name not in model.transmission_by_joint:
                hint = did_you_mean(name, list(model.transmission_by_joint))
                raise ModelError(f"limits given for undriven joint '{name}'{hint}")
        self.joint_names = tuple(joint_names)
        self.index = {name: i for i, name in enumerate(self.joint_names)}
        self.interfaces = {
            name: model.transmission_by_joint[name].interface
            for name in self.joint_names
            if name in model.transmission_by_joint
        }
        self._drives = {
            name: EffortLimits(
                hard=overrides.get(name, model.joint_by_name[name].limits),
                soft=model.joint_by_name[name].safety,
                armature=model.transmission_by_joint[name].armature,
            )
            for name in self.interfaces
        }
        self.limits = {name: drive.hard for name, drive in self._drives.items()}
        self.command = [0.0] * len(self.joint_names)
        """Commands of the claiming controllers, in the unit of their interface."""
        self._dt = dt
        self._dynamics = JointDynamics(model, gravity)
        self._to_model = [self.index[joint.name] for joint in model.movable_joints]
        """Engine index of each of the model's movable joints."""
        self._limiter = EffortLimiter(
            {self.index[name]: drive for name, drive in self._drives.items()}, dt
        )
        self._is_stopped = False
        self._steps = 0
        self._masses: list[tuple[int, list[float]]] = []
        """Of each joint with a servo, its row of those joints' mass matrix."""
        self._fastest: list[float] = []
        """Of each joint with a servo, the acceleration that its drive can give."""
        self._servos: dict[int, Servo] = {}
        self._compensated = [
            self.index[name]
            for name, interface in self.interfaces.items()
            if interface is Interface.EFFORT
            and model.transmission_by_joint[name].gravity_compensation
        ]
        self._compensation: list[tuple[int, float]] = []
        self._gravity_effort = [0.0] * len(self.joint_names)
        """The part of the effort that compensates gravity, where a drive has limits
        [N·m | N]."""
        self._claimed: set[str] = set()
        for name in self.interfaces:
            self._select_servo(name, 0.0)

    @property
    def is_stopped(self) -> bool:
        """Whether the emergency stop is engaged."""
        return self._is_stopped

    def restart(self, state: JointState) -> None:
        """Reset servos and brakes, and hold ``state`` from now on."""
        self._steps = 0
        self._limiter.restart()
        for name in self.interfaces:
            self._hold(name, state)

    def claim(self, joints: Sequence[str], state: JointState) -> None:
        """Hand ``joints`` to a controller, holding still until its first command."""
        for name in joints:
            self._claimed.add(name)
            self._limiter.set_drive_limits(self.index[name], None)
            self._hold(name, state)

    def _hold(self, name: str, state: JointState) -> None:
        """Command the joint to stay as it is, or no effort."""
        i, interface = self.index[name], self.interfaces[name]
        holds_position = interface is Interface.POSITION
        self.command[i] = state.position[i] if holds_position else 0.0
        self._select_servo(name, state.position[i])

    def release(self, joints: Sequence[str], state: JointState) -> None:
        """Take ``joints`` back: the brakes hold them."""
        for name in joints:
            self._claimed.discard(name)
            self._limiter.set_drive_limits(self.index[name], None)
            self._select_servo(name, state.position[self.index[name]])

    def set_stopped(self, engaged: bool, state: JointState) -> None:
        """Brake every joint whoever claims it, or give the joints back."""
        self._is_stopped = engaged
        self.restart(state)

    @property
    def drive_limits(self) -> Mapping[str, DriveLimits]:
        """The limits of drives below those of their joints now, by joint."""
        found = self._limiter.drive_limits
        return {self.joint_names[i]: limits for i, limits in found.items()}

    def set_drive_limits(self, joint: str, limits: DriveLimits | None) -> None:
        """Limit the drive of ``joint`` below the joint's limits; None lifts that."""
        i = self.index[joint]
        self._limiter.set_drive_limits(i, limits)
        servo = self._servos.get(i)
        if limits is None and servo is not None:
            self._gravity_effort[i] = 0.0
            if isinstance(servo, PositionServo):
                servo.speed = math.inf

    def efforts(self, state: JointState) -> list[float]:
        """Return the efforts that the drives apply in the next step [N·m | N]."""
        effort = self.command.copy()
        if self._compensated:
            self._add_gravity_compensation(effort, state)
        if self._servos:
            self._run_servos(effort, state)
        self._steps += 1
        self._limiter.saturate(effort, state, self._gravity_effort)
        return effort

    def _select_servo(self, name: str, position: float) -> None:
        """Give the joint the servo, or brake, that its claim and interface call for."""
        i, interface = self.index[name], self.interfaces[name]
        drive = self._drives[name]
        self._servos.pop(i, None)
        self._masses, self._compensation = [], []
        self._gravity_effort[i] = 0.0
        if name not in self._claimed or self._is_stopped:
            self._servos[i] = Brake()
        elif interface is Interface.POSITION:
            self._servos[i] = PositionServo(
                position, drive.hard, drive.soft, is_stiff=drive.armature > 0.0
            )
        elif interface is Interface.VELOCITY:
            self._servos[i] = VelocityServo(drive.hard, drive.soft)

    def _add_gravity_compensation(self, effort: list[float], state: JointState) -> None:
        """Add gravity compensation to the efforts of the drives that have it."""
        if not self._compensation or self._steps % POSE_PERIOD == 0:
            gravity = self._gravity(state)
            self._compensation = [(i, gravity[i]) for i in self._compensated]
            for i, compensation in self._compensation:
                self._gravity_effort[i] = compensation
        for i, compensation in self._compensation:
            effort[i] += compensation

    def _gravity(self, state: JointState) -> list[float]:
        """Return the effort that balances gravity [N·m | N], shape (n_joints,)."""
        position = [state.position[i] for i in self._to_model]
        ordered = [0.0] * len(position)
        loads = self._dynamics.static_effort(position)
        for i, load in zip(self._to_model, loads, strict=True):
            ordered[i] = load
        return ordered

    def _run_servos(self, effort: list[float], state: JointState) -> None:
        """Set the efforts that accelerate the joints as their servos want.

        All at once, by the mass matrix: in some poses (straight up) an arm's joints
        are so coupled that servos which each see their own inertia alone would shake.
        """
        if not self._masses or self._steps % POSE_PERIOD == 0:
            self._masses = self._servo_masses(state)
        gravity = self._gravity(state)
        command, dt = self.command, self._dt
        _, position, velocity, _ = state
        wanted = []
        for (i, servo), most in zip(self._servos.items(), self._fastest, strict=True):
            a = servo.acceleration(command[i], position[i], velocity[i], dt)
            wanted.append(-most if a < -most else min(a, most))
        for i, limits in self._limiter.drive_limits.items():
            limited = self._servos.get(i)
            if limited is not None:
                self._gravity_effort[i] = gravity[i]
            if isinstance(limited, PositionServo):
                _, limited.speed = limits.at(state.position[i])
        for i, masses in self._masses:
            effort[i] = gravity[i] + sum(map(mul, masses, wanted))

    def _servo_masses(self, state: JointState) -> list[tuple[int, list[float]]]:
        matrix = self._dynamics.mass_matrix([state.position[i] for i in self._to_model])
        rows = [self._to_model.index(i) for i in self._servos]
        efforts = [self.limits[self.joint_names[i]].effort for i in self._servos]
        inertia = matrix.diagonal()[rows].tolist()
        # Other drives must not make up for one that is at its limit.
        self._fastest = list(map(truediv, efforts, inertia))
        return [
            (i, matrix[row, rows].tolist())
            for i, row in zip(self._servos, rows, strict=True)
        ]


BANDWIDTH = 80.0
"""Natural frequency of a servo [rad/s]: 1 kHz steps are 12 times shorter."""
DAMPING_RATIO = 1.0
STIFF_BANDWIDTH = 200.0
"""The same where the inertia of a known rotor leads, whatever the joint carries: a
gripper squeezes with all its force from 5 mm on that are left to its target."""
STOPPED = 0.005
"""How far behind a stiff servo counts as stopped by something [rad | m]."""
INTEGRAL_RATE = 4.0
"""How fast a constant disturbance is taken over by the integral [1/s]."""
STANDSTILL = 0.02
"""Slowest motion that a brake does not call rest [rad/s | m/s]."""


@final
class PositionServo:
    """Drives one joint to a position, no faster than its limits allow."""

    def __init__(
        self,
        position: float,
        limits: JointLimits,
        soft: SafetyController | None = None,
        *,
        is_stiff: bool = False,
    ) -> None:
        self._limits = limits
        self._soft = soft
        self._is_stiff = is_stiff
        self._bandwidth = STIFF_BANDWIDTH if is_stiff else BANDWIDTH
        self._target = limits.clamp(position)
        self._integral = 0.0  # [1/s²], an acceleration
        self.speed = math.inf
        """Largest speed below the limits, as a goal may say [rad/s | m/s]."""

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float
    ) -> float:
        """Return the acceleration for ``command`` [rad/s² | m/s²]."""
        previous = self._target
        lag = previous - position
        is_stopped = self._is_stiff and abs(lag) > STOPPED
        if is_stopped and (command - position) * lag < 0.0:
            previous = position  # to let go, it need not come back first
        slowest, fastest = velocity_window(previous, self._limits, self._soft)
        slowest, fastest = max(slowest, -self.speed), min(fastest, self.speed)
        step = min(max(command - previous, slowest * dt), fastest * dt)
        self._target = target = self._limits.clamp(previous + step)
        error = target - position
        stiffness = self._bandwidth**2
        if is_stopped:
            self._integral = 0.0  # an obstacle is no load
        else:
            self._integral += stiffness * INTEGRAL_RATE * error * dt
        speed_error = (target - previous) / dt - velocity
        return (
            stiffness * error
            + 2.0 * DAMPING_RATIO * self._bandwidth * speed_error
            + self._integral
        )


@final
class VelocityServo:
    """Drives one joint at a velocity."""

    def __init__(
        self, limits: JointLimits, soft: SafetyController | None = None
    ) -> None:
        self._limits = limits
        self._soft = soft
        self._integral = 0.0  # [rad/s² | m/s²]

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float
    ) -> float:
        slowest, fastest = velocity_window(position, self._limits, self._soft)
        error = min(max(command, slowest), fastest) - velocity
        gain = 2.0 * DAMPING_RATIO * BANDWIDTH
        self._integral += gain * INTEGRAL_RATE * error * dt
        return gain * error + self._integral


@final
class Brake:
    """Slows one joint to rest and then keeps it where it came to rest."""

    def __init__(self) -> None:
        # With an integral: a payload must not keep the joint creeping.
        self._slow = VelocityServo(JointLimits())
        self._hold: tuple[PositionServo, float] | None = None

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float
    ) -> float:
        """Return the braking acceleration [rad/s² | m/s²]; ``command`` is not read."""
        if self._hold is None:
            if abs(velocity) > STANDSTILL:
                return self._slow.acceleration(0.0, position, velocity, dt)
            self._hold = PositionServo(position, JointLimits()), position
        servo, held_at = self._hold
        return servo.acceleration(held_at, position, velocity, dt)


Servo = PositionServo | VelocityServo | Brake
