"""The motion of an arm that a program controls instead of the arm's controllers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Final, final

from tool0.control.arm.compliance import ComplianceTask
from tool0.control.arm.motion import ArmMotionController, ArmMotionSpec
from tool0.control.arm.path import ArmPath
from tool0.control.arm.torque import TorqueCommand
from tool0.control.controller import TrajectoryFollower
from tool0.control.manager import ControllerManager
from tool0.description.model import FLANGE, Interface, RobotModel
from tool0.description.parts import ArmParts
from tool0.description.scene_state import Wrench
from tool0.hardware.engine import JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.state import ArmSample
from tool0.simulation.arms.mechanics import ArmMechanics

RETURN_BRAKE: Final = 4.0
"""Rate of change of a path's speed factor when the arm is released during motion [1/s].
A path at full speed stops within 0.25 s."""
RETURN_DECELERATION: Final = 4.0
"""Smallest deceleration of motions other than paths when the arm is released [rad/s²].
A stream of velocities uses its own acceleration if it is larger."""
SETTLING: Final = 0.1
"""Time by which an arm comes to rest later than its setpoint [s].  The servos of the
arm lag by about 20 ms."""
STIFFENING: Final = 10.0
"""Deceleration of a moving arm when force mode or freedrive ends, or when the arm's
motion fails [rad/s²]."""


@final
class ArmMotion:
    """Motion of an arm that a program controls.

    Only the thread that executes the tick may use ``ArmMotion``.  An
    ArmMotionController, which exists until the arm is released, moves the arm.
    """

    def __init__(
        self,
        name: str,
        parts: ArmParts,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
    ) -> None:
        self._manager, self._hardware = manager, hardware
        limits, prefix = hardware.limits, parts.flange.removesuffix(FLANGE)
        self.spec = ArmMotionSpec(
            name=f"{prefix}arm_motion",
            joint_models=tuple(
                replace(joint, limits=limits.get(joint.name, joint.limits))
                for joint in parts.joints
            ),
            speed_scaling=partial(hardware.speed_scaling.__getitem__, prefix),
            model=ArmMechanics(model, name, hardware),
        )
        self.is_taken = False
        """Whether a program has taken control of the arm."""
        self.is_protected = False
        """Whether a failed motion causes a protective stop."""
        self._rests_at: float | None = None
        """Time at which an arm that is being released will have come to rest [s]; None
        if the arm is not being released."""
        self._n_paths = 0
        """Number of paths that were started."""
        self.has_torques = False
        """Whether torques of a program drive the joints."""

    @property
    def controller(self) -> ArmMotionController:
        """Controller that moves the arm for a program."""
        running = self._manager.running(self.spec.name)
        assert isinstance(running, ArmMotionController)  # it has this spec
        return running

    # ---- start and end --------------------------------------------------------------

    def start(self, held: tuple[float, ...] | None, now: JointState) -> None:
        """Hold the arm, and cancel a return.

        The arm is held at ``held`` [rad] if it is near these positions.
        """
        if self.is_returning:
            self._rests_at = None
            if self.controller.motion(now.time).is_at_rest:
                self.controller.hold(now.time)
        if not self.is_taken:
            self.is_taken = True
            self._manager.start_own(self.spec, now)
            if held is not None:
                self.controller.rest_at(held, now.time)

    @property
    def is_returning(self) -> bool:
        """Whether the arm is stopping before its release."""
        return self._rests_at is not None

    def start_return(self, now: float) -> bool:
        """Stop before the release, and return whether the arm is already at rest."""
        controller = self.controller
        on_path = controller.mode == "path"
        if controller.motion(now).is_at_rest and not on_path:
            return True
        rate = max(RETURN_DECELERATION, controller.stream_deceleration())
        rate = RETURN_BRAKE if on_path else rate
        controller.stop_motion(rate, now, along_path=on_path)
        self._rests_at = math.inf
        return False

    def has_returned(self, now: float) -> bool:
        """Return whether a returning arm has come to rest.

        ``has_returned`` is called in each tick.
        """
        if self._rests_at is None or not self.controller.is_done(now):
            return False
        if now >= self._rests_at:
            return True
        self._rests_at = min(self._rests_at, now + SETTLING)
        return False

    def note_restart(self, now: float) -> None:
        """Update the state after a restart of the controller.

        A returning arm is at rest after the restart.
        """
        self.has_torques = False
        if self.is_returning:
            self._rests_at = now

    def abort(self, now: JointState) -> None:
        """End the motion immediately, so that the brakes stop the arm."""
        self.is_taken, self._rests_at, self.has_torques = False, None, False
        self._manager.stop_own(self.spec.name, now)

    # ---- motion under program control -----------------------------------------------

    def execute(
        self,
        path: ArmPath,
        now: float,
        *,
        after: int | None = None,
        at: float | None = None,
    ) -> int:
        """Start a path, and return the number of the path.

        The path starts at ``now`` [s], or replaces path number ``after``, starting at
        the time ``at`` along it [s].

        Raises:
            ControlError: If the path cannot be followed; in this case, the arm's motion
                continues.
        """
        controller, number = self.controller, self._n_paths + 1
        if after is None or at is None:
            controller.execute(path, number, now)
        else:
            controller.replace(path, number, after=after, at=at, now=now)
        self._n_paths = number
        return number

    def start_compliance(self, task: ComplianceTask, now: JointState) -> None:
        """Start force mode or freedrive."""
        law = self.controller.start_compliance(task, now)
        self._manager.drive_efforts(self.spec.name, law, now)

    def drive(self, command: TorqueCommand, now: JointState) -> None:
        """Drive the joints with torques.

        Raises:
            ControlError: If a drive cannot exert the torque; in this case, nothing
                changes.
        """
        torques = self.controller.torques
        if torques is not None:
            torques.aim(command)
            return
        law = self.controller.start_torques(command, now)
        self._manager.drive_efforts(self.spec.name, law, now, with_rotors=True)
        self.has_torques = True

    def rest(self, now: JointState) -> None:
        """Ramp to rest from the measured motion, with newly initialized servos."""
        self.has_torques = False
        self._manager.drive_efforts(self.spec.name, None, now)
        self.controller.end_compliance(now, STIFFENING)

    # ---- state of the arm -----------------------------------------------------------

    def setpoint(self, now: JointState) -> tuple[float, ...]:
        """Return the commanded joint positions of the arm [rad].

        If no controller holds the arm at rest, the measured positions are returned.
        """
        if self.is_taken:
            return tuple(self.controller.motion(now.time).positions)
        index = self._hardware.index
        measured = tuple(now.position[index[name]] for name in self.spec.joints)
        return self.desired(now) or measured

    def sample(self, now: float, wrench: Wrench, failure: str) -> ArmSample:
        """Return the motion of the arm at ``now`` [s].

        ``wrench`` acts on the tool.  ``failure`` is the reason why the motion failed;
        it is empty if the motion did not fail.
        """
        joints = self.spec.joints
        if not self.is_taken:
            last = self._n_paths
            return ArmSample(
                "free", None, last, 0.0, True, False, wrench, joint_names=joints
            )
        controller = self.controller
        number, time = controller.progress(now)
        return ArmSample(
            controller.mode,
            controller.unknown_setpoint(now),
            number,
            time,
            not failure and controller.is_done(now),
            controller.is_in_force_mode,
            wrench,
            failure,
            joints,
        )

    # ---- controllers before and after program control -------------------------------

    def desired(self, now: JointState) -> tuple[float, ...] | None:
        """Return the positions at which a controller holds the arm [rad], or None.

        After an effort controller has started, the arm sags until the integral term of
        the controller supports the arm.  If a program held the arm at its measured
        position, the arm would therefore be lowered slightly each time a program takes
        control of it.
        """
        joints = self.spec.joints
        for controller in self._followers():
            names = controller.spec.joints
            if not set(names).issuperset(joints):
                continue
            desired = controller.query_state(now.time)
            order = [names.index(joint) for joint in joints]
            if not any(desired.velocities[k] for k in order):
                return tuple(desired.positions[k] for k in order)
        return None

    def preload_integrals(self, now: JointState) -> None:
        """Start effort controllers with the efforts that currently hold the arm.

        With an initial integral of 0, the arm would sag until the integral has built
        up.
        """
        hardware, claimed = self._hardware, self._hardware.claimed
        for controller in self._followers():
            if not controller.pid:
                continue
            for k, name in enumerate(controller.spec.joints):
                if (
                    name in self.spec.joints
                    and claimed.get(name) is Interface.EFFORT
                    and not hardware.compensates_gravity(name)
                ):
                    effort = now.effort[hardware.index[name]]
                    controller.pid.set_contribution(k, effort)

    def _followers(self) -> Iterator[TrajectoryFollower]:
        """Yield the running trajectory controllers of the arm's joints."""
        joints = set(self.spec.joints)
        for status in self._manager.list():
            if status.is_running and status.joints & joints:
                controller = self._manager.running(status.name)
                if isinstance(controller, TrajectoryFollower):
                    yield controller
