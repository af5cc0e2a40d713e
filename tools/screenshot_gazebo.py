"""Take a picture of Gazebo's window with the robot in it.

usage: python tools/screenshot_gazebo.py docs/images/gazebo.webp [--width 1280] …

The tool brings up the example's scene in Gazebo on a separate screen (Xvfb), moves the
arm, and waits until the window has drawn the scene.  The tool needs `tool0 gazebo
install --gui`.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from webp import encode_webp

import tool0
from tool0.user_data import cache_folder, data_folder

ROOT = Path(__file__).resolve().parent.parent
SCENE = "table_and_cubes"
_TIMEOUT = 300.0
"""Longest wait for the window [wall s]."""
_SAME_FRAMES = 15
"""Number of successive pictures that must be equal before the window is considered
complete."""


def main() -> None:
    """Take the picture that the arguments specify."""
    sys.path.insert(0, str(ROOT / "tests/rigs"))
    from screen import Pixels, Screen  # noqa: PLC0415  # beside the tests

    options = _options()
    with (
        Screen(options.width, options.height) as screen,
        _home(options.width, options.height),
    ):
        os.environ.update(screen.environment)
        simulation = tool0.SimulationConfig(
            engine="gazebo", engine_options={"gui": True}, scene=SCENE, realtime=False
        )
        with tool0.bringup(simulation=simulation) as robot:
            for goal in robot.go_to_pose("ready"):
                goal.wait(60.0)
            robot.gripper.move(opening=0.05).wait(60.0)
            looks: list[Pixels] = []

            def is_drawn(pixels: Pixels) -> bool:
                if looks and not np.array_equal(looks[-1], pixels):
                    looks.clear()
                looks.append(pixels)
                # While the splash screen is shown, most of the screen is black.
                covers = np.mean(pixels.any(axis=-1)) > 0.9
                return len(looks) > _SAME_FRAMES and bool(covers)

            picture = screen.wait_for(is_drawn, _TIMEOUT)
    if picture is None:
        sys.exit(f"the window was not drawn within {_TIMEOUT:g} s")
    options.output.write_bytes(encode_webp(picture))


@contextmanager
def _home(width: int, height: int) -> Iterator[None]:
    """Set HOME to a folder with settings for a full-screen gzclient window."""
    os.environ["XDG_CACHE_HOME"] = str(cache_folder().parent)
    os.environ["XDG_DATA_HOME"] = str(data_folder().parent)
    with tempfile.TemporaryDirectory() as home:
        settings = Path(home, ".gazebo", "gui.ini")
        settings.parent.mkdir()
        settings.write_text(f"[geometry]\nx=0\ny=0\nwidth={width}\nheight={height}\n")
        os.environ["HOME"] = home
        yield


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=800)
    return parser.parse_args()


if __name__ == "__main__":
    main()
