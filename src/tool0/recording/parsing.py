"""Parser for the records of an MCAP file, which may be truncated."""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, Final, final

from tool0.errors import RecordingError

_MAGIC: Final = b"\x89MCAP0\r\n"
_RECORD: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")
_CHECKSUM: Final = struct.Struct("<I")
"""CRC-32 checksum of the preceding bytes; 0 if the checksum was not computed."""
_LARGEST: Final = 1 << 30
"""Largest unpacked size of an accepted chunk [bytes]."""


@final
@dataclass(slots=True)
class Stream:
    """The messages of one topic, in the order of the file."""

    topic: str
    kind: str
    """The message type, such as ``std_msgs/msg/String``."""
    frames: list[int] = field(default_factory=list)
    """Number of the snapshot to which each message belongs."""
    times: list[int] = field(default_factory=list)
    """Log times of the messages [ns]."""
    sequence: list[int] = field(default_factory=list)
    """Step of each message, as the number of control periods since the bring-up."""
    messages: list[bytes] = field(default_factory=list)


@final
@dataclass(slots=True)
class Parsed:
    """Contents of an MCAP file."""

    streams: dict[str, Stream] = field(default_factory=dict)
    """Streams of messages by topic."""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    """Metadata by name; later values replace earlier values."""
    attachments: dict[str, bytes] = field(default_factory=dict)
    is_complete: bool = False
    """Whether the file was finished; otherwise, the contents end after the last
    complete chunk."""


def parse(path: Path, frame_topic: str) -> Parsed:
    """Return the contents of an MCAP file.

    Each message on ``frame_topic`` begins a new frame.

    Raises:
        RecordingError: If the file cannot be read, is not an MCAP file, or is damaged.
    """
    parser = _Parser(frame_topic)
    try:
        with path.open("rb") as file:
            _check_kind(path, file.read(len(_MAGIC)))
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                parser.read(data)
    except OSError as error:
        reason = error.strerror or error
        raise RecordingError(f"cannot read {path}: {reason}") from error
    except RecordingError:
        raise
    except Exception as error:  # raised by mcap and the compression libraries
        raise RecordingError(
            f"{path} is damaged at byte {parser.at}: "
            f"{str(error) or 'a record is incomplete'}"
        ) from error
    return parser.parsed


def _check_kind(path: Path, begin: bytes) -> None:
    """Raise RecordingError if a file does not begin with the header of an MCAP file."""
    if not begin:
        raise RecordingError(f"{path} is empty")
    if begin != _MAGIC:
        raise RecordingError(f"{path} is no MCAP file: it begins with {begin!r}")


@final
class _Parser:
    """Decoder of a file's records."""

    def __init__(self, frame_topic: str) -> None:
        self.parsed = Parsed()
        self.at = 0
        """Offset at which the current record begins [bytes]."""
        self._frame_topic = frame_topic
        self._frame = -1
        self._kinds: dict[int, str] = {0: ""}
        self._streams: dict[int, Stream] = {}

    def read(self, data: mmap.mmap) -> None:
        from mcap.opcode import Opcode
        from mcap.records import Attachment, Chunk, Metadata

        for opcode, start, end in self._records(data):
            if opcode == Opcode.CHUNK:
                self._read_chunk(Chunk.read(_stream(data[start:end])))
            elif opcode == Opcode.ATTACHMENT:
                record = data[start:end]
                found = Attachment.read(_stream(record))
                _check(f"attachment '{found.name}'", record[:-4], record[-4:])
                self.parsed.attachments[found.name] = found.data
            elif opcode == Opcode.METADATA:
                note = Metadata.read(_stream(data[start:end]))
                self.parsed.metadata.setdefault(note.name, {}).update(note.metadata)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                self._read_record(opcode, data[start:end])
            elif opcode == Opcode.DATA_END:
                with memoryview(data) as view, view[: self.at] as section:
                    _check("what precedes it", section, data[start:end])
                self.parsed.is_complete = _is_finished(data)
                return
        if _is_finished(data):
            raise ValueError("the record that ends the data is missing")

    def _records(self, data: mmap.mmap) -> Iterator[tuple[int, int, int]]:
        """Yield the opcode, the start and the end of each complete record."""
        self.at = len(_MAGIC)
        while self.at + _RECORD.size <= len(data):
            opcode, length = _RECORD.unpack_from(data, self.at)
            start = self.at + _RECORD.size
            end = start + length
            if end > len(data):
                if _is_finished(data):
                    raise ValueError(f"a record of {length} bytes exceeds the file")
                return
            yield opcode, start, end
            self.at = end

    def _read_chunk(self, chunk: Any) -> None:
        from mcap.stream_reader import get_chunk_data_stream

        if chunk.uncompressed_size > _LARGEST:
            raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes")
        stream, size = get_chunk_data_stream(chunk, validate_crc=True)
        data = stream.read(size)
        at = 0
        while at < size:
            opcode, length = _RECORD.unpack_from(data, at)
            at += _RECORD.size
            self._read_record(opcode, data[at : at + length])
            at += length

    def _read_record(self, opcode: int, data: bytes) -> None:
        from mcap.opcode import Opcode
        from mcap.records import Channel, Schema

        if opcode == Opcode.MESSAGE:
            number, sequence, time, _ = _MESSAGE.unpack_from(data)
            stream = self._streams[number]
            if stream.topic == self._frame_topic:
                self._frame += 1
            stream.frames.append(max(self._frame, 0))
            stream.times.append(time)
            stream.sequence.append(sequence)
            stream.messages.append(data[_MESSAGE.size :])
        elif opcode == Opcode.SCHEMA:
            schema = Schema.read(_stream(data))
            self._kinds[schema.id] = schema.name
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(_stream(data))
            if channel.id not in self._streams:
                stream = Stream(channel.topic, self._kinds[channel.schema_id])
                self._streams[channel.id] = stream
                self.parsed.streams[channel.topic] = stream


def _is_finished(data: mmap.mmap) -> bool:
    return len(data) > len(_MAGIC) and data[-len(_MAGIC) :] == _MAGIC


def _check(name: str, data: bytes | memoryview, checksum: bytes) -> None:
    """Raise ValueError if ``data`` does not match its checksum."""
    (expected,) = _CHECKSUM.unpack(checksum)
    if expected not in (0, zlib.crc32(data)):
        raise ValueError(f"{name} does not have its checksum")


def _stream(data: bytes) -> Any:
    from mcap.data_stream import ReadDataStream

    return ReadDataStream(BytesIO(data))
