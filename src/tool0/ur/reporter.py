"""Reports of a control box's activity for the panel, and safety limits for its arm."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final, final

from tool0.protocol.control_box import (
    MOST_POPUP,
    MOST_PROGRAM,
    ReportUr,
    SetSafetyLimits,
)
from tool0.ur.listening import count_clients

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.registers import RegisterBank

PERIOD: Final = 0.1
"""Period of the checks for changes [wall s]."""


@final
class Reporter:
    """Enables a UR's safety limits for the arm, and sends reports to the bring-up."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._host = ""
        self._task: asyncio.Task[None] | None = None

    async def start(self, host: str, port_base: int) -> None:
        """Enable the limits and start the reports; no port is opened."""
        del port_base
        self._host = host
        await self._box.call(SetSafetyLimits(arm=self._box.arm, enabled=True))
        self._task = asyncio.create_task(self._run())

    async def close(self) -> None:
        """Stop reporting."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task

    async def _run(self) -> None:
        last: ReportUr | None = None
        while True:
            report = self._report()
            if report != last:
                last = report
                self._box.send(report)
            await asyncio.sleep(PERIOD)

    def _report(self) -> ReportUr:
        programs, popup = self._box.programs, self._box.messages.popup
        return ReportUr(
            arm=self._box.arm,
            program=programs.name[:MOST_PROGRAM] if programs.is_running else "",
            program_state=programs.state.name,
            popup=None if popup is None else popup.text[:MOST_POPUP],
            clients=count_clients(self._host),
            registers=self._registers(),
        )

    def _registers(self) -> Mapping[str, bool | int | float]:
        registers = self._box.registers
        return {
            f"{direction}_{name}": value
            for direction, bank in (
                ("output", registers.outputs),
                ("input", registers.inputs),
            )
            for name, value in _set_registers(bank)
        }


def _set_registers(bank: RegisterBank) -> Iterator[tuple[str, bool | int | float]]:
    """Yield the registers with values that are neither zero nor infinite."""
    kinds = (("bit", bank.bits), ("int", bank.integers), ("double", bank.doubles))
    for kind, values in kinds:
        for number, value in enumerate(values):
            if value and math.isfinite(value):
                yield f"{kind}_register_{number}", value
