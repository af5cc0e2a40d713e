"""``tool0 wrench`` and its methods, against a fake robot."""

from __future__ import annotations

import pytest
from fake_robot import FakeRobot
from tool0.interfaces.socket.client import RemoteRobot

from tool0.cli import FAILED, OK, main


@pytest.fixture(autouse=True)
def robot(served_robot: FakeRobot) -> FakeRobot:
    return served_robot


def run(line: str) -> int:
    return main(line.split())


def test_it_prints_force_and_torque_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("wrench") == OK
    assert capsys.readouterr().out == (
        "t = 1.000 s  force   +0.00   -0.50   +9.03 N"
        "  torque   +0.0075   +0.0000   +0.0000 N·m  tool0\n"
    )
    assert run("wrench --raw") == OK
    assert "+0.25   -0.50   +9.00 N" in capsys.readouterr().out


def test_it_prints_every_sample_of_a_while(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("wrench --duration 0.04") == OK
    lines = capsys.readouterr().out.splitlines()
    times = [float(line.split()[2]) for line in lines]
    assert times == pytest.approx([1.0 + 0.008 * k for k in range(6)])


def test_it_zeroes_and_sets_the_rate(robot: FakeRobot) -> None:
    assert run("wrench --zero") == OK
    assert run("wrench --zero --rate 500") == OK
    assert run("wrench --cutoff 5") == OK
    assert robot.calls == [
        ("zero", {}),
        ("start", {"rate": 500.0, "cutoff": 15.0}),
        ("zero", {}),
        ("start", {"rate": None, "cutoff": 5.0}),
    ]


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("wrench --rate 20", r"rate 20 Hz is outside [50, 1000] Hz"),
        ("wrench --duration -1", "--duration must be 0 or more seconds, got -1.0"),
    ],
)
def test_what_cannot_be_is_told(
    line: str, complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line) == FAILED
    assert complaint in capsys.readouterr().err


def test_a_visitor_has_the_verbs_of_the_robot(robot: FakeRobot) -> None:
    with RemoteRobot() as remote:
        sensor = remote.force_torque
        assert sensor.start(250.0) == 250.0
        assert sensor.read() == robot.force_torque.read()
        assert sensor.samples(0) == list(robot.force_torque.samples(0))
        sensor.stop()
    assert [verb for verb, _ in robot.calls] == ["start", "stop"]
