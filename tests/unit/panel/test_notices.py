from collections.abc import Iterator
from pathlib import Path

import pytest

import tool0
from tool0.panel.notices import (
    MAX_AT_ONCE,
    NOTICES_KEPT,
    EventWatcher,
    NoticeBook,
    Notification,
)
from tool0.panel.simulation_view import SimulationView
from tool0.protocol.bus import Faulted, Overran
from tool0.protocol.channel import backend_of

ARM = "eff_joint_traj_controller"


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    """A robot whose time passes only when asked to."""
    with tool0.bringup(realtime=False) as robot:
        yield robot


@pytest.fixture
def watcher(robot: tool0.Robot) -> Iterator[EventWatcher]:
    watcher = EventWatcher(robot.simulation, robot.warnings)
    yield watcher
    watcher.close()


def seen(watcher: EventWatcher) -> list[tuple[str, str, str]]:
    return [(item.severity, item.code, item.text) for item in watcher.notifications()]


def codes(watcher: EventWatcher) -> list[tuple[str, str]]:
    return [(severity, code) for severity, code, _ in seen(watcher)]


def test_every_event_is_described_once(
    robot: tool0.Robot, watcher: EventWatcher
) -> None:
    assert seen(watcher) == []
    goal = robot.controller(ARM).follow(
        [tool0.TrajectoryPoint(robot.snapshot.position[:6], time_from_start=0.1)]
    )
    goal.wait()
    assert seen(watcher) == [("info", "goal_succeeded", f"{ARM}: goal succeeded")]
    robot.emergency_stop()
    assert codes(watcher) == [("warning", "emergency_stop")]
    robot.emergency_stop(False)
    assert codes(watcher) == [("info", "emergency_stop")]
    box = robot.arm.control_box
    box.stop_protectively("a test")
    assert seen(watcher) == [
        ("warning", "protective_stop", "arm 'arm': protective stop: a test"),
        ("info", "controllers", f"{ARM} stopped"),
    ]
    box.restart_safety()
    assert codes(watcher) == [("info", "protective_stop"), ("info", "arm_modes")]
    box.release_brakes()
    assert seen(watcher) == [("info", "arm_modes", "arm 'arm': running")]
    box.play()
    assert seen(watcher) == [("info", "controllers", f"{ARM} running")]
    robot.switch(stop=[ARM])
    assert seen(watcher) == [("info", "controllers", f"{ARM} stopped")]
    robot.unload(ARM)
    assert seen(watcher) == [("info", "controllers", f"{ARM} unloaded")]
    robot.reset()
    assert codes(watcher) == [("info", "reset")]
    assert seen(watcher) == []


def test_faults_and_overruns_are_described(watcher: EventWatcher) -> None:
    events = watcher._subscription.events
    events += [Overran(7, 3.0), Overran(0, 3.5), Faulted("it broke", 4.0)]
    (severity, code, text), caught_up, fault = seen(watcher)
    assert (severity, code) == ("warning", "overrun")
    assert "7 late ticks" in text
    assert caught_up == ("info", "overrun", "the simulation keeps up again")
    assert fault == ("error", "fault", "it broke")


def test_many_goals_are_summed_up_and_hide_no_error(
    robot: tool0.Robot, watcher: EventWatcher
) -> None:
    point = tool0.TrajectoryPoint(robot.snapshot.position[:6], time_from_start=5.0)
    for _ in range(100):
        robot.controller(ARM).follow([point])
    watcher._subscription.events.append(Faulted("it broke", 4.0))
    found = seen(watcher)
    assert len(found) == MAX_AT_ONCE + 1
    assert ("error", "fault", "it broke") in found
    assert "80" in found[-1][2]


def test_steering_ends_no_goals(robot: tool0.Robot, watcher: EventWatcher) -> None:
    for k in range(20):
        robot.controller(ARM).steer({"elbow_joint": 1.5 + k / 100})
        robot.run(0.1)
    assert seen(watcher) == []


def test_findings_about_the_yaml_come_first(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(
        "joint_state_controller:\n"
        "  type: joint_state_controller/JointStateController\n"
        "  publish_rate: 50\n"
        "  publish_rat: 50\n"
    )
    with tool0.bringup(realtime=False, controllers_file=file) as robot:
        watcher = EventWatcher(robot.simulation, robot.warnings)
        ((severity, code, text),) = seen(watcher)
        watcher.close()
    assert (severity, code) == ("warning", "lint")
    assert text.startswith(f"{file}:4: ")


def test_an_unreadable_pose_file_is_reported_once(
    robot: tool0.Robot, data_home: Path
) -> None:
    view = SimulationView(backend_of(robot.channel))
    robot.save_pose("mine")
    (file,) = data_home.rglob("*.yaml")
    file.write_text("{")
    for _ in range(3):
        assert {pose.name for pose in view.status(1).poses} >= {"home"}
    assert [item.code for item in view.notifications()] == ["log"]
    view.close()


def test_the_last_notices_are_kept_and_numbered() -> None:
    book = NoticeBook()
    for k in range(NOTICES_KEPT + 10):
        book.note(Notification(severity="info", code="log", text=str(k)))
    assert len(book.kept) == NOTICES_KEPT
    assert [book.kept[0].number, book.kept[-1].number] == [11, NOTICES_KEPT + 10]


def test_a_refusal_that_differs_in_numbers_alone_is_noted_once() -> None:
    book = NoticeBook()
    texts = ("joint 'a' at 3.2", "joint 'a' at 3.25", "joint 'b' at 3.2")
    notices = [
        book.note(Notification(severity="warning", code="refused", text=text))
        for text in texts
    ]
    assert [notice is not None for notice in notices] == [True, False, True]


def test_a_joint_that_pushes_and_does_not_move_is_reported(
    robot: tool0.Robot, watcher: EventWatcher
) -> None:
    group = "joint_group_eff_controller"
    robot.switch(start=[group], stop=[ARM])
    robot.controller(group).command([0.0, 0.0, 150.0, 0.0, 0.0, 0.0])
    robot.run(2.0)  # the elbow folds the arm upon itself
    ((severity, code, text),) = [item for item in seen(watcher) if "elbow" in item[2]]
    assert (severity, code) == ("warning", "stall")
    assert "'wrist_1_link' touches 'upper_arm_link'" in text
    view = SimulationView(backend_of(robot.channel))
    (stall,) = view.status(clients=1).stalls
    view.close()
    assert (stall.joint, stall.effort) == ("elbow_joint", 150.0)
    assert ("wrist_1_link", "upper_arm_link") in stall.contacts


def test_a_busy_machine_takes_one_place_of_the_notices_kept() -> None:
    book = NoticeBook()
    for count in (9, 0, 8, 0, 7):
        text = f"{count} late ticks"
        book.note(Notification(severity="warning", code="overrun", text=text, time=1.0))
        book.note(Notification(severity="info", code="reset", text=text, time=1.0))
    assert [notice.code for notice in book.kept].count("overrun") == 1
    assert [notice.code for notice in book.kept].count("reset") == 5
    assert book.kept[-2].text == "7 late ticks"
