"""Who may move each arm: power, brakes, stops, and the program that has it.

An arm moves if it is powered, its brakes are released, and no stop is on.  A stop
stops the controllers of that arm only: the brakes hold its joints, and no controller
can be started that claims them.  What stops on the way goes on when its program is
played again.  Transitions are immediate: a UR's intermediate modes (booting, powering
on) do not occur.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Final, NamedTuple, final

from tool0.control.manager import ControllerManager, Strictness
from tool0.description.model import RobotModel
from tool0.description.parts import find_arms
from tool0.errors import ControlError
from tool0.hardware.engine import JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import (
    POWERED,
    UNSTOPPED,
    ControlBoxState,
    ProgramState,
    RobotMode,
    SafetyMode,
)
from tool0.simulation.control_boxes import ControlBoxes

logger = logging.getLogger(__name__)

UNLOCK_AFTER: Final = 5.0
"""Simulated time from a protective stop until it can be unlocked [s]: dashboard server,
``unlock protective stop``
(https://www.universal-robots.com/articles/ur/dashboard-server/dashboard-server-e-series-port-29999/)."""
_TOO_SOON: Final = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of "
    "protective stop before unlocking"
)


class _Modes(NamedTuple):
    """The modes of an arm, whether or not the emergency stop hides them."""

    robot: RobotMode = RobotMode.RUNNING
    safety: SafetyMode = SafetyMode.NORMAL


@final
class ArmModes:
    """The modes and the program of every arm.

    Only the thread of the tick may use it.
    """

    def __init__(
        self,
        model: RobotModel,
        boxes: ControlBoxes,
        hardware: RobotHardware,
        manager: ControllerManager,
    ) -> None:
        self._boxes, self._hardware, self._manager = boxes, hardware, manager
        self._joints = {
            name: frozenset(joint.name for joint in arm.joints)
            for name, arm in find_arms(model).items()
        }
        self._modes = dict.fromkeys(self._joints, _Modes())
        self._stopped: dict[str, tuple[str, ...]] = {}
        """The controllers that play starts, by arm."""
        self._stopped_at: dict[str, float] = {}
        """When an arm's protective stop occurred [s]."""
        self._resumes: dict[str, bool] = {}
        """Whether the controllers of a taken arm start when it is given back."""
        self.when_stopped: Callable[[str, JointState], None] = lambda arm, now: None
        """Called before an arm is stopped: what moves it besides controllers ends."""

    def require_ready(self, arm: str | None) -> ControlBoxState:
        """Return the control box of an arm that may move.

        Raises:
            ControlError: If it may not, with the reason and the remedy.
        """
        state = self._boxes.find(arm)
        if self._hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before moving the robot"
            )
        if reason := self._obstacle(state):
            raise ControlError(reason)
        return state

    # ---- power and stops ------------------------------------------------------------

    def power_off(self, arm: str | None, now: JointState) -> None:
        """Switch the arm off: its controllers stop, and the brakes hold it."""
        self._set(self._boxes.find(arm), now, robot=RobotMode.POWER_OFF)

    def power_on(self, arm: str | None, now: JointState) -> None:
        """Switch the arm on, with its brakes on; one that is on is left alone."""
        state = self._released(arm)
        if self._modes[state.arm].robot not in POWERED:
            self._set(state, now, robot=RobotMode.IDLE)

    def release_brakes(self, arm: str | None, now: JointState) -> None:
        """Release the brakes; switch the arm on first, if it is off.

        Nothing moves until the program is played.
        """
        state = self._released(arm)
        if self._modes[state.arm].robot not in POWERED:
            self._set(state, now, robot=RobotMode.RUNNING)

    def stop_protectively(self, arm: str | None, reason: str, now: JointState) -> None:
        """Stop the arm until the stop is unlocked; ``reason`` is for people.

        An arm in a protective stop keeps the first reason.
        """
        state = self._boxes.find(arm)
        if self._modes[state.arm].safety is not SafetyMode.PROTECTIVE_STOP:
            self._stopped_at[state.arm] = now.time
            logger.warning("arm '%s': protective stop: %s", state.arm, reason)
            state = self._boxes.change(state, protective_stop=reason)
            self._set(state, now, safety=SafetyMode.PROTECTIVE_STOP)

    def unlock(self, arm: str | None, now: JointState) -> None:
        """End a protective stop; the arm holds until its program is played.

        Raises:
            ControlError: If there is none, or it occurred less than 5 s ago.
        """
        state = self._boxes.find(arm)
        if self._modes[state.arm].safety is not SafetyMode.PROTECTIVE_STOP:
            raise ControlError(f"the arm '{state.arm}' is not in a protective stop")
        if 0.0 <= now.time - self._stopped_at[state.arm] < UNLOCK_AFTER:
            raise ControlError(_TOO_SOON)
        self._set(state, now, safety=SafetyMode.NORMAL)

    def restart_safety(self, arm: str | None, now: JointState) -> None:
        """Clear what the safety system has stopped; the arm is switched off then.

        Raises:
            ControlError: If the emergency stop is engaged.
        """
        state = self._released(arm)
        self._set(state, now, RobotMode.POWER_OFF, SafetyMode.NORMAL)

    def set_freedrive(self, arm: str, engaged: bool, now: JointState) -> None:
        """Show whether an arm that may move is guided by hand."""
        if self._modes[arm].robot in POWERED:
            mode = RobotMode.BACKDRIVE if engaged else RobotMode.RUNNING
            self._set(self._boxes.find(arm), now, robot=mode)

    def note_emergency_stop(self) -> None:
        """Follow the emergency stop of the drives, which all arms share.

        Released, every arm has the modes from before.
        """
        for state in self._boxes.states:
            self._show(state)

    # ---- programs -------------------------------------------------------------------

    def play(self, arm: str | None, now: JointState) -> None:
        """Let the program run: start the controllers that were stopped with it.

        Raises:
            ControlError: If the arm may not move.
        """
        if self._hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before playing the program"
            )
        state = self.require_ready(arm)
        if not state.taken_by:
            self._start_again(state.arm, now)
        self._boxes.change(state, program=ProgramState.PLAYING)

    def pause(self, arm: str | None) -> None:
        """Pause the program: scaled trajectories slow down to a standstill.

        Raises:
            ControlError: If it is stopped.
        """
        state = self._boxes.find(arm)
        if state.program is ProgramState.STOPPED:
            raise ControlError("the program is stopped; play it before pausing it")
        self._boxes.change(state, program=ProgramState.PAUSED)

    def stop(self, arm: str | None, now: JointState) -> None:
        """Stop the program, and with it what moves the arm."""
        state = self._boxes.find(arm)
        if state.program is not ProgramState.STOPPED:
            self._stop(state, now)

    def take(self, arm: str | None, by: str, now: JointState) -> ControlBoxState:
        """Stop the controllers of an arm for another program, which plays from now on.

        A program that has the arm already gets the new name ``by`` only.

        Raises:
            ControlError: If the arm may not move.
        """
        state = self.require_ready(arm)
        if not state.taken_by:
            self._resumes[state.arm] = state.program is ProgramState.PLAYING
            self._stop_controllers(state.arm, now)
            self._boxes.change(state, program=ProgramState.PLAYING)
        state = self._boxes.change(state, taken_by=by)
        self._block(state)
        return state

    def release(self, arm: str | None, now: JointState) -> None:
        """Start the controllers again that ran when the arm was taken.

        An arm that is not taken is left alone.
        """
        state = self._boxes.find(arm)
        if not state.taken_by:
            return
        program = ProgramState.STOPPED
        self._block(self._boxes.change(state, taken_by="", program=program))
        if self._resumes.pop(state.arm):
            self._start_again(state.arm, now)
            self._boxes.change(state, program=ProgramState.PLAYING)

    # ---- what they have in common ---------------------------------------------------

    def _released(self, arm: str | None) -> ControlBoxState:
        """Return the control box of an arm that the emergency stop does not hold."""
        state = self._boxes.find(arm)
        if self._hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before powering the arm "
                f"'{state.arm}'"
            )
        return state

    def _set(
        self,
        state: ControlBoxState,
        now: JointState,
        robot: RobotMode | None = None,
        safety: SafetyMode | None = None,
    ) -> None:
        """Change modes; stop what moves the arm if it may not move any more."""
        old = self._modes[state.arm]
        new = _Modes(robot or old.robot, safety or old.safety)
        if new.robot is RobotMode.BACKDRIVE and new.safety not in UNSTOPPED:
            new = new._replace(robot=RobotMode.RUNNING)
        self._modes[state.arm] = new
        state = self._show(state)
        if not _may_move(new) and _may_move(old):
            self._stop(state, now)
        else:
            self._block(state)

    def _show(self, state: ControlBoxState) -> ControlBoxState:
        """Show the modes of an arm, or the emergency stop's."""
        robot, safety = self._modes[state.arm]
        reason = state.protective_stop
        if safety is not SafetyMode.PROTECTIVE_STOP:
            reason = ""
        if self._hardware.is_stopped:
            robot, safety = RobotMode.POWER_OFF, SafetyMode.ROBOT_EMERGENCY_STOP
        return self._boxes.change(
            state, robot_mode=robot, safety_mode=safety, protective_stop=reason
        )

    def _stop(self, state: ControlBoxState, now: JointState) -> None:
        """Stop what moves the arm, and its program; then the brakes hold it."""
        self.when_stopped(state.arm, now)
        if self._resumes.pop(state.arm, None) is None:
            self._stop_controllers(state.arm, now)
        program = ProgramState.STOPPED
        self._block(self._boxes.change(state, taken_by="", program=program))

    def _block(self, state: ControlBoxState) -> None:
        """Let no controller of an arm start that may not move, or is taken."""
        reason = self._obstacle(state)
        if state.taken_by and not reason:
            reason = f"'{state.taken_by}' moves the arm '{state.arm}'; stop that first"
        self._manager.block(self._joints[state.arm], reason)

    def _obstacle(self, state: ControlBoxState) -> str:
        """Return why an arm may not move, and a remedy; empty if it may."""
        arm, (robot, safety) = state.arm, self._modes[state.arm]
        handle = f"robot.arms['{arm}'].control_box"
        if safety is SafetyMode.PROTECTIVE_STOP:
            return (
                f"the arm '{arm}' is in a protective stop; unlock it in the panel or "
                f"with {handle}.unlock() (it stopped for: {state.protective_stop})"
            )
        if safety not in UNSTOPPED:
            return (
                f"the safety mode of the arm '{arm}' is {safety.name}; restart it with "
                f"{handle}.restart_safety()"
            )
        if robot not in POWERED:
            state_of = "powered off" if robot is RobotMode.POWER_OFF else "braked"
            return (
                f"the arm '{arm}' is {state_of}; power it on and release its brakes "
                f"with {handle}.release_brakes()"
            )
        return ""

    def _stop_controllers(self, arm: str, now: JointState) -> None:
        joints = self._joints[arm]
        names = tuple(
            status.name
            for status in self._manager.list()
            if status.is_running and status.joints & joints
        )
        self._manager.switch((), names, Strictness.BEST_EFFORT, now)
        if names:
            self._stopped[arm] = names

    def _start_again(self, arm: str, now: JointState) -> None:
        loaded = {status.name for status in self._manager.list()}
        names = [n for n in self._stopped.get(arm, ()) if n in loaded]
        self._manager.switch(names, (), Strictness.BEST_EFFORT, now)
        self._stopped.pop(arm, None)


def _may_move(modes: _Modes) -> bool:
    return modes.robot in POWERED and modes.safety in UNSTOPPED
