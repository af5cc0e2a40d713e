"""The arm of a real robot, which has its own controller."""

from __future__ import annotations

import contextlib
from typing import Final, final

from msgspec import structs

from tool0.control.arm.compliance import ComplianceTask
from tool0.control.arm.torque import TorqueCommand
from tool0.control.manager import ControllerManager
from tool0.description.model import RobotModel
from tool0.description.parts import ArmParts
from tool0.description.payload import Payload
from tool0.description.scene_state import Contact
from tool0.errors import ControlError, TransportError
from tool0.hardware.engine import JointState
from tool0.hardware.own_drives import OwnDrives, RobotReport
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import Pose6, ProgramState, SafetyMode
from tool0.protocol.state import ArmSample
from tool0.simulation.arms.arm import Arm
from tool0.simulation.arms.control_box import ControlBox
from tool0.simulation.arms.modes import Modes

_OF_ITS_CONTROLLER: Final = "the robot's safety system; its pendant says why"
_NO_MODE: Final = (
    "controllers of freedrive and force mode are not supported on a real robot; take "
    "the arm with a program"
)
_NO_TORQUES: Final = "torques are not sent to a real robot"
_OWN_SENSOR: Final = "a real robot tares its own sensor"
_EMERGENCY_STOPS: Final = frozenset(
    {SafetyMode.ROBOT_EMERGENCY_STOP, SafetyMode.SYSTEM_EMERGENCY_STOP}
)
_RELEASE: Final = (
    "the robot's emergency stop is engaged; release its button, switch the arm on and "
    "release its brakes (`tool0 hardware release-brakes`), and enable its motion again"
)
_LOST: Final = "check power and network; tool0 tries again"


@final
class RealArm(Arm):
    """A real arm, which controls its own motion and reports power, stops and pins."""

    def __init__(
        self,
        name: str,
        parts: ArmParts,
        drives: OwnDrives,
        *,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
    ) -> None:
        """Create the arm that has the real robot's ``drives``.

        The gripper of the arm may move only while the arm may move.
        """
        box = ControlBox(name, parts.flange, model, hardware, drives)
        super().__init__(
            *(name, parts, box),
            model=model,
            hardware=hardware,
            manager=manager,
            moving_with_it=hardware.interfaces,
        )
        self._drives = drives
        self._report: RobotReport | None = None
        """Latest report of the robot's controller."""
        self._task: ComplianceTask | None = None
        """Task of force mode or freedrive that the robot's controller executes; None if
        there is no such task."""

    def follow(self, report: RobotReport, now: JointState) -> None:
        """Publish a report of the robot's controller, and follow the robot's stops.

        Motion never restarts automatically; ``play`` is required.
        """
        if report is self._report:
            return
        last, self._report = self._report, report
        payload = Payload(report.payload_mass, report.payload_center)
        self.box.change(
            link=report.link,
            digital_inputs=report.digital_inputs,
            digital_outputs=report.digital_outputs,
            analog_inputs=report.analog_inputs,
            analog_outputs=report.analog_outputs,
            tool_analog_inputs=report.tool_analog_inputs,
            tool_voltage=report.tool_voltage,
            tool_current=report.tool_current,
            tool_temperature=report.tool_temperature,
            speed_slider=max(report.speed_slider, 0.0),
            payload=payload,
            tcp=report.tcp,
        )
        if report.safety_mode is SafetyMode.PROTECTIVE_STOP:
            self.box.change(protective_stop=_OF_ITS_CONTROLLER)
        self._set(now, report.robot_mode, report.safety_mode)
        is_stopped = self.box.state.program is ProgramState.STOPPED
        if report.program is ProgramState.STOPPED or report.motion_failure:
            if not is_stopped:
                self._stop(now)
            self.box.change(motion_failure=report.motion_failure)
            self._block()
        elif not is_stopped and last is not None and report.program is not last.program:
            self.box.change(program=report.program)

    def _forgive(self) -> None:
        self._drives.forgive()
        self.box.change(motion_failure="")

    # ---- force mode and freedrive of the robot --------------------------------------

    @property
    def _is_guided(self) -> bool:
        return self._task is not None and self._task.is_freedrive

    def _require_modes(self) -> None:
        raise ControlError(_NO_MODE)

    def _comply(self, task: ComplianceTask, now: JointState) -> None:
        from tool0.description.transform import from_matrix

        frame = from_matrix(task.frame)
        pose: Pose6 = (*frame.position, *frame.rotation_vector)
        self._task = task
        if task.is_freedrive:
            self._drives.start_freedrive(task.free.tolist(), pose)
            return
        self._drives.start_force_mode(
            pose,
            task.free.tolist(),
            task.wrench.tolist(),
            task.kind,
            task.limits.tolist(),
        )

    def _stiffen(self, now: JointState) -> None:
        if self._end_task():
            self.motion.rest(now)

    def _stop(self, now: JointState) -> None:
        with contextlib.suppress(TransportError):  # a lost link ends the task
            self._end_task()
        super()._stop(now)

    def _end_task(self) -> bool:
        """End force mode or freedrive, and return whether either was active."""
        task, self._task = self._task, None
        if task is None:
            return False
        if task.is_freedrive:
            self._drives.end_freedrive()
        else:
            self._drives.end_force_mode()
        return True

    def drive(self, command: TorqueCommand, now: JointState) -> None:
        raise ControlError(_NO_TORQUES)

    # ---- samples --------------------------------------------------------------------

    def sample(
        self,
        now: float,
        before: JointState,
        after: JointState,
        forces: tuple[Contact, ...],
    ) -> ArmSample:
        drives = self._drives
        sample = self.motion.sample(now, drives.wrench, self.box.state.motion_failure)
        return structs.replace(sample, currents=drives.currents)

    def zero_wrench(self) -> None:
        raise ControlError(_OWN_SENSOR)

    # ---- modes ----------------------------------------------------------------------

    def _shown_modes(self) -> Modes:
        return self._modes

    def _obstacle(self) -> str:
        link = self.box.state.link
        if link is not None and not link.is_connected:
            return f"the robot at {link.address} is not reached: {_LOST}"
        if link is not None and self._modes.safety in _EMERGENCY_STOPS:
            return _RELEASE
        if reason := self._modes.obstacle(self.name, self.box.state.protective_stop):
            return reason
        if link is not None and not link.is_enabled:
            return (
                f"tool0 only reads the robot at {link.address}; enable its motion in "
                "the panel or with `tool0 hardware enable`"
            )
        return ""

    def _why_stopped(self) -> str:
        state = self.box.state
        if state.program is not ProgramState.STOPPED:
            return ""
        cause = ";"
        if state.motion_failure:
            cause = f": {state.motion_failure}; remove the cause, then"
        return (
            f"the arm '{self.name}' has stopped{cause} start its "
            "controllers again with `tool0 hardware play` or "
            f"robot.arms['{self.name}'].control_box.play()"
        )
