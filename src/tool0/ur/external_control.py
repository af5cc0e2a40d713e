"""The URCap External Control, which requests its program from UR's driver.

When External Control is played, it sends ``request_program`` to a port of the driver.
The driver responds with the body of its program and leaves the connection open. The
program is complete when no more data is received. Source:
https://github.com/UniversalRobots/Universal_Robots_ExternalControl_URCap
"""

from __future__ import annotations

import asyncio
from pathlib import PurePosixPath
from typing import Final

from tool0.errors import ControlError
from tool0.ur.client_interface.scripts import MAX_PROGRAM
from tool0.ur.waiting import within

NAME: Final = "external_control"
"""Name of the PolyScope program that contains only the URCap's node."""
PORT: Final = 50002
"""Default port on which a driver offers its program."""
REQUEST: Final = b"request_program\n"
TIMEOUT: Final = 2.0
"""Maximum time to wait for the driver [wall s]."""
SILENCE: Final = 0.2
"""Time without data after which the program is considered complete [wall s]."""


def is_external(name: str) -> bool:
    """Return whether a program name refers to the URCap's program."""
    return PurePosixPath(name).name in {NAME, f"{NAME}.urp"}


async def request_program(host: str) -> str:
    """Return the program that the driver on a host currently offers.

    Raises:
        ControlError: If the driver does not answer with a program.
    """
    about = f"External Control: {host}:{PORT}"
    try:
        made = await within(asyncio.open_connection(host, PORT), TIMEOUT)
    except OSError as error:
        raise ControlError(f"{about}: {error.strerror or error}") from None
    if made is None:
        raise ControlError(f"{about}: no connection within {TIMEOUT:g} s")
    reader, writer = made
    body = b""
    try:
        writer.write(REQUEST)
        while len(body) <= MAX_PROGRAM:
            data = await within(reader.read(1 << 16), SILENCE if body else TIMEOUT)
            if not data:
                break
            body += data
    except OSError as error:
        raise ControlError(f"{about}: {error.strerror or error}") from None
    finally:
        writer.close()
    if not body:
        raise ControlError(f"{about}: no program within {TIMEOUT:g} s")
    if len(body) > MAX_PROGRAM:
        raise ControlError(f"{about}: the program has more than {MAX_PROGRAM} bytes")
    return f"def {NAME}():\n{body.decode(errors='replace')}\nend\n"
