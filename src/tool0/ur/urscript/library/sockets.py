"""Functions for TCP sockets. All timeouts are wall time, not simulated time."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable
from typing import Annotated, Final, TypeAlias, TypeVar

from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import AnyValue, Bool, Integer, Kind, Number, Text
from tool0.ur.urscript.values import Value, checked_integer, to_text
from tool0.ur.urscript_errors import ValueProblem

T = TypeVar("T")

DEFAULT: Final = "socket_0"
MAX_VALUES: Final = 30
"""Maximum number of values or bytes in one read."""
MAX_STRING: Final = 1024
"""Maximum length of a string in one read [bytes]."""
TIMEOUT: Final = 2.0
"""Default timeout [wall s]."""
_ESCAPES: Final = (("\\n", "\n"), ("\\r", "\r"), ("\\t", "\t"))


def _count(value: Value) -> int:
    if type(value) is not int or not 1 <= value <= MAX_VALUES:
        raise ValueProblem(f"an integer from 1 to {MAX_VALUES} is needed")
    return value


def _port(value: Value) -> int:
    if type(value) is not int or not 0 < value < 1 << 16:
        raise ValueProblem("a port is an integer from 1 to 65535")
    return value


Count: TypeAlias = Annotated[int, Kind("an integer from 1 to 30", _count)]
PortNumber: TypeAlias = Annotated[int, Kind("a port", _port)]


async def socket_open(
    thread: Thread, address: Text, port: PortNumber, socket_name: Text = DEFAULT
) -> bool:
    """Connect to a server within 2 s; return whether the connection was opened.

    The call takes at least one control period. Servers therefore accept consecutive
    connections in the order in which the calls are made, even if each server accepts in
    a separate thread.
    """
    is_open = await thread.execution.sockets.open(address, port, socket_name)
    await thread.pacer.wait(1.0 / thread.box.rate)
    return is_open


async def socket_close(thread: Thread, socket_name: Text = DEFAULT) -> None:
    """Close a connection."""
    thread.execution.sockets.close(socket_name)


async def _send(thread: Thread, data: bytes, name: str) -> bool:
    connection = thread.execution.sockets.find(name)
    return connection is not None and await connection.send(data)


async def _receive(
    thread: Thread,
    name: str,
    find: Callable[[bytearray], T | None],
    timeout: float,
) -> T | None:
    connection = thread.execution.sockets.find(name)
    if connection is None:
        return None
    found = connection.take(find)  # without a wait if the data has been received
    if found is not None:
        return found
    return await connection.receive(find, timeout)


async def socket_send_string(
    thread: Thread, str_: AnyValue, socket_name: Text = DEFAULT
) -> bool:
    """Send a string; return whether it was sent."""
    return await _send(thread, to_text(str_).encode("latin-1"), socket_name)


async def socket_send_line(
    thread: Thread, str_: AnyValue, socket_name: Text = DEFAULT
) -> bool:
    """Send a string and a new line; return whether it was sent."""
    return await _send(thread, to_text(str_).encode("latin-1") + b"\n", socket_name)


async def socket_send_byte(
    thread: Thread, value: Integer, socket_name: Text = DEFAULT
) -> bool:
    """Send a byte; return whether it was sent."""
    return await _send(thread, bytes([value & 0xFF]), socket_name)


async def socket_send_int(
    thread: Thread, value: Integer, socket_name: Text = DEFAULT
) -> bool:
    """Send a 32-bit integer in network byte order; return whether it was sent."""
    return await _send(thread, struct.pack(">i", value), socket_name)


async def socket_set_var(
    thread: Thread, name: Text, value: Integer, socket_name: Text = DEFAULT
) -> None:
    """Send ``SET <name> <value>`` and a new line."""
    await _send(thread, f"SET {name} {value}\n".encode("latin-1"), socket_name)


async def socket_get_var(
    thread: Thread, name: Text, socket_name: Text = DEFAULT
) -> Value:
    """Send ``GET <name>``; return the integer in the answer, or 0 on failure."""
    await _send(thread, f"GET {name}\n".encode("latin-1"), socket_name)
    line = await _receive(thread, socket_name, _line, TIMEOUT)
    match = re.fullmatch(r"\s*(\S+)\s+(-?[0-9]{1,10})\s*", line or "")
    if match is None or match.group(1) != name:
        return 0
    return checked_integer(int(match.group(2)))


async def socket_read_ascii_float(
    thread: Thread,
    number: Count,
    socket_name: Text = DEFAULT,
    timeout: Number = TIMEOUT,
) -> Value:
    """Return n numbers ``(a, b, …)`` as [n, a, b, …], or [0, nan, …] on failure."""
    text = await _receive(thread, socket_name, _in_brackets, timeout)
    try:
        values = [float(word) for word in (text or "").split(",")]
    except ValueError:
        values = []
    if len(values) < number:
        return (0, *(math.nan for _ in range(number)))
    return (float(number), *values[:number])


async def _read_numbers(
    thread: Thread, name: str, number: int, code: str, timeout: float
) -> Value:
    size = number * struct.calcsize(code)

    def find(buffer: bytearray) -> bytes | None:
        return _taken(buffer, size) if len(buffer) >= size else None

    data = await _receive(thread, name, find, timeout)
    if data is None:
        return (0, *(-1 for _ in range(number)))
    return (number, *struct.unpack(f">{number}{code}", data))


async def socket_read_binary_integer(
    thread: Thread,
    number: Count,
    socket_name: Text = DEFAULT,
    timeout: Number = TIMEOUT,
) -> Value:
    """Return n 32-bit integers as [n, a, b, …], or [0, -1, …] on failure."""
    return await _read_numbers(thread, socket_name, number, "i", timeout)


async def socket_read_byte_list(
    thread: Thread,
    number: Count,
    socket_name: Text = DEFAULT,
    timeout: Number = TIMEOUT,
) -> Value:
    """Return n bytes as [n, a, b, …], or [0, -1, …] on failure."""
    return await _read_numbers(thread, socket_name, number, "B", timeout)


async def socket_read_line(
    thread: Thread, socket_name: Text = DEFAULT, timeout: Number = TIMEOUT
) -> str:
    """Return a line without its end; return an empty string after the timeout."""
    return await _receive(thread, socket_name, _line, timeout) or ""


async def socket_read_string(
    thread: Thread,
    socket_name: Text = DEFAULT,
    prefix: Text = "",
    suffix: Text = "",
    interpret_escape: Bool = False,
    timeout: Number = TIMEOUT,
) -> str:
    """Return the received text between prefix and suffix; "" if there is none."""
    if interpret_escape:
        for written, meant in _ESCAPES:
            prefix = prefix.replace(written, meant)
            suffix = suffix.replace(written, meant)
    start, end = prefix.encode("latin-1"), suffix.encode("latin-1")

    def find(buffer: bytearray) -> str | None:
        if start:
            place = buffer.find(start)
            if place < 0:
                return None
            del buffer[:place]
        content = len(start)
        last = buffer.find(end, content) if end else len(buffer)
        if last < 0 or len(buffer) == 0 or (not end and last == content):
            return None
        text = bytes(buffer[content:last][:MAX_STRING])
        del buffer[: last + len(end)]
        return text.decode("latin-1")

    return await _receive(thread, socket_name, find, timeout) or ""


def _taken(buffer: bytearray, size: int) -> bytes:
    data = bytes(buffer[:size])
    del buffer[:size]
    return data


def _line(buffer: bytearray) -> str | None:
    end = buffer.find(b"\n")
    if end < 0:
        return None
    line = _taken(buffer, end + 1)
    return line.rstrip(b"\r\n")[:MAX_STRING].decode("latin-1")


def _in_brackets(buffer: bytearray) -> str | None:
    end = buffer.find(b")")
    if end < 0:
        return None
    data = _taken(buffer, end + 1)
    return data[data.rfind(b"(") + 1 : -1].decode("latin-1")


FUNCTIONS: Final[tuple[Function, ...]] = tuple(
    function(item)
    for item in (
        *(socket_close, socket_get_var, socket_open, socket_read_ascii_float),
        *(socket_read_binary_integer, socket_read_byte_list, socket_read_line),
        *(socket_read_string, socket_send_byte, socket_send_int, socket_send_line),
        *(socket_send_string, socket_set_var),
    )
)
