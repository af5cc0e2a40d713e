"""Converts joint commands to joint efforts, with interfaces, servos, limits and brakes.

A joint's drive either applies the effort that a controller commands, or uses a servo to
follow the position or velocity that a controller commands.  If no controller claims the
joint, or during an emergency stop, the joint's drive is off, and the engine holds the
joint with its brake under any load.  A drive may offer several command interfaces; the
claim selects the interface.

Without gains, Gazebo's position interface sets the joint position directly; tool0's
position interface never does.  The effort of a servo is the sum of three terms: gravity
compensation; a PD law scaled by the inertia, so that every joint has the same response
under any load; and a slow integral that compensates payloads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from operator import add, mul
from typing import NamedTuple, final

import numpy as np

from tool0.description.bodies import (
    ROTOR_INERTIA,
    STANDARD_GRAVITY,
    DynamicsTable,
    JointDynamics,
    Matrix,
)
from tool0.description.drive_limits import DriveLimits
from tool0.description.finding import quoted
from tool0.description.model import (
    FLANGE,
    Interface,
    Joint,
    JointLimits,
    RobotModel,
    Transmission,
)
from tool0.description.payload import Payload
from tool0.description.transform import Vector3
from tool0.errors import ClaimError, ControlError, ModelError, did_you_mean
from tool0.hardware.drive_dynamics import DriveDynamics
from tool0.hardware.engine import JointState
from tool0.hardware.limits import DriveBounds, EffortLimiter, EffortLimits
from tool0.hardware.servos import (
    INTEGRAL_RATE,
    PositionServo,
    Servo,
    ServoLaw,
    ServoState,
    VelocityServo,
    servo_of,
)
from tool0.hardware.speed_governor import (
    FAST,
    GovernedDrive,
    GovernorSetup,
    GovernorState,
    SpeedGovernor,
)

POSE_PERIOD = 64
"""Number of steps between updates of the values that depend only on the pose and need
not be exact.  The values are the mass matrix of the servos, and gravity compensation.
In 64 ms, the fastest wrist turns 0.2 rad."""


EffortLaw = Callable[[JointState, float], Sequence[float]]
"""Function that returns joint efforts [N·m | N] for a state and a step length [s]."""


class DriveTable(NamedTuple):
    """Data of a robot's drives that change only when a payload is declared."""

    dt: float
    """Length of a step [s]."""
    to_model: tuple[int, ...]
    """Engine index of each of the model's movable joints."""
    dynamics: DynamicsTable
    bounds: tuple[DriveBounds, ...]
    compensated: tuple[int, ...]
    """Indices of the joints whose drives compensate gravity."""
    steps_per_command: int
    """Number of steps in which a position servo reaches a command."""


class DriveSetup(NamedTuple):
    """Data that change rarely: upon requests, and when the mass matrix is updated."""

    drive_limits: Mapping[int, DriveLimits]
    """Limits set by goals, by joint index."""
    brakes: Mapping[int, float]
    """Largest torque of each engaged brake, by joint index [N·m | N]."""
    governor: GovernorSetup
    servos: tuple[tuple[int, ServoLaw], ...]
    """Joints with servos, by index, and their servo laws, in the order of the mass
    matrix."""
    masses: tuple[list[float], ...]
    """Rows of the mass matrix of the joints with servos; empty until the matrix is
    computed."""
    fastest: list[float]
    """Largest acceleration of each joint with a servo [rad/s² | m/s²]."""


class DriveState(NamedTuple):
    """Data that change in each step."""

    steps: int
    """Number of steps since the last restart."""
    gravity: list[float]
    """The part of the effort that compensates gravity, for drives with limits set by a
    goal [N·m | N], shape (n_joints,)."""
    compensation: list[float]
    """Gravity compensation [N·m | N] of the drives that compensate gravity; empty until
    it is computed."""
    velocities: Mapping[int, float | None]
    """State of the speed limiters, by joint index."""
    governor: GovernorState
    servos: list[ServoState]


class SavedDrives(NamedTuple):
    """State of the drives at one instant, including claims and commands."""

    setup: DriveSetup
    state: DriveState
    claimed: Mapping[str, Interface]
    command: tuple[float, ...]


@final
class RobotHardware:
    """The interface through which controllers use the robot's drives.

    Every sequence has shape (n_joints,) and is in the order of ``joint_names``.
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

        The ``limits`` of a joint, by joint name, replace the limits in the URDF.
        ``gravity`` [m/s²] is in the axes of the robot's root.
        """
        overrides = dict(limits or {})
        for name in overrides:
            if name not in model.transmission_by_joint:
                hint = did_you_mean(name, list(model.transmission_by_joint))
                raise ModelError(f"limits given for undriven joint '{name}'{hint}")
        self.joint_names = tuple(joint_names)
        self.index = {name: i for i, name in enumerate(self.joint_names)}
        self.interfaces = {
            name: model.transmission_by_joint[name].interfaces
            for name in self.joint_names
            if name in model.transmission_by_joint
        }
        """The command interfaces of each driven joint, with the preferred interface
        first."""
        self._armatures = {
            name: model.transmission_by_joint[name].armature for name in self.interfaces
        }
        self._dynamics = DriveDynamics(model, self.joint_names, dt, gravity)
        self.speed_scaling = {
            flange.removesuffix(FLANGE): 1.0 for flange in model.flanges
        }
        """Factor by which the trajectories of each arm are slowed down, by the arm's
        prefix.  A controller reads the factor once per tick."""
        self.gripper_delay = 0.0
        """Longest delay until a gripper's state reflects a command [s]."""
        # Joints that other joints mimic follow ROS's speed rule, to match the
        # recordings.
        masters = {joint.mimic.joint for joint in model.movable_joints if joint.mimic}
        self._drives = {
            name: _effort_limits(
                model.joint_by_name[name],
                overrides.get(name),
                model.transmission_by_joint[name],
                math.inf if name in masters else self._dynamics.inertias[name],
                dt,
            )
            for name in self.interfaces
        }
        self.limits = {name: drive.hard for name, drive in self._drives.items()}
        self.command = [0.0] * len(self.joint_names)
        """Commands of the claiming controllers, in the units of their interfaces."""
        self._dt = dt
        self._limiter = EffortLimiter(
            {self.index[name]: drive for name, drive in self._drives.items()}, dt
        )
        self._is_stopped = False
        self._steps = 0
        self._masses: list[tuple[int, list[float]]] = []
        """Joints with servos, by index, and their rows of the mass matrix."""
        self._fastest: list[float] = []
        """Largest acceleration of each joint with a servo [rad/s² | m/s²]."""
        self._servos: dict[int, Servo] = {}
        self._brakes: Mapping[int, float] = {}
        self._rotors: Mapping[int, float] = {}
        self._governable = [
            GovernedDrive(
                self.index[name],
                drive.hard.velocity,
                FAST * drive.hard.velocity,
                drive.hard.effort,
            )
            for name, drive in self._drives.items()
            if not self._armatures[name] and name not in masters
        ]
        """Drives that can stay within their speed limits only if the moved mass is
        known."""
        self._governor = SpeedGovernor()
        self._compensated = [
            self.index[name]
            for name, interfaces in self.interfaces.items()
            if Interface.EFFORT in interfaces
            and model.transmission_by_joint[name].gravity_compensation
        ]
        self._compensation: list[tuple[int, float]] = []
        self._gravity_effort = [0.0] * len(self.joint_names)
        """The part of the effort that compensates gravity, for drives with limits set
        by a goal [N·m | N]."""
        self._effort_laws: tuple[tuple[list[int], EffortLaw], ...] = ()
        """Effort laws that replace commands, with the indices of the joints that each
        law drives."""
        self._claimed: dict[str, Interface] = {}
        """The interface through which each claimed joint is commanded."""
        for name in self.interfaces:
            self._select_servo(name, 0.0)
        self._table: DriveTable | None = None
        self._steps_per_command = 1

    def set_steps_per_command(self, n_steps: int) -> None:
        """After a restart, expect each controller's command every ``n_steps`` steps.

        A position servo moves at constant velocity between commands, like a real drive.
        """
        self._steps_per_command = n_steps
        self._table = None

    @property
    def is_stopped(self) -> bool:
        """Whether the emergency stop is engaged."""
        return self._is_stopped

    @property
    def brakes(self) -> Mapping[int, float]:
        """Largest torque of each engaged brake [N·m | N], by index, for the engine.

        The torque of a brake equals its drive's largest torque, because no datasheet
        gives a brake's torque.  The brake can therefore hold any load that the drive
        can move.  The mapping is the same object until a brake changes.
        """
        return self._brakes

    @property
    def rotors(self) -> Mapping[int, float]:
        """Rotor inertia that acts on joints [kg·m²], by joint index, for the engine.

        The mapping contains only joints that effort laws drive, because the response of
        a servo does not depend on this inertia.  The inertia is added to the armature
        in the description.  The mapping is the same object until a claim changes it.
        """
        return self._rotors

    def restart(self, state: JointState) -> None:
        """Reset servos, and hold the joint positions in ``state``."""
        self._steps = 0
        self._limiter.restart()
        for name in self.interfaces:
            self._hold(name, state)

    @property
    def claimed(self) -> Mapping[str, Interface]:
        """The interface through which each claimed joint is commanded, by name."""
        return self._claimed

    def claim(
        self, joints: Sequence[str], interface: Interface, state: JointState
    ) -> None:
        """Claim ``joints`` for a controller.

        The joints stay at rest until the controller's first command.

        Raises:
            ControlError: If a drive does not offer ``interface``.
            ClaimError: If a joint is already claimed.  No claims are changed.
        """
        for name in joints:
            offered = self.interfaces.get(name, ())
            self._check_claim(name, interface, offered)
        self._claim(joints, interface, state)

    def claim_servos(self, joints: Sequence[str], state: JointState) -> None:
        """Claim ``joints`` for position commands, even if drives offer only efforts.

        Raises:
            ControlError: If a joint has no drive.
            ClaimError: If a joint is already claimed.  No claims are changed.
        """
        for name in joints:
            offered = (Interface.POSITION,) if name in self.interfaces else ()
            self._check_claim(name, Interface.POSITION, offered)
        self._claim(joints, Interface.POSITION, state)

    def claim_efforts(
        self,
        joints: Sequence[str],
        law: EffortLaw,
        state: JointState,
        *,
        with_rotors: bool = False,
    ) -> None:
        """Claim ``joints`` for an effort law, whatever interfaces their drives offer.

        Commands to the claimed joints are ignored.  The kernel cannot run an effort
        law.  ``with_rotors`` adds the rotors' inertia to the joints.

        Raises:
            ControlError: If a joint has no drive.
            ClaimError: If a joint is already claimed.  No claims are changed.
        """
        for name in joints:
            offered = (Interface.EFFORT,) if name in self.interfaces else ()
            self._check_claim(name, Interface.EFFORT, offered)
        self._claim(joints, Interface.EFFORT, state)
        indices = [self.index[name] for name in joints]
        self._effort_laws = (*self._effort_laws, (indices, law))
        if with_rotors:
            own = {self.index[name]: self.rotor_inertia(name) for name in joints}
            self._use_rotors({**self._rotors, **own})

    def _claim(
        self, joints: Sequence[str], interface: Interface, state: JointState
    ) -> None:
        for name in joints:
            self._claimed[name] = interface
            self._limiter.set_drive_limits(self.index[name], None)
            self._hold(name, state)

    def _check_claim(
        self, name: str, interface: Interface, offered: Sequence[Interface]
    ) -> None:
        if interface not in offered:
            names = quoted(item.value for item in offered) if offered else "none"
            raise ControlError(
                f"joint '{name}' takes no commands through '{interface.value}'; "
                f"its command interfaces: {names}"
            )
        current = self._claimed.get(name)
        if current is not None:
            raise ClaimError(
                f"joint '{name}' cannot be commanded through '{interface.value}': "
                f"a controller commands it through '{current.value}'; stop that first"
            )

    def _hold(self, name: str, state: JointState) -> None:
        """Command the joint's current position, or zero velocity or effort."""
        i = self.index[name]
        holds_position = self._claimed.get(name) is Interface.POSITION
        self.command[i] = state.position[i] if holds_position else 0.0
        self._select_servo(name, state.position[i])

    def rotor_inertia(self, joint: str) -> float:
        """Return the rotor inertia that a joint's description omits [kg·m² | kg]."""
        return 0.0 if self._armatures[joint] else ROTOR_INERTIA

    def _use_rotors(self, rotors: Mapping[int, float]) -> None:
        if rotors != self._rotors:
            self._rotors = rotors
            self._limiter.add_inertias(rotors)
            self._choose_governed()

    def compensates_gravity(self, joint: str) -> bool:
        """Return whether a drive compensates gravity in addition to its command."""
        return self.index[joint] in self._compensated

    def release(self, joints: Sequence[str], state: JointState) -> None:
        """Release the claims of ``joints``.  The brakes then hold the joints."""
        indices = {self.index[name] for name in joints}
        self._effort_laws = tuple(
            item for item in self._effort_laws if indices.isdisjoint(item[0])
        )
        self._use_rotors({i: x for i, x in self._rotors.items() if i not in indices})
        for name in joints:
            self._claimed.pop(name, None)
            self._limiter.set_drive_limits(self.index[name], None)
            self._select_servo(name, state.position[self.index[name]])

    def set_stopped(self, engaged: bool, state: JointState) -> None:
        """Brake every joint, even if it is claimed, or return the joints to control."""
        self._is_stopped = engaged
        self.restart(state)

    @property
    def drive_limits(self) -> Mapping[str, DriveLimits]:
        """Limits in effect for drives that goals limit more tightly than their joints.

        The limits are given by joint name.
        """
        found = self._limiter.drive_limits
        return {self.joint_names[i]: limits for i, limits in found.items()}

    def set_drive_limits(self, joint: str, limits: DriveLimits | None) -> None:
        """Limit a drive more tightly than its joint.

        None removes the drive's limits.
        """
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
        for indices, law in self._effort_laws:
            for i, value in zip(indices, law(state, self._dt), strict=True):
                effort[i] = value
        if self._compensated:
            self._add_gravity_compensation(effort, state)
        if self._servos:
            self._run_servos(effort, state)
        if self._governor.setup.drives:
            self._govern_speeds(effort, state)
        self._steps += 1
        self._limiter.saturate(effort, state, self._gravity_effort)
        for i in self._brakes:
            effort[i] = 0.0
        return effort

    @property
    def payloads(self) -> Mapping[str, Payload]:
        """The declared payloads, by flange."""
        return self._dynamics.payloads

    def set_payload(self, flange: str, payload: Payload | None) -> None:
        """Declare the payload at ``flange``.

        None selects the tool in the description.
        """
        self._dynamics.set_payload(flange, payload)
        self._table = None
        self._masses, self._compensation = [], []

    @property
    def table(self) -> DriveTable:
        """Data that change only when a payload is declared.

        The same object is returned until a payload is declared.
        """
        if self._table is None:
            self._table = DriveTable(
                self._dt,
                self._dynamics.to_model,
                self._dynamics.table,
                self._limiter.bounds,
                tuple(self._compensated),
                self._steps_per_command,
            )
        return self._table

    @property
    def own_dynamics(self) -> JointDynamics:
        """The dynamics without declared payloads, which the governor uses."""
        return self._dynamics.own

    @property
    def setup(self) -> DriveSetup:
        """Data that change rarely."""
        return DriveSetup(
            dict(self._limiter.drive_limits),
            self._brakes,
            self._governor.setup,
            self._servo_laws(),
            tuple(row for _, row in self._masses),
            self._fastest,
        )

    @property
    def state(self) -> DriveState:
        """Data that change in each step."""
        return DriveState(
            self._steps,
            self._gravity_effort,
            [effort for _, effort in self._compensation],
            self._limiter.velocities,
            self._governor.state,
            [servo.state for servo in self._servos.values()],
        )

    def _servo_laws(self) -> tuple[tuple[int, ServoLaw], ...]:
        return tuple((i, servo.law) for i, servo in self._servos.items())

    def restore(self, setup: DriveSetup, state: DriveState) -> None:
        """Continue from ``setup`` and ``state``.  Claims and commands do not change."""
        self._brakes = setup.brakes
        self._governor.setup, self._governor.state = setup.governor, state.governor
        if setup.servos != self._servo_laws():
            self._servos = {i: servo_of(law) for i, law in setup.servos}
        self._masses = list(zip(self._servos, setup.masses, strict=False))
        self._fastest = setup.fastest
        self._steps = state.steps
        self._gravity_effort = state.gravity
        self._compensation = list(
            zip(self._compensated, state.compensation, strict=False)
        )
        self._limiter.restore(setup.drive_limits, state.velocities)
        for servo, memory in zip(self._servos.values(), state.servos, strict=True):
            servo.restore(memory)

    def saved(self) -> SavedDrives:
        """Return the current state of the drives."""
        state = self.state
        return SavedDrives(
            self.setup,
            state._replace(gravity=list(state.gravity)),
            dict(self._claimed),
            tuple(self.command),
        )

    def resume(self, saved: SavedDrives) -> None:
        """Continue from a saved state of the same robot with the same payloads."""
        setup, state = saved.setup, saved.state
        self._claimed = dict(saved.claimed)
        self.command[:] = saved.command
        self.restore(setup, state._replace(gravity=list(state.gravity)))
        self._choose_governed()
        self._governor.setup, self._governor.state = setup.governor, state.governor

    def _select_servo(self, name: str, position: float) -> None:
        """Select the servo for the joint's claim and interface, or engage the brake."""
        i, interface = self.index[name], self._claimed.get(name)
        drive, rates = self._drives[name], self._dynamics.integral_rates
        self._servos.pop(i, None)
        self._masses, self._compensation = [], []
        self._gravity_effort[i] = 0.0
        brakes = {k: torque for k, torque in self._brakes.items() if k != i}
        if interface is None or self._is_stopped:
            brakes[i] = drive.hard.effort
        elif interface is Interface.POSITION:
            self._servos[i] = PositionServo(
                position,
                drive.hard,
                drive.soft,
                is_stiff=self._armatures[name] > 0.0,
                integral_rate=rates.get(name, INTEGRAL_RATE),
            )
        elif interface is Interface.VELOCITY:
            self._servos[i] = VelocityServo(drive.hard, drive.soft)
        if brakes != self._brakes:
            self._brakes = brakes
        self._choose_governed()

    def _add_gravity_compensation(self, effort: list[float], state: JointState) -> None:
        """Add gravity compensation to the efforts of the compensating drives."""
        if not self._compensation or self._steps % POSE_PERIOD == 0:
            gravity = self._dynamics.gravity(state)
            self._compensation = [(i, gravity[i]) for i in self._compensated]
            for i, compensation in self._compensation:
                self._gravity_effort[i] = compensation
        for i, compensation in self._compensation:
            effort[i] += compensation

    def weights_of(self, joints: Sequence[str], state: JointState) -> list[float]:
        """Return the efforts that hold ``joints`` against gravity [N·m | N].

        The effort is 0 for a joint whose drive compensates gravity.
        """
        weights = self._dynamics.gravity(state)
        for i in self._compensated:
            weights[i] = 0.0
        return [weights[self.index[name]] for name in joints]

    def masses_of(self, joints: Sequence[str], state: JointState) -> Matrix:
        """Return the mass matrix of ``joints`` [kg·m² | kg], shape (n, n).

        The effect of a declared payload is bounded, so that a control law that is
        scaled by the matrix remains stable without the payload.
        """
        return self._dynamics.masses([self.index[name] for name in joints], state)

    def _run_servos(self, effort: list[float], state: JointState) -> None:
        """Set the efforts for the accelerations that the servos request.

        The mass matrix couples all joints.  In some poses, for example with the arm
        straight up, the coupling is so strong that servos with separate inertias would
        vibrate.
        """
        if not self._masses or self._steps % POSE_PERIOD == 0:
            self._masses = self._servo_masses(state)
        gravity = self._dynamics.gravity(state)
        command, dt, period = self.command, self._dt, self._steps_per_command
        left = period - self._steps % period
        _, position, velocity, _ = state
        wanted = []
        for (i, servo), most in zip(self._servos.items(), self._fastest, strict=True):
            a = servo.acceleration(command[i], position[i], velocity[i], dt, left)
            wanted.append(-most if a < -most else min(a, most))
        for i, limits in self._limiter.drive_limits.items():
            limited = self._servos.get(i)
            if limited is not None:
                self._gravity_effort[i] = gravity[i]
            if isinstance(limited, PositionServo):
                _, limited.speed = limits.at(state.position[i])
        for i, masses in self._masses:
            # Do not use sum(): since Python 3.12, it uses compensated summation.
            effort[i] = gravity[i] + reduce(add, map(mul, masses, wanted), 0.0)

    def _choose_governed(self) -> None:
        """Select the joints for the governor.

        The governor controls the joints that no brake holds.
        """
        drives = [d for d in self._governable if d.joint not in self._brakes]
        joints = (self.index[name] for name in self.interfaces)
        free = [joint for joint in joints if joint not in self._brakes]
        self._governor.choose(drives, free)
        self._limiter.leave_speeds(frozenset(drive.joint for drive in drives))

    def _govern_speeds(self, effort: list[float], state: JointState) -> None:
        """Limit efforts so that no joint exceeds its speed limit in the next step."""
        governor, velocity = self._governor, state.velocity
        if governor.is_fast(velocity):
            if governor.is_mobility_due(state.position):
                mobility = self._dynamics.mobility(
                    governor.setup.free, state, self._rotors
                )
                governor.update(mobility.tolist(), state.position)
            governor.limit(effort, state.effort, velocity)
        governor.note(velocity)

    def _servo_masses(self, state: JointState) -> list[tuple[int, list[float]]]:
        matrix = self._dynamics.masses(list(self._servos), state)
        self._fastest = self._fastest_with(matrix).tolist()
        return list(zip(self._servos, matrix.tolist(), strict=True))

    def servo_masses(
        self, declared: Matrix, positions: Sequence[Sequence[float]]
    ) -> tuple[Matrix, Matrix]:
        """Return masses and largest accelerations of the servos in k states.

        The shapes of the two results are (k, n, n) and (k, n).  For the arguments, see
        ``DriveDynamics.servo_masses``.
        """
        matrices = self._dynamics.servo_masses(list(self._servos), declared, positions)
        return matrices, self._fastest_with(matrices)

    def mobilities(
        self,
        joints: Sequence[int],
        declared: Matrix,
        positions: Sequence[Sequence[float]],
    ) -> Matrix:
        """Return the mobilities of free joints in k states, for the governor.

        The shape is (k, n, n).  For the arguments, see ``DriveDynamics.mobilities``.
        """
        return self._dynamics.mobilities(joints, declared, positions, self._rotors)

    def _fastest_with(self, masses: Matrix) -> Matrix:
        """Return the largest acceleration of each servo's drive.

        The acceleration is computed for each joint separately, because other drives
        must not compensate for a drive at its limit.
        """
        efforts = [self.limits[self.joint_names[i]].effort for i in self._servos]
        inertia = np.diagonal(masses, axis1=-2, axis2=-1)
        return np.asarray(np.array(efforts) / inertia)


def _effort_limits(
    joint: Joint,
    limits: JointLimits | None,
    drive: Transmission,
    inertia: float,
    dt: float,
) -> EffortLimits:
    """Return the limits of a drive.  ``inertia`` is used only for a light joint."""
    hard, commands, armature = (
        limits or joint.limits,
        drive.command_limits,
        drive.armature,
    )
    hard = replace(
        hard,
        lower=max(hard.lower, commands.lower),
        upper=min(hard.upper, commands.upper),
        velocity=min(hard.velocity, commands.velocity),
        effort=min(hard.effort, commands.effort),
    )
    is_light = not armature and hard.effort * dt > hard.velocity * inertia
    return EffortLimits(
        hard=hard,
        soft=joint.safety,
        inertia=inertia if is_light else armature,
        is_light=is_light,
    )
