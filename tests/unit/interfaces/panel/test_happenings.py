from collections.abc import Iterator
from pathlib import Path

import pytest
from tool0.interfaces.panel.happenings import MOST_AT_ONCE, Watcher
from tool0.interfaces.panel.simulation import SimulationSource

import tool0
from tool0.interfaces.panel.notices import KEPT, NoticeBook
from tool0.interfaces.panel.source import Happening
from tool0.runtime.bus import Faulted, Overran

ARM = "eff_joint_traj_controller"


@pytest.fixture
def still() -> Iterator[tool0.Robot]:
    """A robot whose time passes only when asked to."""
    with tool0.bringup(realtime=False) as robot:
        yield robot


def told(watcher: Watcher) -> list[tuple[str, str, str]]:
    return [(item.severity, item.code, item.text) for item in watcher.happenings()]


def test_what_happens_is_told_once_in_words(still: tool0.Robot) -> None:
    watcher = Watcher(still)
    assert told(watcher) == []
    goal = still.controller(ARM).follow(
        [tool0.TrajectoryPoint(still.snapshot.position[:6], time_from_start=0.1)]
    )
    goal.wait()
    assert told(watcher) == [("info", "goal_succeeded", f"{ARM}: goal succeeded")]
    still.emergency_stop()
    assert told(watcher) == [("warning", "emergency_stop", "emergency stop engaged")]
    still.emergency_stop(False)
    assert told(watcher) == [("info", "emergency_stop", "emergency stop released")]
    still.switch(stop=[ARM])
    assert told(watcher) == [("info", "controllers", f"{ARM} stopped")]
    still.unload(ARM)
    assert told(watcher) == [("info", "controllers", f"{ARM} unloaded")]
    still.reset()
    assert told(watcher) == [("info", "reset", "the simulation was reset")]
    assert told(watcher) == []
    watcher.close()


def test_faults_and_overruns_are_told(still: tool0.Robot) -> None:
    watcher = Watcher(still)
    bus = watcher._subscription
    bus.events += [Overran(1, 2.0), Overran(7, 3.0), Faulted("it broke", 4.0)]
    assert told(watcher) == [
        ("warning", "overrun", "1 tick began late within a second"),
        ("warning", "overrun", "7 ticks began late within a second"),
        ("error", "fault", "it broke"),
    ]
    watcher.close()


def test_a_flood_of_goals_is_told_shortly_and_hides_no_error(
    still: tool0.Robot,
) -> None:
    watcher = Watcher(still)
    point = tool0.TrajectoryPoint(still.snapshot.position[:6], time_from_start=5.0)
    for _ in range(100):
        still.controller(ARM).follow([point])
    watcher._subscription.events.append(Faulted("it broke", 4.0))
    found = told(watcher)
    assert len(found) == MOST_AT_ONCE + 1
    assert ("error", "fault", "it broke") in found
    assert found[-1][2] == "… and 80 more"
    watcher.close()


def test_steering_ends_no_goals_and_so_floods_nobody(still: tool0.Robot) -> None:
    watcher = Watcher(still)
    for k in range(20):
        still.controller(ARM).steer({"elbow_joint": 1.5 + k / 100})
        still.run(0.1)
    assert told(watcher) == []
    watcher.close()


def test_warnings_of_the_yaml_are_told_at_the_start(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(
        "joint_state_controller:\n"
        "  type: joint_state_controller/JointStateController\n"
        "  publish_rate: 50\n"
        "  publish_rat: 50\n"
    )
    with tool0.bringup(realtime=False, controllers_file=file) as robot:
        ((severity, code, text),) = told(watcher := Watcher(robot))
        watcher.close()
    assert (severity, code) == ("warning", "lint")
    assert text.startswith(f"{file}:4: ")


def test_poses_that_cannot_be_read_are_told_once(
    still: tool0.Robot, data_home: Path
) -> None:
    source = SimulationSource(still)
    still.save_pose("mine")
    (file,) = data_home.rglob("*.yaml")
    file.write_text("{")
    for _ in range(3):
        assert {pose.name for pose in source.status(1).poses} >= {"home"}
    assert [item.code for item in source.happenings()] == ["log"]
    source.close()


def test_the_last_notices_are_kept_and_numbered() -> None:
    book = NoticeBook()
    for k in range(KEPT + 10):
        book.note(Happening(severity="info", code="log", text=str(k)))
    assert len(book.kept) == KEPT
    assert [book.kept[0].number, book.kept[-1].number] == [11, KEPT + 10]


def test_a_refusal_that_differs_in_numbers_alone_is_told_once() -> None:
    book = NoticeBook()
    texts = ("joint 'a' at 3.2", "joint 'a' at 3.25", "joint 'b' at 3.2")
    notices = [
        book.note(Happening(severity="warning", code="refused", text=text))
        for text in texts
    ]
    assert [notice is not None for notice in notices] == [True, False, True]
