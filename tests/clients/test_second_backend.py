"""A robot that is no simulation, driven by every client without an edit of them."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from page import Page, page_at
from path_robot import PathRobot
from served import serving, use_folder

import tool0
from tool0.cli import FAILED, OK, main
from tool0.errors import ControlError
from tool0.panel.server import Panel
from tool0.protocol.channel import LocalChannel
from tool0.protocol.methods import methods

REASON = "this robot only follows joint paths"
OFFERED = {
    "read_info",
    "read_description",
    "read_snapshot",
    "list_controllers",
    "move_joints",
    "follow_trajectory",
}


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.Robot(LocalChannel(PathRobot().backend)) as robot:
        yield robot


def test_python_drives_it(robot: tool0.Robot) -> None:
    (goal,) = robot.move_joints({"elbow_joint": 0.4}, duration=0.2)
    assert goal.wait().status is tool0.GoalStatus.SUCCEEDED
    assert robot.snapshot.positions["elbow_joint"] == 0.4


@pytest.mark.parametrize(
    "ask",
    [
        lambda robot: robot.reset(),
        lambda robot: robot.pause(),
        lambda robot: robot.contacts(),
        lambda robot: robot.gripper.move(opening=0.02),
        lambda robot: robot.scene.remove("cube"),
        lambda robot: robot.start_recording("x.mcap"),
    ],
)
def test_what_it_lacks_is_refused_with_the_reason(
    robot: tool0.Robot, ask: Callable[[tool0.Robot], object]
) -> None:
    with pytest.raises(ControlError, match=REASON):
        ask(robot)


def test_the_command_line_drives_it_over_the_socket(
    robot: tool0.Robot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    use_folder(monkeypatch, tmp_path)
    with serving(robot):
        assert main(["move", "--joints", "elbow_joint=0.3", "--duration", "0.2"]) == OK
        assert capsys.readouterr().out == "SUCCEEDED\n"
        with tool0.connect() as client:
            assert client.snapshot.positions["elbow_joint"] == pytest.approx(0.3)
        assert main(["reset"]) == FAILED
        assert REASON in capsys.readouterr().err


def test_the_panel_shows_and_drives_it(robot: tool0.Robot) -> None:
    with Panel(robot, port=0) as panel, page_at(panel.url) as page:
        assert page.request("move_joints", positions={"elbow_joint": 0.3}) is None
        page.wait_for_joint("elbow_joint", 0.3)
        assert_refused(page)


def assert_refused(page: Page) -> None:
    """Nothing that it lacks is offered to pages, or begun for them."""
    assert set(page.view["missing"]) == {
        name
        for name, request in methods().items()
        if not request.is_of_connection and name not in OFFERED
    }
    error = page.request("reset")
    assert error is not None
    assert REASON in error["message"]
