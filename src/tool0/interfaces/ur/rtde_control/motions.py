"""The commands of ur_rtde's control program that move the arm."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Coroutine, Sequence
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np

from tool0.interfaces.ur.moves import Moves
from tool0.interfaces.ur.pose import rotation_of
from tool0.interfaces.ur.rtde_control.exchange import Exchange
from tool0.kinematics.moves import Move
from tool0.requests.arm_motion import (
    EndForceMode,
    EndFreedrive,
    ServoJoints,
    SpeedJoints,
    SpeedTool,
    StartForceMode,
    StartFreedrive,
)

if TYPE_CHECKING:
    from tool0.interfaces.ur.box import Box
    from tool0.interfaces.ur.tool_contact import ToolHistory
    from tool0.requests.updates import Six

JOG_STOP, CONTACT_STOP, FORCE_STOP = 1.2, 3.0, 10.0
"""How the program slows the tool down after jogging, a contact, force mode [m/s²]."""
RETURN_ACCELERATION, RETURN_SPEED = 1.2, 0.25
"""On the way back to a contact: URScript's defaults [m/s², m/s]."""
DAMPING, GAIN_SCALING = 0.025, 0.5
"""Of force mode, as the program begins."""
BASE, TOOL, CUSTOM = 0, 1, 2
"""The frames of jogging."""


@final
class Motions:
    """Moves one arm; a new motion replaces an asynchronous one that still runs."""

    def __init__(
        self,
        box: Box,
        exchange: Exchange,
        history: ToolHistory,
        path: Sequence[Move],
        wake: Callable[[], None],
    ) -> None:
        self._box, self._exchange, self._history = box, exchange, history
        self._path, self._wake = path, wake
        self._moves = Moves(box)
        self._task: asyncio.Task[None] | None = None
        """An asynchronous motion."""
        self._failure: BaseException | None = None
        self._is_tool_speed = False
        self._force: StartForceMode | None = None
        self._damping, self._gain_scaling = DAMPING, GAIN_SCALING
        self._jog_frame = np.eye(3)
        self._is_jogging = False
        self._detection: asyncio.Task[None] | None = None
        self._is_contact_new = False
        self.contact_steps = 0
        """How many updates before its detection the last contact began; 0 without."""
        self.waypoint: Six = box.tcp_pose(target=True)
        """The pose that the last move goes to."""

    # ---- asynchronous motions -------------------------------------------------------

    def check(self) -> None:
        """Raise what ended an asynchronous motion."""
        if self._failure is not None:
            raise self._failure

    async def close(self) -> None:
        """End asynchronous motions."""
        await self._cancel()
        if self._detection is not None:
            self._detection.cancel()

    async def _cancel(self) -> None:
        """End the asynchronous motion, if there is one: the arm slows down."""
        task, self._task = self._task, None
        if task is None or task.done():
            return
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
        self._exchange.show_progress(None)

    async def _run(self, motion: Coroutine[Any, Any, None]) -> None:
        """Execute a motion to its end, or start it, as the client wants."""
        if self._exchange.integer(1) != 1:
            await motion
            return
        self._exchange.show_progress(0)
        self._task = asyncio.create_task(self._report(motion))

    async def _report(self, motion: Coroutine[Any, Any, None]) -> None:
        try:
            await motion
        except asyncio.CancelledError:
            raise
        except BaseException as error:
            self._failure = error
            self._wake()
        else:
            self._exchange.show_progress(None)
