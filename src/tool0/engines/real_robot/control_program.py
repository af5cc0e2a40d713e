"""URScript program of tool0 that runs on the robot's controller.

The program follows a curve of knots, which tool0 sends in advance, and interpolates the
knots in the periods of the controller.  A knot consists of the period in which the knot
is due, the joint positions and the joint velocities.  Between two knots, the joints
follow cubic polynomials.  Numbers are sent as 32-bit integers, since every version of
PolyScope receives integers without changes.

* New knots may replace the remaining curve.  If new knots are received late, they
  differ from the current motion.  This difference is reduced to zero along a cubic with
  bounded acceleration.
* If no message is received for ``SILENCE``, or if ``BRAKE`` is received, the clock of
  the curve slows down to a stop, so that the arm stays on its path.  The arm then rests
  until a ``RESTART`` is received.
* When a connection is closed, the arm comes to rest, and the program ends.

According to the description of its parameters in the URScript manual, ``servoj``
follows a target q* with qdd = gain (q* - (q + lookahead qd)).  The program therefore
computes the target q + lookahead qd + qdd / gain from the curve, so that the joints do
not lag behind the curve.
"""

from __future__ import annotations

import math
import re
from enum import IntEnum
from pathlib import Path
from typing import Final

SCALE: Final = 1e7
"""Integer steps per rad or rad/s.  With this scale, 32 bits cover ±214 rad in steps of
1e-7 rad."""
COMMAND_SCALE: Final = 1e6
"""Integer steps per unit of the arguments of a command."""
N_KNOT: Final = 14
"""Number of integers in a message: the kind, a period, six positions and six
velocities."""
N_COMMAND: Final = 30
"""Number of integers in a command: the kind, the number of the command, and
arguments."""
N_ARGUMENTS: Final = N_COMMAND - 2
N_RING: Final = 64
"""Number of knots that the program stores."""
EMPTY: Final = 0.05
"""Time for which the program continues a motion after the last knot, if the motion does
not end at this knot [s]."""
SILENCE: Final = 0.1
"""Time without messages after which the arm decelerates to rest [s]."""
BRAKE_TIME: Final = 0.024
"""Time in which the clock of the curve stops [s].  The time is longer if a joint would
exceed ``BRAKE_DECELERATION``.  The servos of the joints need slightly more time."""
BRAKE_DECELERATION: Final = 40.0
"""Largest deceleration of a joint when the clock of the curve stops [rad/s²].  Streams
of UR's software use the same value."""
FADE_TIME: Final = 0.02
"""Shortest time in which a difference from the current motion is reduced to zero
[s]."""
FADE_ACCELERATION: Final = 12.0
"""Largest acceleration that the reduction of a difference adds to a joint [rad/s²]."""
FADE_SPEED: Final = 0.05
"""Largest speed that the reduction of a difference adds to a joint [rad/s].  With this
limit, the arm is only slightly faster than the speed slider allows."""
FAR: Final = 0.1
"""Time that distinguishes curves from streams [s].  Only the last knot of a curve can
be farther ahead than this time."""
MOST_JUMP: Final = (0.1, 1.5)
"""Largest difference between new knots and the current motion [rad, rad/s].  If the
difference is larger, the arm decelerates to rest instead of following the knots."""
GAIN: Final = 2000.0
"""``gain`` of servoj [1/s²]."""
LOOKAHEAD: Final = 2.0 / math.sqrt(GAIN)
"""``lookahead_time`` of servoj [s].  With this value, an error decays without
oscillation."""

LONGEST_VECTOR_PERIOD: Final = 0.004
"""Period of a controller [s] below which it is an e-Series controller, and above which
it is a CB3."""
FIRST_REGISTER: Final = 24
"""First of the integer output registers to which the program writes.  UR reserves the
registers with lower numbers for fieldbuses."""
REGISTERS: Final = tuple(f"output_int_register_{FIRST_REGISTER + k}" for k in range(3))
"""Registers for the number of periods since the start of the program (0 if the program
is not running), the ``ProgramMode``, and the ``StopCause`` if the arm came to rest."""


class MessageKind(IntEnum):
    """Kind of a message."""

    NOTHING = 0
    """Message without content, which shows that tool0 is running."""
    KNOT = 1
    """A knot that follows the previous knots."""
    REPLACE = 2
    """A knot that replaces all knots due in its period or later."""
    RESTART = 3
    """A knot that has the effect of ``REPLACE``, and is also accepted after the program
    brought the arm to rest."""
    BRAKE = 4
    """Request to bring the arm to rest on the curve.  The period in the message is the
    duration of the deceleration."""
    END = 5
    """Request to bring the arm to rest and to end the program."""


KINDS: Final = 8
"""Multiplier in the first integer of a message.  This integer is the kind of the
message plus the product of ``KINDS`` and the number of messages that follow."""


class ProgramMode(IntEnum):
    """State of the program."""

    STARTING = 0
    FOLLOWING = 1
    BRAKING = 2
    RESTING = 3
    """The arm has braked and rests until a ``RESTART`` is received."""
    GUIDED = 4
    """Freedrive is active."""


class StopCause(IntEnum):
    """Reason why the program brought the arm to rest."""

    TOLD = 1
    """The program received ``BRAKE``."""
    SILENT = 2
    """No message was received for ``SILENCE``."""
    RAN_OUT = 3
    """The knots ran out before the end of the motion."""
    TOO_FAR = 4
    """New knots differed by more than ``MOST_JUMP``."""


class CommandKind(IntEnum):
    """Kind of a command.  Each command calls a URScript function."""

    FORCE_MODE = 1
    END_FORCE_MODE = 2
    FREEDRIVE = 3
    END_FREEDRIVE = 4
    TOOL_OUTPUT = 5


_EACH: Final = re.compile(r"each\((.*?)\)(?=$|, t=)", re.MULTILINE)
"""Pattern of a list of six elements, up to the end of the line or the next argument of
servoj."""


def control_program(host: str, port: int, token: int, period: float) -> str:
    """Return the program, which connects to ``host`` at ``port``.

    Args:
        host: Host name or address at which the robot reaches tool0.
        port: Port at which tool0 listens.
        token: Secret number that tool0 expects first on each connection.
        period: Period of the controller [s].  The program for an e-Series computes with
            lists.  The program for a CB3, which has a longer period, computes with
            individual elements.
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
