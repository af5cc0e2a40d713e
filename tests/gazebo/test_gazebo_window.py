"""gzclient on a screen of our own: it shows the robot, follows it, and ends with us."""

import logging
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from in_gazebo import PATIENCE, BringUp, gazebo_with, process_with_a_robot
from processes import Watch, descendants, program
from promised import absent
from screen import Pixels, Screen, find_xvfb

import tool0
from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.installation import GazeboInstallation
from tool0.user_data import cache_folder

GROUND, SKY = 224, 178
"""The greys of our world."""


@pytest.fixture(autouse=True)
def client(
    gazebo: GazeboInstallation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """See that there is a window to open; it keeps its settings in the test's HOME."""
    if gazebo.client is None:
        absent("gazebo", "this Gazebo has no gzclient (tool0 gazebo install --gui)")
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache_folder().parent))
    monkeypatch.setenv("HOME", str(tmp_path))


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> Iterator[Screen]:
    if find_xvfb() is None:
        absent("gazebo", "no Xvfb is installed")
    with Screen(960, 600) as screen:
        for name, value in screen.environment.items():
            monkeypatch.setenv(name, value)
        yield screen


def view(pixels: Pixels) -> Pixels:
    """Return the part of the screen that shows the world, without the tool bars."""
    is_world = np.isin(pixels, (GROUND, SKY)).all(axis=2)
    rows = np.flatnonzero(is_world.mean(axis=1) > 0.3)
    if not len(rows):
        return pixels[:0, :0]
    columns = np.flatnonzero(is_world[rows].mean(axis=0) > 0.3)
    return pixels[rows.min() : rows.max(), columns.min() : columns.max()]


def blue(pixels: Pixels) -> "np.ndarray[tuple[int, int], np.dtype[np.bool_]]":
    """Return where the caps of the UR's joints are; axes are bluer."""
    red, green, blue = np.moveaxis(pixels.astype(int), 2, 0)
    bluer = blue - red
    return (bluer > 30) & (bluer < 100) & (green - red > 10) & (blue > green)


def black(pixels: Pixels) -> "np.ndarray[tuple[int, int], np.dtype[np.bool_]]":
    """Return where the gripper is, and a few rings of the arm."""
    return pixels.max(axis=2, initial=0) < 60


def shows_the_robot(pixels: Pixels) -> bool:
    world = view(pixels)
    # Without a gripper there are some 60 black pixels.
    return bool(blue(world).sum() > 200 and black(world).sum() > 250)


def test_it_shows_the_robot_and_follows_it(screen: Screen, bring_up: BringUp) -> None:
    robot, engine = bring_up(engine_options={"gui": True})
    watch = Watch(engine.server.process_ids)
    seen = [np.empty(0)]

    def marks(pixels: Pixels) -> "np.ndarray[tuple[int, int], np.dtype[np.bool_]]":
        return blue(view(pixels)) | black(view(pixels))

    def is_settled(pixels: Pixels) -> bool:  # the window grows while it opens
        seen.append(marks(pixels))
        return shows_the_robot(pixels) and np.array_equal(*seen[-2:])

    before = screen.wait_for(is_settled, PATIENCE)
    assert before is not None
    for goal in robot.move_joints({"shoulder_pan_joint": -0.6}):
        goal.wait(timeout=10.0)

    def has_moved(pixels: Pixels) -> bool:
        # A small window has some 450 such pixels; nearly all of the gripper's move.
        now, then = marks(pixels), marks(before)
        return now.shape == then.shape and bool((now != then).sum() > 200)

    assert screen.wait_for(has_moved, PATIENCE) is not None
    (server,) = (pid for pid in engine.server.process_ids if "gzserver" in program(pid))
    environment = Path(f"/proc/{server}/environ").read_bytes().split(b"\0")
    assert b"DISPLAY=" in environment  # no sensor of this robot draws
    robot.close()
    assert watch.all_ended(0.0)


def test_closing_the_window_leaves_the_robot_running(
    screen: Screen, bring_up: BringUp
) -> None:
    robot, engine = bring_up(engine_options={"gui": True})
    assert screen.wait_for(lambda pixels: bool(pixels.any()), PATIENCE) is not None
    (client,) = (pid for pid in engine.server.process_ids if "gzclient" in program(pid))
    watch = Watch([client])
    os.kill(client, signal.SIGTERM)
    assert watch.all_ended(PATIENCE)
    robot.run(0.1)
    assert robot.snapshot.fault is None


def test_it_ends_with_a_process_that_is_killed(screen: Screen) -> None:
    with process_with_a_robot("gui") as (ours, _):
        assert screen.wait_for(lambda pixels: bool(pixels.any()), PATIENCE) is not None
        theirs = descendants(ours.pid)
        assert {program(pid)[:8] for pid in theirs} >= {"gzserver", "gzclient"}
        watch = Watch(theirs)
        ours.send_signal(signal.SIGKILL)
    assert watch.all_ended(PATIENCE)


def test_without_a_display_it_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(EngineUnavailableError) as error:
        tool0.bringup(simulation=gazebo_with(gui=True))
    assert "DISPLAY" in str(error.value)


def test_a_window_that_crashes_is_reported(
    monkeypatch: pytest.MonkeyPatch,
    bring_up: BringUp,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setenv("DISPLAY", ":4711")
    robot, _ = bring_up(engine_options={"gui": True})
    deadline = time.monotonic() + PATIENCE
    while not caplog.records and time.monotonic() < deadline:
        robot.run(0.01)
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert "could not connect to display :4711" in record.getMessage()
    robot.run(0.1)
