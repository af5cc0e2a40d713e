"""The robot that the commands of these tests find."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from served import serving

import tool0
from tool0.cli import FAILED, main


@pytest.fixture(scope="module")
def served_robot(runtime_folder: Path) -> Iterator[tool0.Robot]:
    with tool0.bringup(speed=10.0) as robot, serving(robot):
        yield robot


@pytest.fixture
def robot(served_robot: tool0.Robot) -> Iterator[tool0.Robot]:
    """Return it as it was brought up."""
    yield served_robot
    served_robot.emergency_stop(engaged=False)
    served_robot.resume()
    for item in served_robot.scene:
        served_robot.scene.remove(item)
    served_robot.force_torque.stop()
    served_robot.reset()


@pytest.fixture
def refused(
    robot: tool0.Robot, capsys: pytest.CaptureFixture[str]
) -> Callable[[str], str]:
    """Return a function that runs a wrong command line and returns what is said.

    It checks that this is one line, and that nothing has changed.
    """

    def state() -> object:
        snapshot = robot.snapshot
        targets = {name: motion.target for name, motion in snapshot.setpoints().items()}
        return targets, snapshot.controllers, snapshot.scene, snapshot.is_paused

    def run(line: str) -> str:
        before = state()
        assert main(line.split()) == FAILED
        out, error = capsys.readouterr()
        assert out == ""
        assert error.startswith("tool0: error: ")
        assert error.count("\n") == 1
        assert state() == before
        return error

    return run
