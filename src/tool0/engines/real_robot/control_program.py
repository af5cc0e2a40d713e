"""tool0's program on the robot's controller, in URScript.

It follows a curve of knots that tool0 sends ahead of time, and interpolates them in the
controller's own periods, so that a late packet does not shake the arm.  A knot is the
period in which it is due, positions and velocities; between two knots, joints follow
cubics.  Numbers are integers of 32 bits, since these arrive unchanged on every version
of PolyScope.

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

from enum import IntEnum
from typing import Final

SCALE: Final = 1e7
"""Per radian, and per rad/s: 32 bits are ±214 rad in steps of 1e-7 rad."""
COMMAND_SCALE: Final = 1e6
"""Per unit of the arguments of commands."""
N_KNOT: Final = 14
"""Integers of a message: its kind, a period, six positions, six velocities."""
N_COMMAND: Final = 30
"""Integers of a command: its kind, its number, arguments."""
N_ARGUMENTS: Final = N_COMMAND - 2
N_RING: Final = 64
"""Knots that the program keeps."""
SILENCE: Final = 0.1
"""Without a message for that long, the arm slows down to rest [s]."""
BRAKE_TIME: Final = 0.036
"""In which the curve's clock stops [s], unless a joint would decelerate more than
``BRAKE_DECELERATION``: after ``SILENCE``, the arm rests within 150 ms."""
BRAKE_DECELERATION: Final = 40.0
"""Of a joint, when the clock stops [rad/s²]: as fast as UR's own streams change."""
FADE_TIME: Final = 0.02
"""Shortest time in which a difference fades [s]."""
FADE_ACCELERATION: Final = 12.0
"""Which a fading difference adds to a joint [rad/s²]."""
MOST_JUMP: Final = (0.1, 1.5)
"""Largest difference of new knots from the present motion [rad, rad/s]; beyond it, the
arm slows down to rest instead of following them."""
LOOKAHEAD: Final = 0.03
"""``lookahead_time`` of servoj [s]."""
GAIN: Final = 2000.0
"""``gain`` of servoj [1/s²]."""

FIRST_REGISTER: Final = 24
"""Output registers that the program writes: integers from this one on.  UR keeps those
below for fieldbuses."""
REGISTERS: Final = tuple(f"output_int_register_{FIRST_REGISTER + k}" for k in range(4))
"""Periods since the program began; its ``ProgramMode``; the number of the last
``RESTART`` or replacement; the number of the last command that was executed."""


class MessageKind(IntEnum):
    """The meaning of a message."""

    NOTHING = 0
    """tool0 is there."""
    KNOT = 1
    """A knot after the others."""
    REPLACE = 2
    """A knot that replaces those that are due from its period on."""
    RESTART = 3
    """As ``REPLACE``, also after the arm has come to rest by itself."""
    BRAKE = 4
    """Come to rest on the curve; the period is that of the deceleration."""
    END = 5
    """Come to rest, and end the program."""


class ProgramMode(IntEnum):
    """What the program does."""

    STARTING = 0
    FOLLOWING = 1
    BRAKING = 2
    RESTING = 3
    """After braking, until a ``RESTART``."""
    GUIDED = 4
    """Freedrive."""


class CommandKind(IntEnum):
    """What a command does: functions of URScript."""

    FORCE_MODE = 1
    END_FORCE_MODE = 2
    FREEDRIVE = 3
    END_FREEDRIVE = 4
    TOOL_OUTPUT = 5


def control_program(host: str, port: int, token: int, period: float) -> str:
    """Return the program, which connects to ``host`` at ``port``.

    Args:
        host: Of tool0, as the robot reaches it.
        port: Where tool0 listens.
        token: Which tool0 expects first on each connection.
        period: Of the controller [s].
    """
    names = {
        "HOST": host,
        "PORT": str(port),
        "TOKEN": str(token),
        "PERIOD": repr(period),
        "SILENCE": str(round(SILENCE / period)),
        "BRAKE_STEPS": repr(BRAKE_TIME / period),
        "BRAKE_RATE": repr(BRAKE_DECELERATION * period),
        "FADE_STEPS": repr(FADE_TIME / period),
        "FADE": repr(FADE_ACCELERATION),
        "JUMP": repr(MOST_JUMP[0]),
        "SPEED_JUMP": repr(MOST_JUMP[1]),
        "LOOKAHEAD": repr(LOOKAHEAD),
        "GAIN": repr(GAIN),
        "N_KNOT": str(N_KNOT),
        "N_COMMAND": str(N_COMMAND),
        "N_RING": str(N_RING),
        "SCALE": repr(SCALE),
        "COMMAND_SCALE": repr(COMMAND_SCALE),
        "RING": "[" + ", ".join(["0.0"] * N_RING) + "]",
        "FRAME": _pose(1),
        "SELECTION": _numbers(7),
        "WRENCH": _numbers(13),
        "LIMITS": _numbers(20),
        "AXES": _numbers(1),
        "GUIDE": _pose(7),
        "ZEROS": "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
        **{f"REGISTER_{k}": str(FIRST_REGISTER + k) for k in range(len(REGISTERS))},
    }
    text = _PROGRAM
    for name in sorted(names, key=len, reverse=True):
        text = text.replace(f"${name}", names[name])
    return text


def _each(expression: str) -> str:
    """Return a list of six: ``expression`` with ``@`` as each index."""
    return "[" + ", ".join(expression.replace("@", str(k)) for k in range(6)) + "]"


def _pose(first: int) -> str:
    """Return the arguments of a command from ``first`` on as a pose."""
    return "p[" + ", ".join(f"x[{first + k}]" for k in range(6)) + "]"


def _numbers(first: int) -> str:
    """Return them as six whole or other numbers."""
    return "[" + ", ".join(f"x[{first + k}]" for k in range(6)) + "]"


def _largest(name: str) -> str:
    """Return the largest magnitude of a list's elements."""
    found = f"norm({name}[0])"
    for k in range(1, 6):
        found = f"largest({found}, norm({name}[{k}]))"
    return found


_STORE: Final = "\n".join(
    f"      ring_{kind}{k}[place] = m[{1 + first + k}] / $SCALE"
    for kind, first in (("q", 2), ("v", 8))
    for k in range(6)
)
_RINGS: Final = "\n".join(
    f"  global ring_{kind}{k} = $RING" for kind in "qv" for k in range(6)
)

_PROGRAM: Final = (
    """def tool0_control():
  global ring_t = $RING
"""
    + _RINGS
    + """
  global first = 0
  global count = 0
  global steps = 0
  global heard = 0
  global mode = 0
  global replaced = 0
  global has_new = False
  global brake_time = 0.0
  global is_over = False
  global is_guided = False
  global command_number = 0

  def largest(a, b):
    if a > b:
      return a
    end
    return b
  end

  def knot(place, kind):
    if kind == 0:
      return """
    + _each("ring_q@[place]")
    + """
    end
    return """
    + _each("ring_v@[place]")
    + """
  end

  def keep_knot(m):
    local kind = m[1]
    if kind != 1:
      while count > 0 and ring_t[(first + count - 1) % $N_RING] >= m[2]:
        count = count - 1
      end
      if kind == 3:
        count = 0
        mode = 1
      end
      replaced = replaced + 1
      has_new = True
    end
    if count < $N_RING:
      local place = (first + count) % $N_RING
      ring_t[place] = m[2]
"""
    + _STORE
    + """
      count = count + 1
    end
  end

  thread receive():
    while not is_over:
      local m = socket_read_binary_integer($N_KNOT, "tool0_knots", 0)
      if m[0] != $N_KNOT:
        is_over = True
      elif m[1] == 5:
        is_over = True
      else:
        heard = steps
        if m[1] == 4:
          brake_time = m[2]
          if mode == 1:
            mode = 2
          end
        elif m[1] == 3 or (m[1] > 0 and mode == 1):
          keep_knot(m)
        end
      end
    end
  end

  def execute(m):
    local kind = m[1]
    local x = [0.0, """
    + ", ".join(f"m[{k + 3}] / $COMMAND_SCALE" for k in range(N_ARGUMENTS))
    + """]
    if kind == 1:
      force_mode($FRAME, $SELECTION, $WRENCH, floor(x[19] + 0.5), $LIMITS)
    elif kind == 2:
      end_force_mode()
    elif kind == 3:
      is_guided = True
      sync()
      freedrive_mode($AXES, $GUIDE)
    elif kind == 4:
      end_freedrive_mode()
      is_guided = False
    elif kind == 5:
      set_tool_digital_out(floor(x[1] + 0.5), x[2] > 0.5)
    end
    command_number = m[2]
  end

  thread receive_commands():
    while not is_over:
      local m = socket_read_binary_integer($N_COMMAND, "tool0_commands", 0)
      if m[0] != $N_COMMAND:
        is_over = True
      else:
        execute(m)
      end
    end
  end

  if not socket_open("$HOST", $PORT, "tool0_knots"):
    textmsg("tool0 does not listen at $HOST, port $PORT")
    halt
  end
  if not socket_open("$HOST", $PORT, "tool0_commands"):
    textmsg("tool0 does not listen at $HOST, port $PORT")
    halt
  end
  socket_send_int($TOKEN, "tool0_knots")
  socket_send_int(1, "tool0_knots")
  socket_send_int($TOKEN, "tool0_commands")
  socket_send_int(2, "tool0_commands")

  local q = get_actual_joint_positions()
  local v = $ZEROS
  local a = $ZEROS
  local clock = 0.0
  local rate = 1.0
  local slowing = 0.0
  local segment = -1.0
  local t0 = 0.0
  local c0 = q
  local c1 = $ZEROS
  local c2 = $ZEROS
  local c3 = $ZEROS
  local f0 = $ZEROS
  local f1 = $ZEROS
  local f2 = $ZEROS
  local f3 = $ZEROS
  local fade_start = 0.0
  local fade_end = 0.0
  local last_end = 0.0
  local s = 0.0
  local d = 0.0
  run receive()
  run receive_commands()

  while mode != 3 or not is_over:
    steps = steps + 1
    if mode == 0 and is_over:
      mode = 3
    end
    if mode == 1 and (is_over or steps - heard > $SILENCE):
      mode = 2
    end
    if mode == 2 and slowing == 0.0:
      slowing = 1.0 / largest($BRAKE_STEPS, largest(brake_time, """
    + _largest("v")
    + """ / $BRAKE_RATE))
    end
    if mode == 2:
      rate = rate - slowing
      if rate <= 0.0:
        rate = 0.0
        mode = 3
        count = 0
        c0 = q
        c1 = $ZEROS
        c2 = $ZEROS
        c3 = $ZEROS
        v = $ZEROS
        fade_end = 0.0
      end
    end
    if mode == 1:
      if has_new and rate < 1.0:
        clock = steps - 1
        rate = 1.0
        slowing = 0.0
        brake_time = 0.0
      end
    end
    clock = clock + rate
    enter_critical
    while count > 1 and ring_t[(first + 1) % $N_RING] <= clock:
      first = (first + 1) % $N_RING
      count = count - 1
      segment = -1.0
    end
    if count > 0 and mode < 3 and (segment < 0.0 or has_new):
      t0 = ring_t[first]
      c0 = knot(first, 0)
      c1 = knot(first, 1)
      c2 = $ZEROS
      c3 = $ZEROS
      last_end = t0
      if count > 1:
        local b = (first + 1) % $N_RING
        local q1 = knot(b, 0)
        local v1 = knot(b, 1)
        last_end = ring_t[b]
        d = (last_end - t0) * $PERIOD
        c2 = """
    + _each("(3.0 * (q1[@] - c0[@]) / d - 2.0 * c1[@] - v1[@]) / d")
    + """
        c3 = """
    + _each("(2.0 * (c0[@] - q1[@]) / d + c1[@] + v1[@]) / d / d")
    + """
        segment = 1.0
      end
    end
    local is_new = has_new
    has_new = False
    exit_critical
    s = (clock - t0) * $PERIOD
    local w = """
    + _each("c1[@] + s * (2.0 * c2[@] + 3.0 * s * c3[@])")
    + """
    local x = """
    + _each("c0[@] + s * (c1[@] + s * (c2[@] + s * c3[@]))")
    + """
    a = """
    + _each("2.0 * c2[@] + 6.0 * s * c3[@]")
    + """
    if is_new and mode == 1:
      f0 = """
    + _each("q[@] + v[@] * $PERIOD - x[@]")
    + """
      f1 = """
    + _each("v[@] - w[@]")
    + """
      local way = """
    + _largest("f0")
    + """
      local hurry = """
    + _largest("f1")
    + """
      if way > $JUMP or hurry > $SPEED_JUMP:
        textmsg("tool0: the new knots are too far from the motion: ", [way, hurry])
        c0 = q
        c1 = $ZEROS
        c2 = $ZEROS
        c3 = $ZEROS
        x = q
        w = $ZEROS
        mode = 3
        rate = 0.0
        count = 0
        fade_end = 0.0
      else:
        fade_start = clock
        d = 4.0 * hurry / $FADE + sqrt(6.0 * way / $FADE)
        fade_end = clock + largest($FADE_STEPS, d / $PERIOD)
        d = (fade_end - fade_start) * $PERIOD
        f2 = """
    + _each("(0.0 - 3.0 * f0[@] / d - 2.0 * f1[@]) / d")
    + """
        f3 = """
    + _each("(2.0 * f0[@] / d + f1[@]) / d / d")
    + """
      end
    end
    if clock < fade_end:
      s = (clock - fade_start) * $PERIOD
      x = """
    + _each("x[@] + f0[@] + s * (f1[@] + s * (f2[@] + s * f3[@]))")
    + """
      w = """
    + _each("w[@] + f1[@] + s * (2.0 * f2[@] + 3.0 * s * f3[@])")
    + """
      a = """
    + _each("a[@] + 2.0 * f2[@] + 6.0 * s * f3[@]")
    + """
    end
    q = x
    v = """
    + _each("w[@] * rate")
    + """
    if mode == 1 and count < 2 and """
    + _largest("c1")
    + """ > 0.0 and clock > last_end + 60.0:
      mode = 2
    end
    write_output_integer_register($REGISTER_0, steps)
    write_output_integer_register($REGISTER_2, replaced)
    write_output_integer_register($REGISTER_3, command_number)
    if is_guided:
      write_output_integer_register($REGISTER_1, 4)
      q = get_actual_joint_positions()
      v = $ZEROS
      c0 = q
      c1 = $ZEROS
      c2 = $ZEROS
      c3 = $ZEROS
      count = 0
      fade_end = 0.0
      mode = 3
      rate = 0.0
      sync()
    else:
      write_output_integer_register($REGISTER_1, mode)
      servoj("""
    + _each("q[@] + $LOOKAHEAD * v[@] + a[@] * rate * rate / $GAIN")
    + """, t=$PERIOD, lookahead_time=$LOOKAHEAD, gain=$GAIN)
    end
  end
  write_output_integer_register($REGISTER_1, 0)
  stopj(4.0)
end
"""
)
