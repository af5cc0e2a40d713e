"""A gripper that is polled by a thread, which also sends the newest command to it."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final, final

from tool0.devices.gripper_links import GripperLink, GripperReading
from tool0.devices.robotiq_registers import Activation, CommandRegisters
from tool0.errors import TransportError

logger = logging.getLogger(__name__)

PERIOD: Final = 0.016
"""Period of the readings [s]. The URCap does not support much shorter periods."""
RETRY: Final = 1.0
"""Delay between attempts to connect [s]."""
_ACTIVE: Final = CommandRegisters(activate=True)


@final
class PolledGripper:
    """Reads and commands a gripper in a dedicated thread.

    After the connection, the power or the activation is lost, earlier commands are not
    sent again.
    """

    def __init__(self, connect: Callable[[], GripperLink], name: str) -> None:
        """Start the thread, which retries ``connect`` after a TransportError."""
        self._connect, self._name = connect, name
        self._wanted: CommandRegisters | None = None
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._is_closing = False
        self.reading: GripperReading | None = None
        """Newest reading; None if there is no reading."""
        self.read_at = 0.0
        """Time at which the newest reading was received, on the monotonic clock [s]."""
        self.problem = "it was not read yet"
        """Reason why the gripper is not ready; empty if it is ready."""
        self._last = _ACTIVE
        """Last command that was sent to the gripper."""
        self.is_sent = True
        """Whether a reading has been received since the newest command was sent."""
        self._thread = threading.Thread(
            target=self._run, name=f"tool0 {name}", daemon=True
        )
        self._thread.start()

    def move(self, position: int, speed: int, force: int) -> None:
        """Move the fingers to a position count; a newer command replaces this one."""
        command = CommandRegisters(
            activate=True, go_to=True, position=position, speed=speed, force=force
        )
        with self._lock:
            if command == self._last and self.reading is not None:
                return
            self._wanted, self.is_sent = command, False
        self._wake.set()

    def stop(self) -> None:
        """Stop the fingers at their current position."""
        with self._lock:
            self._wanted, self.is_sent = replace(self._last, go_to=False), False
        self._wake.set()

    def activate(self) -> None:
        """Activate the gripper; the activation opens and closes the gripper."""
        with self._lock:
            self._wanted, self.is_sent = _ACTIVE, False
        self._wake.set()

    def close(self) -> None:
        """Stop the thread; the fingers continue with the last command."""
        self._is_closing = True
        self._wake.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._is_closing:
            try:
                link = self._connect()
            except TransportError as error:
                self._note_loss(str(error))
                self._wake.wait(RETRY)
                self._wake.clear()
                continue
            try:
                while not self._is_closing:
                    self._exchange(link)
                    self._wake.wait(PERIOD)
                    self._wake.clear()
            except TransportError as error:
                self._note_loss(str(error))
            finally:
                link.close()

    def _exchange(self, link: GripperLink) -> None:
        with self._lock:
            wanted, self._wanted = self._wanted, None
        if wanted is not None:
            link.write(wanted)
            self._last = wanted
        reading = link.read()
        if reading is None:
            self._note_loss("it has no power: switch the robot on")
            return
        if reading.activation is Activation.RESET:
            self._last = CommandRegisters()
        with self._lock:
            self.reading, self.read_at = reading, time.monotonic()
            is_active = reading.activation is Activation.COMPLETE
            self.problem = "" if is_active else "it is not activated"
            self.is_sent = self._wanted is None

    def _note_loss(self, problem: str) -> None:
        """Discard the command, so that the fingers move only after a new command."""
        if problem != self.problem:
            logger.warning("%s: %s", self._name, problem)
        with self._lock:
            self.reading, self.problem = None, problem
            self._wanted, self._last = None, CommandRegisters()
