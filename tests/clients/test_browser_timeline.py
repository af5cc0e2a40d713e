"""The time line in a real browser: the last minutes of a robot, and recordings."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import Tab, eventually, time_passes
from playwright.sync_api import Browser
from recorded_session import TURNED, record_session

import tool0
from conftest import OpenTab
from tool0.panel.replay.view import Replay
from tool0.panel.server import Panel
from tool0.recording.reading import RecordingFile, open_recording

ELBOW = "elbow_joint"
START = 1.571
"""Where the elbow is at first [rad]."""


def share(tab: Tab, part: float) -> tuple[float, float]:
    """Return the point at a share of the line [px]."""
    box = tab.get("timeline-position").bounding_box()
    assert box is not None
    return box["x"] + part * box["width"], box["y"] + 0.75 * box["height"]


def clock(tab: Tab) -> float:
    """Return the time that is shown [s]."""
    return float((tab.get("timeline-time").text_content() or "").split()[0])


def position(tab: Tab) -> float:
    """Return the place on the line [s]."""
    return float(tab.get("timeline-position").input_value())


# ---- a running robot -----------------------------------------------------------------


def moved(robot: tool0.Robot) -> None:
    """Move the elbow, and wait until a second has passed after that."""
    point = tool0.TrajectoryPoint(positions=TURNED, time_from_start=0.5)
    time_passes(robot, 0.7)
    robot.controller("eff_joint_traj_controller").follow([point]).wait(timeout=30.0)
    time_passes(robot, 0.7)


def test_the_last_moments_of_a_running_robot(robot: tool0.Robot, tab: Tab) -> None:
    tab.see("[data-testid=timeline][data-past=false]")
    tab.shows_joint(ELBOW, START, 0.01)
    moved(robot)
    tab.shows_joint(ELBOW, TURNED[2], 0.01)
    tab.drive()
    tab.see("[data-testid=timeline-marker][data-kind=goal]")
    tab.page.mouse.click(*share(tab, 0.02))
    tab.see("[data-testid=timeline][data-past=true]")
    tab.shows_joint(ELBOW, START, 0.01)
    # what is shown stays, while time passes and the robot cannot be driven
    before = clock(tab)
    time_passes(robot, 0.3)
    assert clock(tab) == before
    tab.text("driving-state", "the past")
    assert tab.get("enable-toggle").is_disabled()
    tab.get("timeline-live").click()
    tab.see("[data-testid=timeline][data-past=false]")
    tab.shows_joint(ELBOW, TURNED[2], 0.01)
    eventually(lambda: clock(tab) > before + 0.3, "time passes on the page")


def test_the_past_by_keyboard(robot: tool0.Robot, tab: Tab) -> None:
    tab.see("[data-testid=timeline]")
    moved(robot)
    # so that nothing else happens: a busy machine has late ticks, which are marked, too
    robot.pause()
    tab.see("[data-testid=sim-resume]")
    goal = tab.see("[data-testid=timeline-marker][data-kind=goal]")
    ended = float((goal.get_attribute("title") or "").split()[0])
    press = tab.page.keyboard.press
    press("[")
    tab.see("[data-testid=timeline][data-past=true]")
    marks = [
        float((mark.get_attribute("title") or "").split()[0])
        for mark in tab.get("timeline-marker").all()
    ]
    eventually(
        lambda: any(abs(position(tab) - mark) < 0.01 for mark in marks), "at a mark"
    )
    goal.click()
    eventually(lambda: abs(position(tab) - ended) < 0.01, "at the goal's end")
    tab.get("timeline-position").focus()
    press("ArrowLeft")
    eventually(lambda: abs(position(tab) - ended + 0.1) < 0.01, "0.1 s before that")
    press("Home")
    tab.shows_joint(ELBOW, START, 0.05)
    at = clock(tab)
    press("Space")
    eventually(lambda: clock(tab) > at + 0.2, "the past is played")
    press("Space")
    press("End")
    tab.see("[data-testid=timeline][data-past=false]")


# ---- a recording ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> RecordingFile:
    file: Path = tmp_path_factory.mktemp("recording") / "session.mcap"
    record_session(file)
    return open_recording(file)


@pytest.fixture
def replay(recording: RecordingFile) -> Iterator[Panel]:
    with Panel(Replay(recording)) as panel:
        yield panel


def test_scrubbing_shows_the_robot_as_it_was(
    replay: Panel, recording: RecordingFile, open_tab: OpenTab
) -> None:
    tab = open_tab(replay.url)
    tab.see("[data-testid=scene][data-ready=true]")
    tab.page.mouse.move(*share(tab, 0.0))
    tab.page.mouse.down()
    for part in (0.2, 0.35, 0.8, 0.28):
        tab.page.mouse.move(*share(tab, part))
    tab.page.mouse.up()
    wanted = recording.time[0] + 0.28 * recording.duration
    eventually(lambda: abs(clock(tab) - wanted) < 0.02, "the page shows that time")
    index = int(abs(recording.time - clock(tab)).argmin())
    for joint in ("shoulder_pan_joint", ELBOW):
        column = recording.joint_names.index(joint)
        tab.shows_joint(joint, recording.position[index, column], 2e-3)
    assert tab.get("estop").count() == 0
    assert tab.get("enable-toggle").count() == 0


def test_a_recording_plays_and_its_log_grows(replay: Panel, open_tab: OpenTab) -> None:
    tab, other = open_tab(replay.url), open_tab(replay.url)
    tab.get("tab-log").click()
    tab.get("timeline-speed").select_option("2")
    assert tab.get("log-entry").count() == 0
    tab.get("timeline-play").click()
    tab.see("[data-testid=log-entry][data-code=goal_succeeded]")
    tab.see("[data-testid=log-entry][data-code=goal_preempted]")
    # every page shows the same time
    eventually(lambda: clock(other) > 2.0, "the other page follows")
    tab.get("timeline-position").press("Home")
    eventually(lambda: tab.get("log-entry").count() == 0, "the log is of that time")


def test_marks_lead_to_what_happened(replay: Panel, open_tab: OpenTab) -> None:
    tab = open_tab(replay.url)
    marker = tab.see("[data-testid=timeline-marker][data-kind=goal]").first
    assert "goal succeeded" in (marker.get_attribute("title") or "")
    tab.page.keyboard.press("]")
    first = tab.page.wait_for_function(
        """() => {
            const text = document.querySelector('[data-testid=timeline-time]');
            const time = parseFloat(text?.textContent ?? "0");
            return time > 0.1 ? time : false;
        }"""
    ).json_value()
    assert first == pytest.approx(1.0, abs=0.1)
    tab.shows_joint(ELBOW, TURNED[2], 0.01)
    tab.get("timeline-next").click()
    eventually(lambda: clock(tab) > first + 0.1, "the next mark")
    tab.get("timeline-previous").click()
    eventually(lambda: clock(tab) == pytest.approx(first, abs=0.02), "back again")


def test_plots_show_what_was_recorded(
    replay: Panel, recording: RecordingFile, open_tab: OpenTab
) -> None:
    tab = open_tab(replay.url)
    tab.get("plots-toggle").click()
    tab.see("[data-testid=timeline-position]").press("End")
    index = recording.joint_names.index(ELBOW)
    last = recording.position[-1, index]
    tab.page.wait_for_function(
        """([id, wanted]) => {
            const shown = document.querySelector(`[data-signal="${id}"]`);
            return Math.abs(parseFloat(shown?.textContent) - wanted) < 2e-3;
        }""",
        arg=[f"joint/{ELBOW}/position", last],
    )


def test_a_phone_scrubs_by_touch(browser: Browser, replay: Panel) -> None:
    tab = Tab(browser, replay.url, width=390, height=844, has_touch=True)
    tab.see("[data-testid=timeline]")
    overflow = "document.documentElement.scrollWidth - innerWidth"
    assert tab.page.evaluate(overflow) <= 0
    x, y = share(tab, 0.5)
    tab.page.touchscreen.tap(x, y)
    eventually(lambda: 1.0 < clock(tab) < 1.6, "the middle is shown")
    tab.close()
