"""Journal of the requests that changed the simulation, as messages in one file."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final, final

import msgspec
from msgspec import Raw

from tool0.errors import RequestError
from tool0.protocol.request import method_name
from tool0.recording.cdr import encode_text
from tool0.recording.frames import stamp
from tool0.recording.mcap_file import McapFile
from tool0.recording.message_types import TEXT
from tool0.simulation.handlers.journal_codec import params_of

if TYPE_CHECKING:
    from tool0.simulation.journal import Executed, Journal

REQUESTS: Final = "/tool0/requests"


@final
class RequestWriter:
    """Writer of a simulation's complete journal, from which the run can be repeated.

    A file that begins after the bring-up also contains all earlier requests.
    """

    def __init__(self, file: McapFile, journal: Journal) -> None:
        self._file = file
        self._journal = journal
        self._last = -1

    def write_new(self) -> None:
        """Add the requests since the last call."""
        while entries := self._journal.after(self._last):
            for entry in entries:
                text = encode_text(msgspec.json.encode(_content(entry)))
                self._file.write(REQUESTS, TEXT, stamp(entry.time), text, entry.step)
                self._last = entry.number
                time.sleep(0.0)  # gives other threads the interpreter


def _content(entry: Executed) -> dict[str, Any]:
    request: Any = entry.request
    content = {
        "number": entry.number,
        "step": entry.step,
        "tick": entry.tick,
        "time": entry.time,
        "method": method_name(type(request)),
        "params": None,
        "error": entry.error,
    }
    try:
        return {**content, "params": Raw(params_of(request))}
    except RequestError as error:
        return {**content, "unrepeatable": str(error)}
