"""Joint commands in, joint efforts out: interfaces, servos, limits and brakes.

A joint is driven in one of three ways: by the effort of its controller; by the position
or velocity of its controller, through a servo; or by the brake, if no controller claims
it.

Without gains, Gazebo's position interface sets the joint position directly; ours never
does.  The effort of a servo is gravity compensation, plus a PD law scaled by the
inertia, so that every joint has the same response for any load, plus a slow integral
that compensates payloads.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from operator import mul, truediv
from typing import final

from tool0.description.model import (
    Interface,
    Joint,
    JointLimits,
    RobotModel,
    SafetyController,
)
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
"""Steps between updates of values that depend only on the pose and need not be exact:
the mass matrix of servos, and gravity compensation.  In 64 ms the fastest wrist turns
0.2 rad."""


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
        self._armatures = {
            name: model.transmission_by_joint[name].armature for name in self.interfaces
        }
        self._dynamics = JointDynamics(model, gravity)
        inertias = self._dynamics.mass_matrix([0.0] * len(joint_names)).diagonal()
        # Joints that others mimic are left to ROS's rule, as the recordings have it.
        masters = {joint.mimic.joint for joint in model.movable_joints if joint.mimic}
        inertia_by_joint = {
            joint.name: math.inf if joint.name in masters else float(inertia)
            for joint, inertia in zip(model.movable_joints, inertias, strict=True)
        }
        self._drives = {
            name: _effort_limits(
                model.joint_by_name[name],
                overrides.get(name),
                self._armatures[name],
                inertia_by_joint[name],
                dt,
            )
            for name in self.interfaces
        }
        self.limits = {name: drive.hard for name, drive in self._drives.items()}
        self.command = [0.0] * len(self.joint_names)
        """Commands of the claiming controllers, in the unit of their interface."""
        self._dt = dt
        self._to_model = [self.index[joint.name] for joint in model.movable_joints]
        """Engine index of each of the model's movable joints."""
        self._limiter = EffortLimiter(
            {self.index[name]: drive for name, drive in self._drives.items()}, dt
        )
        self._is_stopped = False
        self._steps = 0
        self._masses: list[tuple[int, list[float]]] = []
        """For each joint with a servo, its row of the mass matrix of these joints."""
        self._fastest: list[float] = []
        """For each joint with a servo, the largest acceleration of its drive."""
        self._servos: dict[int, Servo] = {}
        self._compensated = [
            self.index[name]
            for name, interface in self.interfaces.items()
            if interface is Interface.EFFORT
            and model.transmission_by_joint[name].gravity_compensation
        ]
        self._compensation: list[tuple[int, float]] = []
        self._gravity_effort = [0.0] * len(self.joint_names)
        """The part of the effort that compensates gravity [N·m | N], where a drive has
        limits."""
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
        """Give ``joints`` to a controller; they hold still until its first command."""
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
        """Brake every joint, even if claimed, or give the joints back."""
        self._is_stopped = engaged
        self.restart(state)

    @property
    def drive_limits(self) -> Mapping[str, DriveLimits]:
        """The current limits of drives below those of their joints, by joint."""
        found = self._limiter.drive_limits
        return {self.joint_names[i]: limits for i, limits in found.items()}

    def set_drive_limits(self, joint: str, limits: DriveLimits | None) -> None:
        """Limit the drive of ``joint`` below the joint's limits; None removes that."""
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
        """Give the joint the servo or brake for its claim and interface."""
        i, interface = self.index[name], self.interfaces[name]
        drive = self._drives[name]
        self._servos.pop(i, None)
        self._masses, self._compensation = [], []
        self._gravity_effort[i] = 0.0
        if name not in self._claimed or self._is_stopped:
            self._servos[i] = Brake()
        elif interface is Interface.POSITION:
            self._servos[i] = PositionServo(
                position,
                drive.hard,
                drive.soft,
                is_stiff=self._armatures[name] > 0.0,
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
        """Set the efforts for the accelerations that the servos request.

        The mass matrix is used for all joints together: in some poses (straight up)
        the joints of an arm are so coupled that servos with separate inertias vibrate.
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
        # Other drives must not compensate for one that is at its limit.
        self._fastest = list(map(truediv, efforts, inertia))
        return [
            (i, matrix[row, rows].tolist())
            for i, row in zip(self._servos, rows, strict=True)
        ]


def _effort_limits(
    joint: Joint,
    limits: JointLimits | None,
    armature: float,
    inertia: float,
    dt: float,
) -> EffortLimits:
    """Return the limits of a drive; ``inertia`` counts for a light joint."""
    hard = limits or joint.limits
    is_light = not armature and hard.effort * dt > hard.velocity * inertia
    return EffortLimits(
        hard=hard,
        soft=joint.safety,
        inertia=inertia if is_light else armature,
        is_light=is_light,
    )


BANDWIDTH = 80.0
"""Natural frequency of a servo [rad/s]; steps of 1 ms are 12 times shorter."""
DAMPING_RATIO = 1.0
STIFF_BANDWIDTH = 200.0
"""The same where a known rotor inertia dominates, whatever the load: a gripper grips
with its full force if it is stopped 5 mm or more from its target."""
STOPPED = 0.005
"""Lag from which a stiff servo counts as blocked [rad | m]."""
INTEGRAL_RATE = 4.0
"""Rate at which the integral compensates a constant disturbance [1/s]."""
BLOCKED = 0.02
"""Lag at a standstill from which any servo counts as blocked [rad | m]: more than a
load causes."""
STANDSTILL = 0.02
"""Velocity below which a brake considers the joint at rest [rad/s | m/s]."""


@final
class PositionServo:
    """Drives one joint to a position within its speed limit."""

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
        """Speed limit of a goal, below that of the joint [rad/s | m/s]."""

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float
    ) -> float:
        """Return the acceleration for ``command`` [rad/s² | m/s²]."""
        previous = self._target
        lag = previous - position
        is_stopped = self._is_stiff and abs(lag) > STOPPED
        if is_stopped and (command - position) * lag < 0.0:
            previous = position  # releasing need not wait for the joint to return
        slowest, fastest = velocity_window(previous, self._limits, self._soft)
        slowest, fastest = max(slowest, -self.speed), min(fastest, self.speed)
        step = min(max(command - previous, slowest * dt), fastest * dt)
        self._target = target = self._limits.clamp(previous + step)
        error = target - position
        stiffness = self._bandwidth**2
        is_blocked = abs(lag) > BLOCKED and abs(velocity) < STANDSTILL
        if is_stopped or is_blocked:
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
    """Slows one joint to rest and then holds it there."""

    def __init__(self) -> None:
        # With an integral, so that a payload does not make the joint creep.
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
