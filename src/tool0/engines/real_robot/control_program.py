"""tool0's program on the robot's controller, in URScript.

It follows a curve of knots that tool0 sends ahead of time, and interpolates them in the
controller's own periods.  A knot is the period in which it is due, positions and
velocities; between two knots, joints follow cubics.  Numbers are integers of 32 bits,
since these arrive unchanged on every version of PolyScope.

* New knots may replace the rest of the curve.  What differs from the present motion,
  because they came after their time, fades with a cubic within a bounded acceleration.
* Without a message for ``SILENCE``, or at ``BRAKE``, the curve's clock slows down to a
  stop: the arm stays on its path.  It then rests until a ``RESTART``.
* At the end of a connection it comes to rest, and the program ends.

``servoj`` follows its target q* by qdd = gain (q* - (q + lookahead qd)), as URScript's
manual describes its two parameters; the target is therefore q + lookahead qd + qdd /
gain of the curve, so that the joints are on it and not behind it.
"""

from __future__ import annotations

import math
import re
from enum import IntEnum
from pathlib import Path
from typing import Final

SCALE: Final = 1e7
"""Integer steps per radian, and per rad/s: 32 bits are ±214 rad in steps of 1e-7
rad."""
COMMAND_SCALE: Final = 1e6
"""Integer steps per unit of the arguments of commands."""
N_KNOT: Final = 14
"""Integers of a message: its kind, a period, six positions, six velocities."""
N_COMMAND: Final = 30
"""Integers of a command: its kind, its number, arguments."""
N_ARGUMENTS: Final = N_COMMAND - 2
N_RING: Final = 64
"""Knots that the program keeps."""
EMPTY: Final = 0.05
"""Time after its last knot for which the program follows a motion that does not end
with it [s]."""
SILENCE: Final = 0.1
"""Time without a message after which the arm slows down to rest [s]."""
BRAKE_TIME: Final = 0.024
"""Time in which the curve's clock stops [s], unless a joint would decelerate more than
``BRAKE_DECELERATION``; the joints' servos need some time more."""
BRAKE_DECELERATION: Final = 40.0
"""Largest deceleration of a joint when the clock stops [rad/s²]: as fast as UR's own
streams change."""
FADE_TIME: Final = 0.02
"""Shortest time in which a difference fades [s]."""
FADE_ACCELERATION: Final = 12.0
"""Largest acceleration that a fading difference adds to a joint [rad/s²]."""
FADE_SPEED: Final = 0.05
"""Largest speed that a fading difference adds to a joint [rad/s]: the arm that catches
up is hardly faster than the speed slider says."""
FAR: Final = 0.1
"""A curve goes on for longer than that, but for its end [s]; a stream does not."""
MOST_JUMP: Final = (0.1, 1.5)
"""Largest difference of new knots from the present motion [rad, rad/s]; beyond it, the
arm slows down to rest instead of following them."""
GAIN: Final = 2000.0
"""``gain`` of servoj [1/s²]."""
LOOKAHEAD: Final = 2.0 / math.sqrt(GAIN)
"""``lookahead_time`` of servoj [s]: an error then decays without oscillation."""

LONGEST_VECTOR_PERIOD: Final = 0.004
"""Control period between those of an e-Series and of a CB3 [s]."""
FIRST_REGISTER: Final = 24
"""Output registers that the program writes: integers from this one on.  UR keeps those
below for fieldbuses."""
REGISTERS: Final = tuple(f"output_int_register_{FIRST_REGISTER + k}" for k in range(3))
"""Periods since the program began, 0 without it; its ``ProgramMode``; and the
``StopCause``, if it came to rest."""


class MessageKind(IntEnum):
    """The meaning of a message."""

    NOTHING = 0
    """tool0 is there."""
    KNOT = 1
    """A knot after the others."""
    REPLACE = 2
    """A knot that replaces those that are due from its period on."""
    RESTART = 3
    """A knot that replaces others as ``REPLACE``, also after the arm came to rest
    itself."""
    BRAKE = 4
    """Come to rest on the curve; the period is that of the deceleration."""
    END = 5
    """Come to rest, and end the program."""


KINDS: Final = 8
"""The first integer of a message is its kind, and this times the number of messages
that belong to it."""


class ProgramMode(IntEnum):
    """State of the program."""

    STARTING = 0
    FOLLOWING = 1
    BRAKING = 2
    RESTING = 3
    """The arm has braked; it rests until a ``RESTART``."""
    GUIDED = 4
    """Freedrive."""


class StopCause(IntEnum):
    """Why the program brought the arm to rest."""

    TOLD = 1
    """The program received ``BRAKE``."""
    SILENT = 2
    """No message for ``SILENCE``."""
    RAN_OUT = 3
    """The last knot was not the end of the motion."""
    TOO_FAR = 4
    """New knots were beyond ``MOST_JUMP``."""


class CommandKind(IntEnum):
    """Kind of a command: a function of URScript."""

    FORCE_MODE = 1
    END_FORCE_MODE = 2
    FREEDRIVE = 3
    END_FREEDRIVE = 4
    TOOL_OUTPUT = 5


_EACH: Final = re.compile(r"each\((.*?)\)(?=$|, t=)", re.MULTILINE)
"""A list of six, to the end of a line or the next argument of servoj."""


def control_program(host: str, port: int, token: int, period: float) -> str:
    """Return the program, which connects to ``host`` at ``port``.

    Args:
        host: Host name or address of tool0, as the robot reaches it.
        port: Port at which tool0 listens.
        token: Number that tool0 expects first on each connection.
        period: Period of the controller [s]: an e-Series computes with lists, a CB3,
            whose period is longer, with their elements.
    """
    names = {
        "HOST": host,
        "PORT": port,
        "TOKEN": token,
        "PERIOD": period,
        "SILENCE": round(SILENCE / period),
        "EMPTY": EMPTY / period,
        "BRAKE_STEPS": BRAKE_TIME / period,
        "BRAKE_RATE": BRAKE_DECELERATION * period,
        "FADE_STEPS": FADE_TIME / period,
        "FADE": FADE_ACCELERATION,
        "FADE_SPEED": FADE_SPEED,
        "FAR": FAR / period,
        "JUMP": MOST_JUMP[0],
        "SPEED_JUMP": MOST_JUMP[1],
        "LOOKAHEAD": LOOKAHEAD,
        "GAIN": GAIN,
        "SOFTNESS": 1.0 / GAIN,
        "N_KNOT": N_KNOT,
        "KINDS": KINDS,
        "N_COMMAND": N_COMMAND,
        "N_RING": N_RING,
        "SCALE": SCALE,
        "RING": _list(["0.0"] * N_RING),
        "ARGUMENTS": _list(
            ["0.0", *(f"m[{k + 3}] / {COMMAND_SCALE}" for k in range(N_ARGUMENTS))]
        ),
        "FRAME": f"p{_six(1)}",
        "SELECTION": _six(7),
        "WRENCH": _six(13),
        "LIMITS": _six(20),
        "AXES": _six(1),
        "GUIDE": f"p{_six(7)}",
        **{f"REGISTER_{k}": FIRST_REGISTER + k for k in range(len(REGISTERS))},
        **{
            item.name: int(item)
            for kinds in (MessageKind, ProgramMode, StopCause, CommandKind)
            for item in kinds
        },
    }
    text = Path(__file__).with_name("control.script").read_text(encoding="utf-8")
    text = re.sub(r"\$(\w+)", lambda match: str(names[match[1]]), text)
    has_vectors = period < LONGEST_VECTOR_PERIOD
    return _EACH.sub(lambda match: _each(match[1], has_vectors=has_vectors), text)


def _each(expression: str, *, has_vectors: bool) -> str:
    if has_vectors:
        return expression.replace("[#]", "")
    return _list([expression.replace("#", str(k)) for k in range(6)])


def _six(first: int) -> str:
    """Return six arguments of a command."""
    return _list([f"x[{first + k}]" for k in range(6)])


def _list(items: list[str]) -> str:
    return f"[{', '.join(items)}]"
