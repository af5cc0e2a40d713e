"""The script that lets Gazebo's time run once the controllers are there.

The native controller_manager is not here; tool0's own presents the same services.
"""

from collections.abc import Iterator

import pytest
from ros import Bringup, Ros, system_python

from tool0.description.packages import BUNDLED

SCRIPT = str(BUNDLED / "tool0_gazebo" / "scripts" / "unpause_when_loaded")
STARTED = ("joint_state_controller", "eff_joint_traj_controller", "gripper_controller")


@pytest.fixture
def paused(ros: Ros) -> Iterator[Bringup]:
    bringup = ros.bring_up("--paused")
    yield bringup
    bringup.close()


def is_paused(ros: Ros) -> bool:
    """Return whether Gazebo's time stands still."""
    return "pause: True" in ros.run(
        "rosservice", "call", "/gazebo/get_physics_properties"
    )


def test_time_runs_when_the_controllers_are_loaded(ros: Ros, paused: Bringup) -> None:
    assert is_paused(ros)
    answer = ros.outcome(system_python(), SCRIPT, *STARTED)
    assert answer.returncode == 0, answer.stderr
    assert "all the same" not in answer.stdout + answer.stderr
    assert not is_paused(ros)


def test_time_runs_in_the_end_without_a_controller(ros: Ros, paused: Bringup) -> None:
    answer = ros.outcome(system_python(), SCRIPT, "no_such", "_patience:=0.5")
    assert answer.returncode == 0, answer.stderr
    assert "one of no_such; time runs all the same" in answer.stdout + answer.stderr
    assert not is_paused(ros)
