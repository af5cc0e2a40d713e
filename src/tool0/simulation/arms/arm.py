"""Power, brakes and stops of an arm, and the program that moves the arm.

An arm can move if it is powered, its brakes are released, and no stop is active.  A
stop affects only the controllers of one arm: the brakes hold the joints of the arm, and
controllers that claim these joints cannot be started.  Controllers that are interrupted
by a stop continue when the program is played again.  Transitions are immediate: the
intermediate modes of a UR robot (booting, powering on) do not occur.
"""

from __future__ import annotations

import abc
import logging
from collections.abc import Iterable
from typing import Final

from tool0.control.arm.compliance import ComplianceTask
from tool0.control.arm.motion import ArmMotionController
from tool0.control.arm.torque import TorqueCommand
from tool0.control.manager import ControllerManager, Strictness
from tool0.description.model import RobotModel
from tool0.description.parts import ArmParts
from tool0.description.payload import Payload
from tool0.description.scene_state import Contact
from tool0.errors import ControlError
from tool0.hardware.engine import JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import ProgramState, RobotMode, SafetyMode
from tool0.protocol.state import ArmSample
from tool0.simulation.arms.control_box import ControlBox
from tool0.simulation.arms.controller_mode import ControllerMode
from tool0.simulation.arms.modes import Modes
from tool0.simulation.arms.motion import ArmMotion

logger = logging.getLogger(__name__)

UNLOCK_AFTER: Final = 5.0
"""Simulated time from a protective stop until the stop can be unlocked [s].  The source
is the documentation of the dashboard server, ``unlock protective stop``
(https://www.universal-robots.com/articles/ur/dashboard-server/dashboard-server-e-series-port-29999/)."""
_TOO_SOON: Final = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of "
    "protective stop before unlocking"
)


class Arm(abc.ABC):
    """An arm with its control box and either simulated drives or real drives.

    Only the thread that executes the tick may use ``Arm``.
    """

    def __init__(
        self,
        name: str,
        parts: ArmParts,
        box: ControlBox,
        *,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
        moving_with_it: Iterable[str] = (),
    ) -> None:
        """Create an arm.

        The joints ``moving_with_it`` may move only if the arm may move.
        """
        self.name, self.parts = name, parts
        self.box = box
        self.motion = ArmMotion(name, parts, model, hardware, manager)
        """Motion of the arm for a program that has taken control of the arm."""
        self.mode = ControllerMode(self.motion.spec, hardware, manager)
        """Freedrive mode or force mode that a controller has started."""
        self._hardware, self._manager = hardware, manager
        self._joints = frozenset(joint.name for joint in parts.joints)
        """Joints of the arm, which a program can control."""
        self._stopped_with = self._joints.union(moving_with_it)
        """Joints that may move only if the arm may move."""
        self._modes = Modes()
        self._stopped: tuple[str, ...] = ()
        """Names of the stopped controllers that ``play`` restarts."""
        self._stopped_at = 0.0
        """Simulated time of the protective stop [s]."""
        self._resumes = False
        """Whether the controllers of the arm start when the program releases it."""

    def require_ready(self) -> None:
        """Raise ControlError, with reason and remedy, if the arm may not move."""
        if self._hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before moving the robot"
            )
        if reason := self._obstacle():
            raise ControlError(reason)

    # ---- the tick -------------------------------------------------------------------

    @property
    def is_idle(self) -> bool:
        """Whether a call to ``tick`` has no effect."""
        motion = self.motion
        return (
            self.box.is_steady
            and self.mode.is_idle
            and not motion.is_returning
            and not motion.has_torques
        )

    def tick(self, state: JointState, period: float) -> None:
        """Advance the speed scaling by one tick of ``period`` [s].

        Once an arm that has been released by its program is at rest, it is returned to
        its controllers.
        """
        self.box.tick(period)
        self.mode.tick(state)
        if self.motion.has_returned(state.time):
            self._release(state)

    # ---- power and stops ------------------------------------------------------------

    def power_off(self, now: JointState) -> None:
        """Power off the arm: its controllers stop, and the brakes hold the arm."""
        self._set(now, robot=RobotMode.POWER_OFF)

    def power_on(self, now: JointState) -> None:
        """Power on the arm, with its brakes engaged, unless it is already powered."""
        self._require_released()
        if not self._modes.is_powered:
            self._set(now, robot=RobotMode.IDLE)

    def release_brakes(self, now: JointState) -> None:
        """Release the brakes.

        If the arm is powered off, it is powered on first.

        The arm does not move until the program is played.
        """
        self._require_released()
        if not self._modes.is_powered:
            self._set(now, robot=RobotMode.RUNNING)

    def stop_protectively(self, reason: str, now: JointState) -> None:
        """Start a protective stop of the arm; ``reason`` is shown to users.

        An arm that is already in a protective stop keeps the reason for that stop.
        """
        if self._modes.safety is not SafetyMode.PROTECTIVE_STOP:
            self._stopped_at = now.time
            logger.warning("arm '%s': protective stop: %s", self.name, reason)
            self.box.change(protective_stop=reason)
            self._set(now, safety=SafetyMode.PROTECTIVE_STOP)

    def unlock(self, now: JointState, *, at_once: bool) -> None:
        """End a protective stop.

        The arm holds its position until its program is played.

        Raises:
            ControlError: If the arm is not in a protective stop, or if the stop
                occurred less than 5 s ago and ``at_once`` is False.
        """
        if self._modes.safety is not SafetyMode.PROTECTIVE_STOP:
            raise ControlError(f"the arm '{self.name}' is not in a protective stop")
        if not at_once and 0.0 <= now.time - self._stopped_at < UNLOCK_AFTER:
            raise ControlError(_TOO_SOON)
        self._set(now, safety=SafetyMode.NORMAL)

    def restart_safety(self, now: JointState) -> None:
        """Clear the stops of the safety system.

        After the safety system has restarted, the arm is powered off.

        Raises:
            ControlError: If the emergency stop is engaged.
        """
        self._require_released()
        self._set(now, RobotMode.POWER_OFF, SafetyMode.NORMAL)

    # ---- program that moves the arm through controllers -----------------------------

    def play(self, now: JointState) -> None:
        """Resume the program, and start the controllers that stopped with it.

        Raises:
            ControlError: If the arm may not move.
        """
        if self._hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before playing the program"
            )
        self.require_ready()
        self._forgive()
        if self.box.state.taken_by:
            self.box.change(program=ProgramState.PLAYING)
        else:
            self._start_again(now)

    def pause(self) -> None:
        """Pause the program, so that scaled trajectories slow down to a stop.

        Raises:
            ControlError: If the program is stopped.
        """
        if self.box.state.program is ProgramState.STOPPED:
            raise ControlError("the program is stopped; play it before pausing it")
        self.box.change(program=ProgramState.PAUSED)

    def stop(self, now: JointState) -> None:
        """Stop the program and the motion of the arm."""
        if self.box.state.program is not ProgramState.STOPPED:
            self._stop(now)

    # ---- program that controls the arm directly -------------------------------------

    def take(self, by: str, now: JointState, *, protected: bool = False) -> None:
        """Give a program control of the arm, in place of the arm's controllers.

        The arm holds its position, and its controllers stop.  If a program already
        controls the arm, the name of the program changes, and the arm may move again
        after a failed motion.  If ``protected`` is True, a failed motion causes a
        protective stop.

        Raises:
            ControlError: If the arm may not move.
        """
        self.require_ready()
        self._forgive()
        held = self.motion.desired(now)
        if not self.box.state.taken_by:
            self._resumes = self.box.state.program is ProgramState.PLAYING
            self._stopped = self._stop_controllers(now, self._joints) or self._stopped
            self.box.change(program=ProgramState.PLAYING)
        self.box.change(taken_by=by, motion_failure="")
        self._block()
        self.motion.start(held, now)
        self.motion.is_protected = protected

    def release(self, now: JointState) -> None:
        """Stop the arm, and restart its controllers after it has come to rest.

        ``release`` has no effect if no program controls the arm.
        """
        if self.motion.is_taken and not self.motion.is_returning:
            self._stiffen(now)
            if self.motion.start_return(now.time):
                self._release(now)

    def controller_to_move(self) -> ArmMotionController:
        """Return the controller with which a program can move the arm.

        Raises:
            ControlError: If no program controls the arm, or the arm may not move.
        """
        controller = self.controller_to_stop()
        if failure := self.box.state.motion_failure:
            raise ControlError(
                f"the arm '{self.name}' has stopped: {failure}; take it again with "
                "`take_arm` before you move it"
            )
        return controller

    def controller_to_stop(self) -> ArmMotionController:
        """Return the controller with which a program can stop the arm.

        The controller is also returned if a motion of the arm has failed.

        Raises:
            ControlError: If no program controls the arm, or the arm may not move.
        """
        self.require_ready()
        if not self.motion.is_taken:
            raise ControlError(
                f"no program moves the arm '{self.name}'; take it first with `take_arm`"
            )
        if self.motion.is_returning:
            raise ControlError(
                f"the arm '{self.name}' stops and is released; take it again first"
            )
        return self.motion.controller

    def fail(self, reason: str, now: JointState) -> None:
        """End a program's motion: the arm rests at its position and stops pushing.

        Commands from the program are rejected with ``reason`` until the program takes
        control of the arm again.
        """
        if self.motion.is_protected:
            self.stop_protectively(reason, now)
            return
        logger.warning("arm '%s' stops where it is: %s", self.name, reason)
        self.motion.rest(now)
        self._refuse(reason)

    def start_compliance(
        self, task: ComplianceTask, now: JointState, controller_name: str | None = None
    ) -> None:
        """Start force mode or freedrive of an arm.

        If ``controller_name`` is given, the mode is that of the named controller, which
        must be active.  Without ``controller_name``, a program must have taken control
        of the arm.

        Raises:
            ControlError: If the controller is not active, no program controls the arm,
                or the arm may not move.
        """
        if controller_name is not None:
            self._require_modes()
            self.require_ready()
            self.mode.start(controller_name, task, now)
            self._show_freedrive(task.is_freedrive, now)
            return
        self.controller_to_move()
        if self._is_guided and not task.is_freedrive:
            raise ControlError(
                f"the arm '{self.name}' is in freedrive; end that before force mode"
            )
        self._comply(task, now)

    def end_torques(self, now: JointState) -> None:
        """Ramp to rest under position control if torques drive the joints."""
        if self.motion.has_torques:
            self.motion.rest(now)

    def end_compliance(
        self, now: JointState, controller_name: str | None = None, *, is_freedrive: bool
    ) -> None:
        """End force mode or freedrive; the arm stops at its current position.

        ``end_compliance`` has no effect if the mode is not active.  If
        ``controller_name`` is given, the mode of the named controller ends; otherwise,
        the mode of the program that controls the arm ends.

        Raises:
            ControlError: If the controller is not active, no program controls the arm,
                or the arm may not move.
        """
        if controller_name is not None:
            self.require_ready()
            self.mode.end(controller_name, now, is_freedrive=is_freedrive)
            self._show_freedrive(self.mode.is_freedrive, now)
            return
        self.controller_to_stop()
        if self._is_guided == is_freedrive:
            self._stiffen(now)

    def note_restart(self, now: JointState, stopped: str = "") -> None:
        """Update the arm after a restart of controllers.

        The restart has ended freedrive and force mode.

        ``stopped`` is the reason why programs must not continue automatically; it is
        empty if they may continue.  If the emergency stop is engaged, the displayed
        modes are those of the emergency stop; otherwise, they are the modes before the
        restart.
        """
        self.motion.note_restart(now.time)
        self.mode.forget()
        if self.motion.is_taken:
            self._show_freedrive(False, now)
            if stopped:
                self._refuse(stopped)
        elif self._modes.robot is RobotMode.BACKDRIVE:
            self._show_freedrive(False, now)
        self._show()

    def note_switch(self, now: JointState) -> None:
        """Update the arm after controllers were started or stopped.

        The start or the stop of a controller may end a mode.
        """
        was_guided = self.mode.is_freedrive
        self.mode.note_switch(now)
        if was_guided and not self.mode.is_freedrive:
            self._show_freedrive(False, now)

    # ---- functions for the type of drives -------------------------------------------

    @abc.abstractmethod
    def sample(
        self,
        now: float,
        before: JointState,
        after: JointState,
        forces: tuple[Contact, ...],
    ) -> ArmSample:
        """Return a sample of the arm's motion and tool wrench at ``now`` [s].

        In the last physics step, the state changed from ``before`` to ``after`` under
        the external ``forces``.
        """

    @abc.abstractmethod
    def zero_wrench(self) -> None:
        """Tare the tool wrench with the last sample.

        Raises:
            ControlError: If the wrench of the arm cannot be tared.
        """

    def set_payload(self, payload: Payload | None) -> None:
        """Use ``payload`` at the flange; None for the payload of the description."""
        self.box.set_payload(payload)

    @abc.abstractmethod
    def drive(self, command: TorqueCommand, now: JointState) -> None:
        """Drive the joints of the arm with the torques of a program.

        Raises:
            ControlError: If no program controls the arm, if the arm may not move or is
                compliant, or if a drive cannot exert the torque.  An excessive torque
                is treated as a violation.
        """

    @property
    @abc.abstractmethod
    def _is_guided(self) -> bool:
        """Whether a program controls the arm and has started freedrive."""

    @abc.abstractmethod
    def _comply(self, task: ComplianceTask, now: JointState) -> None:
        """Start force mode or freedrive for the program that controls the arm."""

    @abc.abstractmethod
    def _stiffen(self, now: JointState) -> None:
        """End force mode or freedrive if it is active, and stop the arm."""

    @abc.abstractmethod
    def _require_modes(self) -> None:
        """Raise ControlError if controllers cannot start force mode or freedrive."""

    @abc.abstractmethod
    def _forgive(self) -> None:
        """Clear a failure, so that the arm may move again."""

    @abc.abstractmethod
    def _shown_modes(self) -> Modes:
        """Return the modes that are displayed to users."""

    @abc.abstractmethod
    def _obstacle(self) -> str:
        """Return the reason why the arm may not move, with a remedy.

        The text is empty if the arm may move.
        """

    @abc.abstractmethod
    def _why_stopped(self) -> str:
        """Return the reason why controllers must wait for ``play``, with a remedy.

        The text is empty if the controllers of an arm that may move may be started.
        """

    # ---- shared functions -----------------------------------------------------------

    def _require_released(self) -> None:
        """Raise ControlError if the emergency stop holds the arm."""
        if self._hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before powering the arm "
                f"'{self.name}'"
            )

    def _set(
        self,
        now: JointState,
        robot: RobotMode | None = None,
        safety: SafetyMode | None = None,
    ) -> None:
        """Change modes, and stop the arm if it may no longer move."""
        old = self._modes
        self._modes = new = old.changed(robot, safety)
        self._show()
        if not new.may_move and old.may_move:
            self._stop(now)
        else:
            self._block()

    def _show(self) -> None:
        """Publish the modes of the arm, or those of an emergency stop."""
        reason = self.box.state.protective_stop
        if self._modes.safety is not SafetyMode.PROTECTIVE_STOP:
            reason = ""
        robot, safety = self._shown_modes()
        self.box.change(robot_mode=robot, safety_mode=safety, protective_stop=reason)

    def _show_freedrive(self, engaged: bool, now: JointState) -> None:
        """Publish whether a powered arm is in freedrive."""
        if self._modes.is_powered:
            self._set(now, RobotMode.BACKDRIVE if engaged else RobotMode.RUNNING)

    def _stop(self, now: JointState) -> None:
        """Stop the motion and the program of the arm.

        After the stop, the brakes hold the arm.
        """
        stopped = self._stop_controllers(now, self._stopped_with)
        if self.motion.is_taken:
            self.motion.abort(now)
            stopped = (*self._stopped, *stopped)
        self._stopped = stopped or self._stopped
        self._end_program()

    def _end_program(self) -> None:
        self.box.change(taken_by="", program=ProgramState.STOPPED, motion_failure="")
        self._block()

    def _block(self) -> None:
        """Block the controllers if a program controls the arm or if it may not move."""
        reason = self._obstacle() or self._why_stopped()
        taken_by = self.box.state.taken_by
        self._manager.block(self._stopped_with, reason)
        if taken_by and not reason:
            reason = f"'{taken_by}' moves the arm '{self.name}'; stop that first"
            self._manager.block(self._joints, reason)

    def _stop_controllers(
        self, now: JointState, joints: frozenset[str]
    ) -> tuple[str, ...]:
        """Stop the controllers that claim ``joints``, and return their names."""
        names = tuple(
            status.name
            for status in self._manager.list()
            if status.is_running and status.joints & joints
        )
        self._manager.switch((), names, Strictness.BEST_EFFORT, now)
        return names

    def _start_again(self, now: JointState) -> None:
        """Resume the program, and start the controllers that stopped with it."""
        self.box.change(program=ProgramState.PLAYING)
        self._block()
        loaded = {status.name for status in self._manager.list()}
        names = [name for name in self._stopped if name in loaded]
        self._manager.switch(names, (), Strictness.BEST_EFFORT, now)
        self._stopped = ()

    def _release(self, now: JointState) -> None:
        """Restart the controllers that were running before the program took control."""
        wanted = self.motion.controller.at_rest(now)
        self.motion.abort(now)
        self._end_program()
        if self._resumes:
            self._start_again(wanted)
        self.motion.preload_integrals(now)

    def _refuse(self, reason: str) -> None:
        self.box.change(motion_failure=self.box.state.motion_failure or reason)
