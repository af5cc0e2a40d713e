"""Torques of a program, which apply for one control period, as on a real robot.

A program sets torques in every control period; otherwise, the arm returns to position
control and decelerates to rest. Programs run in a separate process, so they may receive
updates late and miss a period. Torque control therefore ends after the second period
without torques. If the program hangs, the simulation ends torque control.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

from tool0.errors import ControlError
from tool0.protocol.arm_motion import (
    COULOMB_SCALE,
    VISCOUS_SCALE,
    DriveTorques,
    EndTorques,
)
from tool0.ur.pacer import Pacer

if TYPE_CHECKING:
    from tool0.protocol.state import Six
    from tool0.ur.control_box import UrControlBox

MISSED: Final = 2
"""Number of consecutive updates without torques after which torque control ends."""
HANGING: Final = 0.04
"""Simulated time after which torque control ends if the program gets no updates [s]."""


@final
class Torques:
    """Controls the arm of a control box with torques for one program."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._pacer = Pacer(box)
        self._missed = 0
        self._is_driving = False

    async def drive(
        self,
        torques: Six,
        viscous_scale: Six = VISCOUS_SCALE,
        coulomb_scale: Six = COULOMB_SCALE,
    ) -> None:
        """Apply torques to the joints [N·m] and return after one control period.

        Raises:
            ControlError: If the arm cannot be controlled with torques.
        """
        await self.set(torques, viscous_scale, coulomb_scale)
        await self._pacer.wait(1.0 / self._box.rate)

    async def set(
        self,
        torques: Six,
        viscous_scale: Six = VISCOUS_SCALE,
        coulomb_scale: Six = COULOMB_SCALE,
    ) -> None:
        """Apply torques to the joints [N·m] without waiting for a control period.

        Raises:
            ControlError: If the arm cannot be controlled with torques.
        """
        box = self._box
        if not box.is_e_series:
            raise ControlError(
                "a CB3 has no torque control; use an arm of the e-Series, such as ur5e"
            )
        request = DriveTorques(
            arm=box.arm,
            torques=torques,
            viscous_scale=viscous_scale,
            coulomb_scale=coulomb_scale,
            duration=HANGING,
        )
        self._missed = 0
        if self._is_driving:
            box.send(request)
            return
        await box.call(request)
        self._is_driving, self._missed = True, 0
        box.when_updated.add(self._look)

    def _look(self) -> None:
        """Count an update; end torque control if too many updates had no torques."""
        self._missed += 1
        if self._missed > MISSED:
            self._is_driving = False
            self._box.when_updated.discard(self._look)
            if not self._box.stopped:
                self._box.send(EndTorques(arm=self._box.arm))
