"""Take a picture of RViz with the robot of ``tool0 bringup --ros1`` in it.

usage: python tools/screenshot_rviz.py docs/images/rviz.webp [--width 1280] …

The tool starts a roscore, the robot and RViz on a separate screen (Xvfb).  The tool
moves the arm like any client of ROS does, and waits until the picture in RViz no longer
changes.  The tool needs `tool0 ros1 install --rviz`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from webp import encode_webp

ROOT = Path(__file__).resolve().parent.parent
_TIMEOUT = 60.0
"""Longest wait for the window [wall s]."""
_SAME_FRAMES = 15
"""Number of successive pictures that must be equal before the robot is considered at
rest."""
_JITTER = 0.002
"""Fraction of the pixels that may differ.  At rest, the edges of the robot still change
slightly."""
_JOINTS = (
    "[elbow_joint, shoulder_lift_joint, shoulder_pan_joint, "
    "wrist_1_joint, wrist_2_joint, wrist_3_joint]"
)
_POSE = "[1.5, -1.7, -0.4, -1.37, -1.57, 0.0]"


def main() -> None:
    """Take the picture that the arguments specify."""
    sys.path.insert(0, str(ROOT / "tests/rigs"))
    from in_rviz import black, blue, start_rviz, view  # noqa: PLC0415  # of the tests
    from ros import Ros  # noqa: PLC0415
    from screen import Pixels, Screen  # noqa: PLC0415

    options = _options()
    size = (options.width, options.height)
    with tempfile.TemporaryDirectory() as home, Ros() as ros, Screen(*size) as screen:
        ros.bring_up()
        start_rviz(ros, screen, Path(home), size=size, has_panel=True, distance=1.7)
        looks: list[Pixels] = []

        def is_drawn(pixels: Pixels) -> bool:
            world = view(pixels)
            if not (blue(world).any() and black(world).any()):
                return False
            if looks and (looks[-1] != world).mean() > _JITTER:
                looks.clear()
            looks.append(world)
            return len(looks) > _SAME_FRAMES

        before = screen.wait_for(is_drawn, _TIMEOUT)
        if before is None:
            sys.exit(f"RViz did not show the robot within {_TIMEOUT:g} s")
        ros.run(
            *("rostopic", "pub", "--once", "/eff_joint_traj_controller/command"),
            "trajectory_msgs/JointTrajectory",
            f"{{joint_names: {_JOINTS}, points: "
            f"[{{positions: {_POSE}, time_from_start: {{secs: 1}}}}]}}",
        )
        looks.clear()
        picture = screen.wait_for(is_drawn, _TIMEOUT)
        if picture is None or (view(picture) != view(before)).mean() < 10 * _JITTER:
            sys.exit(f"RViz did not follow the robot within {_TIMEOUT:g} s")
        options.output.write_bytes(encode_webp(picture))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=800)
    return parser.parse_args()


if __name__ == "__main__":
    main()
