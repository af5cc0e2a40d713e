"""Make the pictures of the tutorials.

usage: PYTHONPATH=tests/rigs python tools/tutorial_pictures.py [NAME …]

Each picture is made by a function below.  Without names, all pictures are made.  The
tool needs Chromium (tools/setup-browser) and OpenGL (tools/setup-gl).
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

from document import blocks
from panel_page import panel_page, picture, wait_for_frames
from playwright.sync_api import Page
from ros import Bringup
from webp import encode_webp

import tool0
from tool0.description.camera import Camera, looking
from tool0.panel.replay.view import Replay
from tool0.panel.server import Panel
from tool0.scene import Box, Pose

ROOT = Path(__file__).resolve().parent.parent
TUTORIALS = ROOT / "docs/tutorials"
FOLDER = ROOT / "docs/images/tutorials"
SAVED = ("python", "xml", "yaml")
WIDTH, HEIGHT = 1280, 800
"""Size of a window with the panel [px]."""
DOWN = (math.pi, 0.0, 0.0)
PADS = Pose(xyz=(0.0, 0.0, 0.1418))

Maker = Callable[[], bytes]
PICTURES: dict[str, Maker] = {}


def named(name: str) -> Callable[[Maker], Maker]:
    """Register the function that makes ``name``.webp."""

    def register(maker: Maker) -> Maker:
        PICTURES[name] = maker
        return maker

    return register


# --- what they are made with ---


@contextmanager
def driven_page(robot: tool0.Robot) -> Iterator[Page]:
    """Open the panel of a robot, with Drive turned on."""
    with (
        Panel(robot) as panel,
        panel_page(panel.url, width=WIDTH, height=HEIGHT) as page,
    ):
        page.get_by_test_id("enable-toggle").click()
        yield page


def drawn(page: Page) -> bytes:
    """Return a picture of the page after the newest state is drawn."""
    wait_for_frames(page, 4)
    return picture(page)


def rendered(robot: tool0.Robot, camera: str) -> bytes:
    """Return a camera's image as WebP, in half of its size for smooth edges."""
    return encode_webp(robot.camera(camera).image().rgb, reduction=2)


def files_of(page: str) -> dict[str, str]:
    """Return the files that a reader of a tutorial saves, by name."""
    found = blocks(TUTORIALS / page)
    return {b.title: b.text for b in found if b.language in SAVED}


def followed(robot: tool0.Robot, page: str, program: str) -> None:
    """Run a program from a tutorial on a robot in this process."""

    @contextmanager
    def connect() -> Iterator[tool0.Robot]:
        yield robot

    text = files_of(page)[program]
    with patch.object(tool0, "connect", connect):
        exec(compile(text, program, "exec"), {})


def seen_from(
    eye: tuple[float, float, float], at: tuple[float, float, float]
) -> tool0.SimulationConfig:
    """Return a simulation that runs without real time and has a camera ``docs``."""
    camera = Camera(
        name="docs",
        pose=looking(eye, at),
        width=1600,
        height=1000,
        field_of_view=math.radians(36.0),
        far=20.0,
    )
    return tool0.SimulationConfig(cameras=(camera,), realtime=False)


# --- first-robot.md ---


@named("first-panel")
def first_panel() -> bytes:
    """Return a picture of the panel after the start."""
    with (
        tool0.bringup(scene="table_and_cubes") as robot,
        Panel(robot) as panel,
        panel_page(panel.url, width=WIDTH, height=HEIGHT) as page,
    ):
        return drawn(page)


@named("first-jog")
def first_jog() -> bytes:
    """Return a picture of the panel after jogging."""
    with (
        tool0.bringup(scene="table_and_cubes") as robot,
        driven_page(robot) as page,
    ):
        page.get_by_test_id("tool-toggle").click()
        button = page.get_by_test_id("jog-x-plus")
        button.scroll_into_view_if_needed()
        button.hover()
        page.mouse.down()
        page.wait_for_timeout(300)
        page.mouse.up()
        return drawn(page)


@named("first-grip")
def first_grip() -> bytes:
    """Return a picture of the gripper with the red cube."""
    simulation = seen_from((1.35, -0.75, 0.5), (0.42, 0.06, 0.16))
    with tool0.bringup(scene="table_and_cubes", simulation=simulation) as robot:
        x, y, z = robot.scene.pose("red cube").position
        robot.arm.move_to(Pose(xyz=(x, y, z + 0.15), rpy=DOWN), tool=PADS).wait()
        robot.arm.move_linear(Pose(xyz=(x, y, z), rpy=DOWN), tool=PADS).wait()
        robot.gripper.move(opening=0.0, speed=0.05, force=40.0)
        robot.gripper.wait()
        robot.arm.move_linear(Pose(xyz=(x, y, z + 0.15), rpy=DOWN), tool=PADS).wait()
        return rendered(robot, "docs")


@named("first-replay")
def first_replay() -> bytes:
    """Return a picture of the replay of the program."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "pick.mcap")
        simulation = tool0.SimulationConfig(realtime=False, scene="table_and_cubes")
        with tool0.bringup(simulation=simulation, record=file) as robot:
            followed(robot, "first-robot.md", "pick.py")
        source = Replay(tool0.open_recording(file))
        with (
            Panel(source) as panel,
            panel_page(panel.url, width=WIDTH, height=HEIGHT) as page,
        ):
            source.playhead.play()
            page.wait_for_timeout(3000)
            source.playhead.pause()
            return drawn(page)


# --- your-own-robot.md ---


@contextmanager
def own_files() -> Iterator[Path]:
    """Yield a folder with the files from the page."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for title, text in files_of("your-own-robot.md").items():
            corrected = text.replace("    elbow: {", "    elbow_joint: {")
            (folder / title).write_text(corrected, encoding="utf-8")
        yield folder


@contextmanager
def own_robot() -> Iterator[tool0.Robot]:
    """Bring up the robot from the page above its part."""
    start = {"shoulder_lift_joint": -1.57, "elbow_joint": 1.57, "wrist_1_joint": -1.57}
    with own_files() as folder:
        simulation = replace(
            seen_from((1.5, -1.2, 0.7), (0.36, -0.02, 0.26)),
            scene=folder / "my_scene.yaml",
        )
        with tool0.bringup(
            robot=folder / "my_robot.urdf.xacro",
            controllers_file=folder / "my_controllers.yaml",
            simulation=simulation,
            initial_pose={**start, "wrist_2_joint": -1.57},
        ) as robot:
            robot.arm.move_to(Pose(xyz=(0.5, -0.1, 0.4), rpy=DOWN)).wait()
            yield robot


@named("own-robot")
def own_robot_seen() -> bytes:
    """Return a picture of the robot above its part."""
    with own_robot() as robot:
        return rendered(robot, "docs")


@named("own-camera")
def own_camera() -> bytes:
    """Return a picture of the hand camera."""
    with own_robot() as robot:
        return rendered(robot, "hand")


@named("own-cell")
def own_cell() -> bytes:
    """Return a picture of the two robots."""
    with own_files() as folder:
        simulation = seen_from((-1.7, -0.5, 1.4), (0.3, 0.0, 0.15))
        cell = folder / "two_robots.yaml"
        with tool0.bringup(cell=cell, simulation=simulation) as robot:
            target = Pose(xyz=(0.35, -0.25, 0.25), rpy=DOWN)
            robot.arms["right"].move_to(target).wait()
            return rendered(robot, "docs")


# --- ros2.md ---


@named("ros2-controllers")
def ros2_controllers() -> bytes:
    """Return a picture of the controllers of ROS 2."""
    with (
        tool0.bringup(arm="ur5e", ros2_control=True) as robot,
        driven_page(robot) as page,
    ):
        page.get_by_role("tab", name="Controllers").click()
        return drawn(page)


# --- ur-rtde.md ---


@contextmanager
def ur_controller() -> Iterator[tool0.Robot]:
    """Bring up a UR5e beside the bin, with its control box."""
    with (
        tool0.bringup(arm="ur5e", scene="table_and_bin") as robot,
        tool0.UrController(robot) as ur,
    ):
        ur.wait()
        yield robot


def control_box(robot: tool0.Robot) -> bytes:
    """Return a picture of the panel's I/O tab."""
    with driven_page(robot) as page:
        page.get_by_role("tab", name="I/O").click()
        page.get_by_test_id("ur-program").wait_for()
        return drawn(page)


@named("ur-box")
def ur_box() -> bytes:
    """Return a picture of the control box."""
    with ur_controller() as robot:
        return control_box(robot)


@named("ur-stop")
def ur_stop() -> bytes:
    """Return a picture of the control box in a protective stop."""
    with tempfile.TemporaryDirectory() as folder, ur_controller() as robot:
        for title, text in files_of("ur-rtde.md").items():
            Path(folder, title).write_text(text)
        robot.arm.move_to(Pose(xyz=(0.5, -0.32, 0.29), rpy=DOWN)).wait()
        post = Box(size=(0.1, 0.1, 0.4))
        robot.scene.add("post", post, xyz=(0.68, -0.32, 0.18))
        subprocess.run([sys.executable, "bump.py"], cwd=folder, check=True)
        return control_box(robot)


# --- planning.md ---


@named("plan-panel")
def plan_panel() -> bytes:
    """Return a picture of a planned path around the wall."""
    with tool0.bringup(scene="shelf") as robot, driven_page(robot) as page:
        page.get_by_test_id("tool-toggle").click()
        for number, value in enumerate(("480", "-340", "350")):
            field = page.get_by_test_id(f"tool-{number}")
            field.fill(value)
            field.press("Enter")
        page.get_by_test_id("tool-go").click()
        page.get_by_test_id("plan-figures").wait_for()
        return drawn(page)


# --- real-arm.md ---


@named("real-arm")
def real_arm() -> bytes:
    """Return a picture of the panel of a real robot that tool0 only reads."""
    words = ("--ur", "--ur-active-gripper", "--arm", "ur5e", "--dt", "0.002")
    with closing(Bringup(os.environ, *words)) as stand_in:
        stand_in.wait()
        with (
            tool0.bringup(arm="ur5e", hardware="127.0.0.1") as robot,
            Panel(robot) as panel,
            panel_page(panel.url, width=WIDTH, height=HEIGHT) as page,
        ):
            page.get_by_test_id("real-robot-enable").wait_for()
            return drawn(page)


def main(names: list[str]) -> None:
    """Make the pictures with these names, or all pictures."""
    unknown = set(names) - PICTURES.keys()
    if unknown:
        sys.exit(f"unknown: {', '.join(unknown)}; there are {', '.join(PICTURES)}")
    FOLDER.mkdir(exist_ok=True)
    for name in names or PICTURES:
        made = PICTURES[name]()
        (FOLDER / f"{name}.webp").write_bytes(made)
        print(f"{name}.webp: {len(made) / 1e3:.0f} kB", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
