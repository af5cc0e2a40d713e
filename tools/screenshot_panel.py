"""Take a picture of the panel in a browser.

usage: python tools/screenshot_panel.py docs/images/panel.webp [--width 1440] …

The tool brings up the example's scene or a cell (``--robots``), moves the arms while
the plots are open, and waits until the page has drawn them.  The tool needs Chromium
(tools/setup-browser).
"""

from __future__ import annotations

import argparse
from pathlib import Path

from panel_page import panel_page, picture, wait_for_frames, wait_for_real_time

import tool0
from tool0.description.cell_file import parse_robots
from tool0.panel.server import Panel

SCENE = "table_and_cubes"


def main() -> None:
    """Take the picture that the arguments specify."""
    options = _options()
    with (
        _robot(options.robots) as robot,
        Panel(robot) as panel,
        panel_page(
            panel.url,
            width=options.width,
            height=options.height,
            theme=options.theme,
            language=options.language,
            quality=options.quality,
        ) as page,
    ):
        if options.select:
            page.get_by_test_id(f"robot-{options.select}").click()
        if options.plots:
            page.get_by_test_id("plots-toggle").click()
            page.get_by_test_id("plots-chart").wait_for()
            page.get_by_test_id("plots-window-60").click()
        for goal in robot.go_to_pose("ready"):
            goal.wait(60.0)
        for gripper in robot.grippers.values():
            gripper.move(opening=0.6 * gripper.geometry.max_opening).wait(60.0)
        wait_for_frames(page, 4)
        wait_for_real_time(page)
        options.output.write_bytes(picture(page))


def _robot(robots: list[str] | None) -> tool0.Robot:
    if robots is None:
        return tool0.bringup(scene=SCENE)
    return tool0.bringup(cell=parse_robots(robots))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--width", type=int, default=1440)
    parser.add_argument("--height", type=int, default=900)
    parser.add_argument("--theme", choices=("light", "dark"), default="light")
    parser.add_argument("--language", choices=("en", "zh"), default="en")
    parser.add_argument("--quality", choices=("low", "high"), default="high")
    parser.add_argument("--plots", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--robots", nargs="+", metavar="NAME=ARM+GRIPPER@X,Y,Z")
    parser.add_argument("--select", help="the robot to select, of several")
    return parser.parse_args()


if __name__ == "__main__":
    main()
