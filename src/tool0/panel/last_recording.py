"""The last completed recording, which pages can download or replay."""

from __future__ import annotations

import asyncio
import os
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.errors import RecordingError
from tool0.installation.child_process import ChildProcess, last_lines
from tool0.protocol.recordings import ReadRecording

if TYPE_CHECKING:
    from tool0.protocol.backend import Backend

_STARTS_WITHIN: Final = 60.0
"""Longest wait for the address of the page of a replay [wall s]."""
_GRACE: Final = 3.0
"""Time within which the replay process must end when it is stopped [wall s]."""
_PANEL: Final = "Panel: "


@final
class LastRecording:
    """Finds the last recording and replays it in a separate process.

    The process ends when this object is closed or another recording is replayed.
    """

    def __init__(self, backend: Backend, host: str) -> None:
        """Store the settings; ``host`` is the address on which replays listen."""
        self._backend = backend
        self._host = host
        self._replay: _ReplayProcess | None = None
        self._starting = asyncio.Lock()

    async def file(self) -> Path | None:
        """Return the last completed file; None if there is no such file."""
        if self._backend.why_missing(ReadRecording):
            return None
        status = await asyncio.to_thread(self._backend.answer, ReadRecording())
        if status is None or status.is_recording:
            return None
        file = Path(status.file)
        return file if file.is_file() else None

    async def replay(self, file: Path) -> str:
        """Start replaying a file unless it is already being replayed.

        Return the page's address.

        Raises:
            RecordingError: If the replay does not start.
        """
        async with self._starting:
            replay = self._replay
            if replay is None or replay.file != file or replay.has_ended:
                await self.close()
                replay = self._replay = _ReplayProcess(file, self._host)
            return await asyncio.to_thread(replay.address)

    async def close(self) -> None:
        """End the replay, if there is one."""
        replay, self._replay = self._replay, None
        if replay is not None:
            await asyncio.to_thread(replay.close)


@final
class _ReplayProcess:
    """A process that runs ``tool0 replay`` on a file."""

    def __init__(self, file: Path, host: str) -> None:
        self.file = file
        self._lines: list[str] = []
        self._address: str | None = None
        self._is_known = threading.Event()
        ours, theirs = os.pipe()
        with open(theirs, "wb") as log:  # noqa: PTH123  # a descriptor
            options = ("--panel-host", host, "--no-open")
            self._child = ChildProcess(
                [sys.executable, "-m", "tool0", "replay", str(file), *options],
                environment={**os.environ, "PYTHONUNBUFFERED": "1"},
                log=log,
                grace=_GRACE,
            )
        self._reader = threading.Thread(
            target=self._read, args=(ours,), name="tool0 replay", daemon=True
        )
        self._reader.start()

    @property
    def has_ended(self) -> bool:
        return self._child.exit_status is not None

    def address(self) -> str:
        """Wait for the address of the page, and return it."""
        self._is_known.wait(_STARTS_WITHIN)
        if self._address is None:
            why = last_lines("\n".join(self._lines)) or "it says nothing"
            raise RecordingError(f"the replay of {self.file} does not start:\n{why}")
        return self._address

    def close(self) -> None:
        self._child.close()
        self._reader.join()

    def _read(self, descriptor: int) -> None:
        """Read all output of the process, so that it never blocks."""
        with open(descriptor, encoding="utf-8", errors="replace") as output:
            for line in output:
                if self._is_known.is_set():
                    continue
                self._lines.append(line)
                if line.startswith(_PANEL):
                    self._address = line.removeprefix(_PANEL).strip()
                    self._is_known.set()
        self._is_known.set()
