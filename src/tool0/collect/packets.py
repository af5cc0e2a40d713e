"""Messages between the driver and workers: a JSON header and blocks of bytes.

Ray and sockets transfer the same messages, which contain neither code nor pickled
objects.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any, Final

_LENGTH: Final = struct.Struct("<Q")


def packed(header: dict[str, Any], blocks: Sequence[bytes] = ()) -> bytes:
    """Return a message; ``unpacked`` is the inverse function."""
    lengths = [len(block) for block in blocks]
    text = json.dumps({**header, "blocks": lengths}).encode()
    return b"".join((_LENGTH.pack(len(text)), text, *blocks))


def unpacked(message: bytes) -> tuple[dict[str, Any], list[bytes]]:
    """Return the header and the blocks of a message."""
    start = _LENGTH.size + _LENGTH.unpack_from(message)[0]
    header = json.loads(message[_LENGTH.size : start])
    blocks = []
    for length in header.pop("blocks"):
        blocks.append(message[start : start + length])
        start += length
    return header, blocks


def framed(message: bytes) -> bytes:
    """Return a message for a stream, with the length before the content."""
    return _LENGTH.pack(len(message)) + message


def take_frame(buffer: bytearray) -> bytes | None:
    """Remove and return the first complete message in ``buffer``, or return None."""
    if len(buffer) < _LENGTH.size:
        return None
    end = _LENGTH.size + _LENGTH.unpack_from(buffer)[0]
    if len(buffer) < end:
        return None
    message = bytes(memoryview(buffer)[_LENGTH.size : end])
    del buffer[:end]
    return message
