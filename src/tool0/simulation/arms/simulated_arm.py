"""An arm with simulated drives."""

from __future__ import annotations

from typing import final

from msgspec import structs

from tool0.control.arm.compliance import ComplianceTask
from tool0.control.arm.torque import TorqueCommand
from tool0.control.manager import ControllerManager
from tool0.description.model import RobotModel
from tool0.description.parts import ArmParts
from tool0.description.payload import Payload
from tool0.description.scene_state import Contact
from tool0.errors import ControlError
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import RobotMode, SafetyMode
from tool0.protocol.state import ArmSample
from tool0.sensing.tool_wrench import ToolWrench
from tool0.simulation.arms.arm import Arm
from tool0.simulation.arms.control_box import ControlBox
from tool0.simulation.arms.modes import Modes


@final
class SimulatedArm(Arm):
    """An arm with a computed tool wrench, and simulated drives that follow efforts."""

    def __init__(
        self,
        name: str,
        parts: ArmParts,
        *,
        model: RobotModel,
        engine: Engine,
        hardware: RobotHardware,
        manager: ControllerManager,
    ) -> None:
        """Create the arm that consists of ``parts`` and is simulated by ``engine``."""
        box = ControlBox(name, parts.flange, model, hardware)
        super().__init__(
            name, parts, box, model=model, hardware=hardware, manager=manager
        )
        self._model, self._engine = model, engine
        self._tool_wrench: ToolWrench | None = None
        """Sensor of the tool wrench; None until the wrench is first sampled."""

    def tick(self, state: JointState, period: float) -> None:
        super().tick(state, period)
        if self.motion.has_torques:
            self._watch_torques(state, period)

    # ---- force mode, freedrive and torques ------------------------------------------

    @property
    def _is_guided(self) -> bool:
        return self.motion.controller.is_guided

    def _comply(self, task: ComplianceTask, now: JointState) -> None:
        self.end_torques(now)
        self.motion.start_compliance(task, now)
        self._show_freedrive(task.is_freedrive, now)

    def _stiffen(self, now: JointState) -> None:
        if self.motion.controller.is_compliant:
            self.motion.rest(now)
            self._show_freedrive(False, now)

    def _require_modes(self) -> None:
        """Do nothing, since controllers can start the modes of a simulated arm."""

    def _forgive(self) -> None:
        """Do nothing, since the state of the control box contains the failure."""

    def drive(self, command: TorqueCommand, now: JointState) -> None:
        controller = self.controller_to_move()
        if not self._engine.has_rotors:
            raise ControlError(
                f"the engine '{self._engine.name}' has no torque control: its joints "
                "have no rotors; use MuJoCo"
            )
        if controller.is_compliant and not self.motion.has_torques:
            mode = "freedrive" if controller.is_guided else "force mode"
            raise ControlError(
                f"the arm '{self.name}' is in {mode}; end that before torques"
            )
        try:
            self.motion.drive(command, now)
        except ControlError as error:
            if self.motion.is_protected:
                self.stop_protectively(str(error), now)
            raise

    def _watch_torques(self, state: JointState, period: float) -> None:
        """Start a protective stop at a violation, and end expired torques."""
        torques = self.motion.controller.torques
        assert torques is not None  # torque mode has a law
        if reason := torques.violation(state, period):
            self.stop_protectively(reason, state)
        elif torques.is_over(state.time):
            self.end_torques(state)

    # ---- samples --------------------------------------------------------------------

    def sample(
        self,
        now: float,
        before: JointState,
        after: JointState,
        forces: tuple[Contact, ...],
    ) -> ArmSample:
        wrench = self._wrench.read(before, after, forces)
        sample = self.motion.sample(now, wrench, self.box.state.motion_failure)
        if self.mode.is_on and not self.mode.is_freedrive:
            return structs.replace(sample, force_mode=True)
        return sample

    def zero_wrench(self) -> None:
        self._wrench.zero()

    def set_payload(self, payload: Payload | None) -> None:
        super().set_payload(payload)
        if self._tool_wrench is not None:
            self._tool_wrench.subtract(self._known_payload)

    @property
    def _wrench(self) -> ToolWrench:
        if self._tool_wrench is None:
            self._tool_wrench = ToolWrench(self._model, self.parts.flange, self._engine)
            self._tool_wrench.subtract(self._known_payload)
        return self._tool_wrench

    @property
    def _known_payload(self) -> Payload | None:
        return self._hardware.payloads.get(self.parts.flange)

    # ---- modes ----------------------------------------------------------------------

    def _shown_modes(self) -> Modes:
        """Return the modes to show; an emergency stop hides the modes of the arm."""
        if self._hardware.is_stopped:
            return Modes(RobotMode.POWER_OFF, SafetyMode.ROBOT_EMERGENCY_STOP)
        return self._modes

    def _obstacle(self) -> str:
        return self._modes.obstacle(self.name, self.box.state.protective_stop)

    def _why_stopped(self) -> str:
        """Return an empty text: the controllers may be started without ``play``."""
        return ""
