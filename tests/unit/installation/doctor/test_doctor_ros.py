from pathlib import Path

import pytest

from tool0.errors import RosUnavailableError
from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine
from tool0.installation.doctor.ros import ros1, ros2
from tool0.installation.ros1.readiness import Readiness

NEEDED = {"rospy": ("rospy", "rosgraph"), "messages": ("genpy", "genmsg", "std_msgs")}


def with_ros1(
    monkeypatch: pytest.MonkeyPatch, found: Readiness, *, codename: str = "bookworm"
) -> list[Line]:
    setup = "tool0.installation.ros1"
    monkeypatch.setattr(f"{setup}.readiness.readiness", lambda: found)
    monkeypatch.setattr(f"{setup}.distribution.distribution", lambda: ("X", codename))
    return ros1(Machine(environ={"PATH": ""}))


def test_ros_2_is_told_apart_from_what_tool0_does(tmp_path: Path) -> None:
    (line,) = ros2(Machine(root=tmp_path))
    assert line.state == "not supported"
    assert line.found == "by tool0 yet; nothing of it is here"
    for distro in ("humble", "jazzy"):
        home = tmp_path / "opt/ros" / distro / "lib/python3.10/site-packages/rclpy"
        home.mkdir(parents=True)
    (line,) = ros2(Machine(root=tmp_path))
    assert line.state == "not supported"
    assert f"{tmp_path / 'opt/ros/humble'} with rclpy" in line.found
    assert f"{tmp_path / 'opt/ros/jazzy'} with rclpy" in line.found


def test_ros_1_is_installed_where_it_is_packaged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("tool0.installation.ros1.install.plan", lambda rviz: None)
    (line,) = with_ros1(monkeypatch, Readiness(master="", missing=NEEDED))
    assert (line.what, line.state) == ("ros1", "missing")
    assert line.found == "no rospy, rosgraph, genpy, genmsg, …; for --ros1"
    assert line.remedy == "tool0 ros1 install --rviz"


@pytest.mark.parametrize(
    ("codename", "state"), [("bookworm", "missing"), ("noble", "not supported")]
)
def test_where_it_cannot_be_installed_the_reason_is_told(
    monkeypatch: pytest.MonkeyPatch, codename: str, state: str
) -> None:
    def plan(rviz: bool) -> None:
        raise RosUnavailableError("the reason, and who does")

    monkeypatch.setattr("tool0.installation.ros1.install.plan", plan)
    found = Readiness(master="", missing=NEEDED)
    (line,) = with_ros1(monkeypatch, found, codename=codename)
    assert (line.state, line.found) == (state, "the reason, and who does")


def test_what_ros_1_can_do_without_has_lines_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    remedy = "tool0 ros1 install --rviz"
    found = Readiness(
        rospy=Path("/r/rospy"),
        version="1.15",
        source="the distribution's",
        master="http://localhost:11311",
        missing={"tf2": ("tf2_ros",), "rviz": ("rviz",)},
        remedies=(remedy,),
    )
    main, tools, rviz = with_ros1(monkeypatch, found)
    assert main.state == "ready"
    assert "1.15, the distribution's" in main.found
    assert "add --roscore" in main.found
    assert (tools.state, tools.found, tools.remedy) == ("missing", "tf2", remedy)
    assert (rviz.state, rviz.remedy) == ("missing", remedy)


def test_a_master_that_answers_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Readiness(rospy=Path("/r"), master="http://x:1", is_master_up=True)
    lines = with_ros1(monkeypatch, found)
    assert [line.state for line in lines] == ["ready"] * 3
    assert "http://x:1 answers" in lines[0].found
