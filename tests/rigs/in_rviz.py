"""RViz on a screen of our own, and how its picture is looked at."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from signal import Signals
from string import Template

import numpy as np
from numpy.typing import NDArray
from ros import Ros
from screen import Pixels, Screen

from tool0.installation.child_process import ChildProcess

Mask = NDArray[np.bool_]

_STARTS = 3
_CRASHES = (Signals.SIGABRT, Signals.SIGSEGV)
BACKGROUND = (215, 220, 226)
"""Red, green, blue of what is behind everything."""
_CONFIGURATION = Template("""\
Panels: $panels
Visualization Manager:
  Class: ""
  Displays:
    - {Class: rviz/Grid, Name: Grid, Enabled: true, Color: 150; 155; 160}
    - {Class: rviz/RobotModel, Name: RobotModel, Enabled: true,
       Robot Description: robot_description}
    - {Class: rviz/TF, Name: TF, Enabled: $tf, Show Names: false, Marker Scale: 0.3}
  Global Options:
    {Background Color: $background, Fixed Frame: world, Frame Rate: 30}
  Tools:
    - {Class: rviz/MoveCamera}
  Views:
    Current:
      Class: rviz/Orbit
      Distance: $distance
      Focal Point: {X: 0.1, Y: 0.1, Z: 0.3}
      Pitch: 0.3
      Yaw: 0.9
      Target Frame: <Fixed Frame>
Window Geometry: {Width: $width, Height: $height, X: 0, Y: 0,
  Hide Left Dock: $bare, Hide Right Dock: true}
""")


def start_rviz(
    ros: Ros,
    screen: Screen,
    home: Path,
    *,
    size: tuple[int, int],
    has_panel: bool = False,
    distance: float = 1.8,
) -> ChildProcess:
    """Start RViz on the screen, as large as that; it keeps its settings in ``home``."""
    file = home / "tool0.rviz"
    width, height = size
    text = _CONFIGURATION.substitute(
        width=width,
        height=height,
        distance=distance,
        tf=str(has_panel).lower(),
        panels="[{Class: rviz/Displays, Name: Displays}]" if has_panel else "[]",
        bare=str(not has_panel).lower(),
        background="; ".join(map(str, BACKGROUND)),
    )
    file.write_text(text, encoding="utf-8")
    return ros.spawn(
        *("rviz", "--display-config", str(file), "--splash-screen", ""),
        **variables(screen, home),
    )


def shown(
    start: Callable[[], ChildProcess],
    screen: Screen,
    shows: Callable[[Pixels], bool],
    patience: float,
) -> tuple[ChildProcess, Pixels]:
    """Start RViz, and return it with the first picture that ``shows`` is true of.

    If RViz crashes before, it is started again.  OGRE 1.12 makes a window on one
    connection to the X server, and at once draws in it on another.  Where the server
    takes the second first, Mesa 22.3 asks for the size of no window, takes what is in
    memory for the answer, and writes beyond its pictures: on a busy machine, that ends
    1 to 3 of 100 starts.
    """
    for _ in range(_STARTS):
        program = start()

        def is_over(pixels: Pixels, program: ChildProcess = program) -> bool:
            return shows(pixels) or program.exit_status is not None

        pixels = screen.wait_for(is_over, patience)
        if pixels is not None and shows(pixels):
            return program, pixels
        if not _has_crashed(program):
            break
        program.close()
    raise AssertionError(f"not shown within {patience:g} s\n{program.last_output(60)}")


def _has_crashed(program: ChildProcess) -> bool:
    """Return whether RViz died of a signal, itself or below roslaunch."""
    status = program.exit_status
    if status is None:
        return False
    codes = "|".join(f"-{signal:d}" for signal in _CRASHES)
    told = re.search(rf"exit code ({codes}), cmd \S+/rviz ", program.last_output(60))
    return status in {-signal for signal in _CRASHES} or told is not None


def variables(screen: Screen, home: Path) -> dict[str, str]:
    """Return what RViz needs on the screen; it keeps its settings in ``home``."""
    return {"HOME": str(home), "XDG_RUNTIME_DIR": str(home), **screen.environment}


def view(pixels: Pixels) -> Pixels:
    """Return the part of the screen that shows the world, without the tool bars."""
    is_background = (pixels == BACKGROUND).all(axis=2)
    rows = np.flatnonzero(is_background.mean(axis=1) > 0.2)
    if not len(rows):
        return pixels[:0, :0]
    columns = np.flatnonzero(is_background[rows].mean(axis=0) > 0.2)
    return pixels[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]


def blue(pixels: Pixels) -> Mask:
    """Return where the caps of the UR's joints are."""
    red, green, blue = np.moveaxis(pixels.astype(int), 2, 0)
    bluer = blue - red
    return (bluer > 30) & (bluer < 100) & (green - red > 10) & (blue > green)


def black(pixels: Pixels) -> Mask:
    """Return where the gripper is, and a few rings of the arm."""
    return pixels.max(axis=2, initial=0) < 60
