"""Writer of one MCAP file with channels, messages, chunks and attachments."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from tool0.errors import RecordingError
from tool0.recording.message_types import definition

if TYPE_CHECKING:
    from collections.abc import Mapping

LARGEST_CHUNK: Final = 256 * 1024
"""Size at which a chunk ends, unless it is flushed earlier [bytes].  The compression of
a chunk takes less than a millisecond, during which the interpreter's lock is
released."""


@final
class _Output:
    """Unbuffered output file, which has no pending data after a failed write."""

    def __init__(self, path: Path, *, overwrite: bool) -> None:
        mode = os.O_WRONLY | os.O_CREAT | (os.O_TRUNC if overwrite else os.O_EXCL)
        self._file = os.open(path, mode | getattr(os, "O_CLOEXEC", 0), 0o644)
        self._position = 0

    def write(self, data: bytes) -> int:
        left = memoryview(data)
        while left:
            done = os.write(self._file, left)
            self._position += done
            left = left[done:]
        return len(data)

    def tell(self) -> int:
        return self._position

    def flush(self) -> None:
        pass

    def cut(self, size: int) -> None:
        """Truncate the file to ``size`` [bytes] if possible."""
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, size)
            self._position = size

    def close(self) -> None:
        os.close(self._file)


@final
class McapFile:
    """Writer of one file.  If a method raises OSError, the caller must close the file.

    Flushed data can be read regardless of how the process ends.
    """

    def __init__(self, path: Path, *, overwrite: bool = False) -> None:
        """Create the file.

        Raises:
            RecordingError: If the file cannot be written or already exists.
        """
        from mcap.writer import CompressionType, Writer

        self.path = path
        try:
            self._output = _Output(path, overwrite=overwrite)
        except FileExistsError:
            raise RecordingError(
                f"{path} exists already; choose another name, or overwrite it "
                "(--overwrite)"
            ) from None
        except OSError as error:
            raise RecordingError(f"cannot write {path}: {error.strerror}") from error
        output: Any = self._output  # provides the writer's stream methods
        self._writer: Any = Writer(  # not fully typed
            output,
            chunk_size=LARGEST_CHUNK,
            compression=CompressionType.ZSTD,
            enable_data_crcs=True,
        )
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._written = 0
        try:
            self._writer.start(profile="ros2", library="tool0")
        except OSError as error:
            self.abandon()
            raise RecordingError(f"cannot write {path}: {error.strerror}") from error
        self._written = self.size

    @property
    def size(self) -> int:
        """Number of bytes that have been written."""
        return self._output.tell()

    def write(
        self, topic: str, kind: str, time: int, data: bytes, sequence: int = 0
    ) -> None:
        """Add a message with its time [ns]; ``flush`` writes the message."""
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._channel(topic, kind)
        self._writer.add_message(channel, time, data, time, sequence)

    def attach(self, name: str, media_type: str, data: bytes, time: int = 0) -> None:
        """Add an attachment, which is a file inside the MCAP file."""
        self._writer.flush()  # keeps the order of messages and attachments
        self._writer.add_attachment(0, time, name, media_type, data)
        self._written = self.size

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Add metadata with a name."""
        self._writer.add_metadata(name, dict(values))
        self._written = self.size

    def flush(self) -> None:
        """Write all pending messages as one chunk."""
        self._writer.flush()
        self._written = self.size

    def finish(self) -> None:
        """Write the index and close the file."""
        self._writer.finish()
        self._output.close()

    def abandon(self) -> None:
        """Close the file without an index after an error; flushed data can be read."""
        self._output.cut(self._written)
        self._output.close()

    def _channel(self, topic: str, kind: str) -> int:
        schema = self._schemas.get(kind)
        if schema is None:
            text = definition(kind).encode()
            schema = int(self._writer.register_schema(kind, "ros2msg", text))
            self._schemas[kind] = schema
        return int(self._writer.register_channel(topic, "cdr", schema))
