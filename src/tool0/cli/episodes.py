"""``tool0 record --episodes``: demonstrations that are controlled by keys."""

from __future__ import annotations

import contextlib
import os
import select
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.cli.connection import Bringup
from tool0.cli.stop_signal import StopSignal
from tool0.cli.text import counted
from tool0.errors import ControlError, Tool0Error

if TYPE_CHECKING:
    from tool0.api.robot import Robot
    from tool0.protocol.episodes import EpisodeEnd, EpisodesStatus

HELP: Final = """\
  Space  start an episode          y  success    n  failure    x  discard
  w s    tool forward, back        a d  left, right    r f  up, down
  o c    gripper open, close       q  quit"""
_JOG_SPEED: Final = 0.1
"""Speed of the tool while a key is held [m/s]."""
_JOG_DURATION: Final = 0.25
"""Duration of the motion for one key press [s]; it exceeds the repeat interval of a
held key."""
_TWISTS: Final = {
    "w": (1.0, 0.0, 0.0),
    "s": (-1.0, 0.0, 0.0),
    "a": (0.0, 1.0, 0.0),
    "d": (0.0, -1.0, 0.0),
    "r": (0.0, 0.0, 1.0),
    "f": (0.0, 0.0, -1.0),
}
"""Key → direction of the tool in the base frame."""
_OUTCOMES: Final[Mapping[str, EpisodeEnd]] = {
    "y": "success",
    "n": "failure",
    "x": "discard",
}
_PERIOD: Final = 0.25
"""Wall time between checks of the episode [s]."""


def record_episodes(folder: Path, task: str, *, reset: bool, bringup: Bringup) -> int:
    """Record episodes of a running bring-up into a folder, until ``q`` or Ctrl-C."""
    from tool0.protocol.episodes import CloseEpisodes, OpenEpisodes

    with bringup.connect() as robot, StopSignal() as stop, _keys() as keys:
        path = str(folder.expanduser().absolute())
        robot.channel.call(OpenEpisodes(folder=path, task=task, reset=reset))
        try:
            print(HELP, flush=True)
            session = _Session(robot)
            for key in _pressed(keys, stop):
                if key == "q":
                    break
                session.take(key)
            session.show()
        finally:
            robot.channel.call(CloseEpisodes())
    print()
    return 0


@final
class _Session:
    """Executes the commands of keys, and shows a status line."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._has_taken = False
        self._shown = ""
        self.show()

    def take(self, key: str) -> None:
        """Execute the command of a key; an empty key only updates the status."""
        from tool0.protocol.episodes import EndEpisode, StartEpisode

        channel, problem = self._robot.channel, ""
        try:
            if key == " ":
                channel.call(StartEpisode())
            elif key in _OUTCOMES:
                channel.call(EndEpisode(outcome=_OUTCOMES[key]))
            elif key in _TWISTS:
                self._jog(_TWISTS[key])
            elif key in ("o", "c"):
                gripper = self._robot.gripper
                most = gripper.geometry.max_opening
                gripper.move(opening=most if key == "o" else 0.0)
        except Tool0Error as error:  # the session continues
            problem = str(error)
        self.show(problem)

    def show(self, problem: str = "") -> None:
        """Show the problem, or the status if there is no problem."""
        from tool0.protocol.episodes import ReadEpisodes

        text = problem or _described(self._robot.channel.call(ReadEpisodes()))
        if text == self._shown:
            return
        self._shown = text
        if sys.stdout.isatty():
            print(f"\r\x1b[K{text}", end="\n" if problem else "", flush=True)
        else:
            print(text, flush=True)

    def _jog(self, direction: tuple[float, float, float]) -> None:
        motion = self._robot.arm.motion
        if not self._has_taken:
            motion.take("tool0 record")
            self._has_taken = True
        x, y, z = (_JOG_SPEED * part for part in direction)
        try:
            motion.speed_tool((x, y, z, 0.0, 0.0, 0.0), duration=_JOG_DURATION)
        except ControlError:  # the arm is no longer taken
            self._has_taken = False
            raise


def _described(status: EpisodesStatus | None) -> str:
    if status is None:
        return "no folder"
    text = f"{counted(status.episodes, 'episode')}, {status.succeeded} succeeded"
    if status.is_recording:
        seconds = int(status.duration)
        text += f"; recording episode {status.episodes}: {seconds} s"
    return text if status.error is None else f"{text}; {status.error}"


@contextlib.contextmanager
def _keys() -> Iterator[int]:
    """Yield the descriptor of the standard input; make a terminal send single keys."""
    number = sys.stdin.fileno()
    if not os.isatty(number):
        yield number
        return
    import termios
    import tty

    before = termios.tcgetattr(number)
    try:
        tty.setcbreak(number)
        yield number
    finally:
        termios.tcsetattr(number, termios.TCSADRAIN, before)


def _pressed(number: int, stop: StopSignal) -> Iterator[str]:
    """Yield keys, and empty strings at intervals, until the input or process ends."""
    while not stop.is_set:
        inputs: list[int | StopSignal] = [number, stop]
        ready, _, _ = select.select(inputs, [], [], _PERIOD)
        if number not in ready:
            yield ""
            continue
        data = os.read(number, 64)
        if not data:
            return
        yield from data.decode(errors="ignore")
