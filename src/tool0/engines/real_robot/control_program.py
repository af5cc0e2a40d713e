"""tool0's program on the robot's controller, in URScript.

It follows a curve of knots that tool0 sends ahead of time, and interpolates them in the
controller's own periods.  A knot consists of the period in which it is due, positions
and velocities; between two knots, the joints follow cubics.  Numbers are 32-bit
integers, since these arrive unchanged on every version of PolyScope.

* New knots may replace the rest of the curve.  If they arrive late, they differ from
  the present motion; this difference fades along a cubic with bounded acceleration.
* Without a message for ``SILENCE``, or at ``BRAKE``, the curve's clock slows down to a
  stop: the arm stays on its path.  It then rests until a ``RESTART``.
* When a connection ends, the arm comes to rest, and the program ends.

According to the URScript manual's description of its parameters, ``servoj`` follows its
target q* with qdd = gain (q* - (q + lookahead qd)).  The target is therefore the
curve's q + lookahead qd + qdd / gain, so that the joints are on the curve rather than
behind it.
"""

from __future__ import annotations

import math
import re
from enum import IntEnum
from pathlib import Path
from typing import Final

SCALE: Final = 1e7
"""Integer steps per rad or rad/s: 32 bits cover ±214 rad in steps of 1e-7 rad."""
COMMAND_SCALE: Final = 1e6
"""Integer steps per unit of a command's arguments."""
N_KNOT: Final = 14
"""Number of integers in a message: its kind, a period, six positions, six
velocities."""
N_COMMAND: Final = 30
"""Number of integers in a command: its kind, its number, arguments."""
N_ARGUMENTS: Final = N_COMMAND - 2
N_RING: Final = 64
"""Number of knots that the program keeps."""
EMPTY: Final = 0.05
"""Time for which the program continues a motion beyond its last knot if the motion does
not end there [s]."""
SILENCE: Final = 0.1
"""Time without messages after which the arm slows down to rest [s]."""
BRAKE_TIME: Final = 0.024
"""Time in which the curve's clock stops [s], unless a joint would decelerate more than
``BRAKE_DECELERATION``; the joints' servos need slightly longer."""
BRAKE_DECELERATION: Final = 40.0
"""Largest deceleration of a joint when the clock stops [rad/s²]: as large as in UR's
own streams."""
FADE_TIME: Final = 0.02
"""Shortest time in which a difference from the present motion fades [s]."""
FADE_ACCELERATION: Final = 12.0
"""Largest acceleration that a fading difference adds to a joint [rad/s²]."""
FADE_SPEED: Final = 0.05
"""Largest speed that a fading difference adds to a joint [rad/s], so that an arm that
catches up is hardly faster than the speed slider allows."""
FAR: Final = 0.1
"""Time that tells curves from streams [s]: only a curve's last knot is ever further
ahead than this."""
MOST_JUMP: Final = (0.1, 1.5)
"""Largest difference between new knots and the present motion [rad, rad/s]; if it is
larger, the arm slows down to rest instead of following the knots."""
GAIN: Final = 2000.0
"""``gain`` of servoj [1/s²]."""
LOOKAHEAD: Final = 2.0 / math.sqrt(GAIN)
"""``lookahead_time`` of servoj [s]: an error then decays without oscillation."""

LONGEST_VECTOR_PERIOD: Final = 0.004
"""Period that separates e-Series controllers (shorter) from CB3 controllers (longer)
[s]."""
FIRST_REGISTER: Final = 24
"""First of the integer output registers that the program writes; UR reserves the lower
ones for fieldbuses."""
REGISTERS: Final = tuple(f"output_int_register_{FIRST_REGISTER + k}" for k in range(3))
"""Registers for the periods since the program began (0 if it is not running), its
``ProgramMode``, and the ``StopCause`` if the arm came to rest."""


class MessageKind(IntEnum):
    """The meaning of a message."""

    NOTHING = 0
    """No content; shows that tool0 is alive."""
    KNOT = 1
    """A knot that follows the previous ones."""
    REPLACE = 2
    """A knot that replaces all knots due in its period or later."""
    RESTART = 3
    """A knot that acts like ``REPLACE``, but also after the arm came to rest on its
    own."""
    BRAKE = 4
    """Come to rest on the curve; the message's period is the duration of the
    deceleration."""
    END = 5
    """Come to rest and end the program."""


KINDS: Final = 8
"""Multiplier in a message's first integer, which is its kind plus this times the number
of messages that follow it."""


class ProgramMode(IntEnum):
    """State of the program."""

    STARTING = 0
    FOLLOWING = 1
    BRAKING = 2
    RESTING = 3
    """The arm has braked and rests until a ``RESTART``."""
    GUIDED = 4
    """Freedrive is active."""


class StopCause(IntEnum):
    """Why the program brought the arm to rest."""

    TOLD = 1
    """The program received ``BRAKE``."""
    SILENT = 2
    """No message for ``SILENCE``."""
    RAN_OUT = 3
    """The knots ran out before the end of the motion."""
    TOO_FAR = 4
    """New knots differed by more than ``MOST_JUMP``."""


class CommandKind(IntEnum):
    """Kind of a command, which calls a URScript function."""

    FORCE_MODE = 1
    END_FORCE_MODE = 2
    FREEDRIVE = 3
    END_FREEDRIVE = 4
    TOOL_OUTPUT = 5


_EACH: Final = re.compile(r"each\((.*?)\)(?=$|, t=)", re.MULTILINE)
"""A list of six elements, up to the end of the line or servoj's next argument."""


def control_program(host: str, port: int, token: int, period: float) -> str:
    """Return the program, which connects to ``host`` at ``port``.

    Args:
        host: Host name or address of tool0, as the robot reaches it.
        port: Port at which tool0 listens.
        token: Number that tool0 expects first on each connection.
        period: Period of the controller [s]; programs for an e-Series compute with
            lists, and programs for a CB3, whose period is longer, with single elements.
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
    """Return the URScript for six arguments of a command."""
    return _list([f"x[{first + k}]" for k in range(6)])


def _list(items: list[str]) -> str:
    return f"[{', '.join(items)}]"
