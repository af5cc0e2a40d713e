"""Samples of the arms on demand: what moves each, and the wrench on its tool."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from tool0.description.model import RobotModel
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.state import ArmSample, Contact
from tool0.sensing.tool_wrench import ToolWrench
from tool0.simulation.arm_motions import ArmMotions
from tool0.simulation.control_boxes import ControlBoxes


@final
class ArmSamples:
    """Samples the arms between two ticks.  Only the thread of the tick may use it."""

    def __init__(
        self,
        model: RobotModel,
        engine: Engine,
        hardware: RobotHardware,
        boxes: ControlBoxes,
        motions: ArmMotions,
    ) -> None:
        self._model, self._engine, self._hardware = model, engine, hardware
        self._boxes, self._motions = boxes, motions
        self._wrenches: dict[str, ToolWrench] = {}
        """On the tools of arms that were sampled, by arm."""

    def read(
        self,
        now: float,
        before: JointState,
        after: JointState,
        forces: tuple[Contact, ...],
    ) -> Mapping[str, ArmSample]:
        """Return what moves each arm ``now`` [s], and the wrench on its tool.

        The last step was from ``before`` to ``after``, with these external ``forces``.
        """
        return {
            arm: self._motions.sample(
                arm, now, self._wrench(arm).read(before, after, forces)
            )
            for arm in self._motions.specs
        }

    def zero(self, arm: str | None) -> None:
        """Let the wrench on an arm's tool be that of the last sample from now on."""
        self._wrench(self._boxes.find(arm).arm).zero()

    def note_payloads(self) -> None:
        """Subtract other payloads from now on."""
        for arm, wrench in self._wrenches.items():
            wrench.subtract(self._hardware.payloads.get(self._boxes.flange(arm)))

    def _wrench(self, arm: str) -> ToolWrench:
        found = self._wrenches.get(arm)
        if found is None:
            flange = self._boxes.flange(arm)
            self._wrenches[arm] = found = ToolWrench(self._model, flange, self._engine)
            found.subtract(self._hardware.payloads.get(flange))
        return found
