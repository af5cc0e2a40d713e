"""Detection of the program that ur_rtde's RTDEControlInterface uploads.

The program is a server for commands that are received through RTDE registers. The
program is always the same, except for the offset of its registers and the path of
``moveJ(path)``, ``moveL(path)`` and ``movePath``, which the client inserts as lines of
URScript. The script itself is not interpreted; ``program.py`` executes the commands.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, final

from tool0.errors import ConfigError
from tool0.motion.moves import Move, MoveKind

MAX_WAYPOINTS: Final = 10_000
"""Maximum number of waypoints in a path."""

_MARKS: Final = (
    "global reg_offset_float =",
    "def rtde_cmd():",
    "def process_cmd(cmd):",
    "def signal_done_with_cmd():",
    'textmsg("RTDE Control Script Loaded',
)
"""Lines that all revisions of the program contain."""
_NAME: Final = re.compile(r"^\s*def\s+(\w+)\s*\(\s*\)\s*:")
_REVISION: Final = re.compile(r"RTDE Control Script Loaded \(([^)\"]*)\)")
_OFFSET: Final = re.compile(r"# (float|int) register offset\n\s*(\d+)")
_CODE: Final = re.compile(r"if cmd == (\d+):")
_PATH: Final = re.compile(r"# inject move path\n(.*?)^\s*end\b", re.DOTALL | re.M)
_NUMBER: Final = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
_KINDS: Final[dict[str, MoveKind]] = {"j": "joint", "l": "linear", "p": "process"}
_PROGRESS: Final = re.compile(r"signal_async_progress\(\d+\)")
_MOVE: Final = re.compile(
    r"move([jlp])\((p?)\["
    + ",".join([_NUMBER] * 6)
    + r"\],a="
    + _NUMBER
    + ",v="
    + _NUMBER
    + ",r="
    + _NUMBER
    + r"\)"
)


@final
@dataclass(frozen=True, slots=True)
class ControlScript:
    """The parts that differ between uploaded scripts."""

    name: str
    revision: str
    """Revision date that the program displays."""
    offset: int
    """Offset of the register numbers: 0, or 24 for the upper range."""
    codes: frozenset[int]
    """Numbers of the commands that the program supports."""
    path: tuple[Move, ...]
    """Path of command 45."""


def parse(text: str) -> ControlScript | None:
    """Recognize ur_rtde's control program in a script; return None for other programs.

    Raises:
        ConfigError: If the script is ur_rtde's program, but contains a path that
            ur_rtde cannot have written.
        ControlError: If no arm can follow the path.
    """
    name = _NAME.match(text)
    if name is None or not all(mark in text for mark in _MARKS):
        return None
    offsets = {kind: int(value) for kind, value in _OFFSET.findall(text)}
    offset = offsets.get("int", 0)
    if offsets.get("float", 0) != offset or offset not in {0, 24}:
        raise ConfigError(
            f"{name[1]}: registers begin at 0 or 24, and got {offsets}: one offset for "
            "integers and doubles"
        )
    revision = _REVISION.search(text)
    return ControlScript(
        name=name[1],
        revision=revision[1] if revision else "",
        offset=offset,
        codes=frozenset(map(int, _CODE.findall(text))),
        path=_path(text, name[1]),
    )


def _path(text: str, name: str) -> tuple[Move, ...]:
    inserted = _PATH.search(text)
    if inserted is None:
        return ()
    first = text.count("\n", 0, inserted.start(1)) + 1
    moves = []
    for number, line in enumerate(inserted[1].split("\n"), first):
        code = line.strip()
        if not code or _PROGRESS.fullmatch(code):
            continue
        found = _MOVE.fullmatch(code)
        if found is None:
            raise ConfigError(
                f"{name}, line {number}: '{code[:80]}' is not a move, such as "
                "movej([0,-1.57,1.57,0,0,0],a=1.4,v=1.05,r=0.02)"
            )
        letter, is_pose, *numbers = found.groups()
        a, b, c, d, e, f, acceleration, speed, radius = map(float, numbers)
        target = (a, b, c, d, e, f)
        moves.append(
            Move(
                kind=_KINDS[letter],
                q=None if is_pose else target,
                pose=target if is_pose else None,
                a=acceleration,
                v=speed,
                r=radius,
            )
        )
    if len(moves) > MAX_WAYPOINTS:
        raise ConfigError(f"{name}: {len(moves)} waypoints; at most {MAX_WAYPOINTS}")
    return tuple(moves)
