"""The commands of ur_rtde's control program that make the arm compliant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, cast, final

from msgspec import structs

from tool0.errors import ControlError
from tool0.protocol.arm_motion import (
    EndForceMode,
    EndFreedrive,
    StartForceMode,
    StartFreedrive,
)

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.moves import Moves
    from tool0.ur.rtde_control.exchange import Exchange

DAMPING: Final = 0.025
GAIN_SCALING: Final = 0.5
"""Damping and gain of force mode at the start of the program."""
FORCE_STOP: Final = 10.0
"""Deceleration of the tool when the program ends force mode [m/s²]."""


@final
class Compliance:
    """Force mode and freedrive of an arm."""

    def __init__(self, box: UrControlBox, exchange: Exchange, moves: Moves) -> None:
        self._box, self._exchange, self._moves = box, exchange, moves
        self._force: StartForceMode | None = None
        self._damping, self._gain_scaling = DAMPING, GAIN_SCALING

    async def force_mode(self) -> None:
        """Comply along some axes of a frame and press along them: force_mode."""
        exchange = self._exchange
        a, b, c, d, e, f = (exchange.integer(k) != 0 for k in range(2, 8))
        kind = exchange.integer(1)
        if kind not in {1, 2, 3}:
            raise ControlError(f"force_mode: the type must be 1, 2 or 3, got {kind}")
        self._force = StartForceMode(
            arm=self._box.arm,
            frame=exchange.six(0),
            selection=(a, b, c, d, e, f),
            wrench=exchange.six(6),
            kind=cast(Literal[1, 2, 3], kind),
            limits=exchange.six(12),
            tcp=self._box.tcp,
            damping=self._damping,
            gain_scaling=self._gain_scaling,
        )
        self._box.send(self._force)

    async def end_force_mode(self) -> None:
        """End the compliance of the arm: end_force_mode."""
        self._force = None
        await self._box.call(EndForceMode(arm=self._box.arm))
        await self._moves.stopl(FORCE_STOP)

    def set_damping(self) -> None:
        """Set the damping of force mode, 0 … 1."""
        self._damping = self._exchange.number(0)
        self._renew_force_mode()

    def set_gain_scaling(self) -> None:
        """Set the gain of force mode, 0 … 2."""
        self._gain_scaling = self._exchange.number(0)
        self._renew_force_mode()

    def _renew_force_mode(self) -> None:
        if self._force is not None:
            self._force = structs.replace(
                self._force, damping=self._damping, gain_scaling=self._gain_scaling
            )
            self._box.send(self._force)

    async def start_teaching(self) -> None:
        """Start manual guidance of the arm: teach_mode."""
        await self._box.call(StartFreedrive(arm=self._box.arm))

    async def start_freedrive(self) -> None:
        """Start manual guidance along some axes of a frame: freedrive_mode."""
        exchange = self._exchange
        a, b, c, d, e, f = (exchange.integer(k) != 0 for k in range(1, 7))
        request = StartFreedrive(
            arm=self._box.arm, axes=(a, b, c, d, e, f), frame=exchange.six(0)
        )
        await self._box.call(request)

    async def end_freedrive(self) -> None:
        """Hold the arm's position again: end_freedrive_mode, end_teach_mode."""
        await self._box.call(EndFreedrive(arm=self._box.arm))
