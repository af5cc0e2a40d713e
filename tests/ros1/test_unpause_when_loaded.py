"""The script that lets Gazebo's time run once controllers and joints are in place.

The native controller_manager is not here; tool0's own presents the same services.
"""

import contextlib
import subprocess
from collections.abc import Iterator

import pytest
from ros import TIMEOUT, Ros, system_python

import tool0
from tool0.description.packages import BUNDLED

SCRIPT = str(BUNDLED / "tool0_gazebo" / "scripts" / "unpause_when_loaded")
STARTED = ("joint_state_controller", "eff_joint_traj_controller", "gripper_controller")


@pytest.fixture(scope="module")
def robot(ros: Ros) -> Iterator[tool0.Robot]:
    """Bring one robot up, and connect to it."""
    with (
        contextlib.closing(ros.bring_up("--paused")) as bringup,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setenv("XDG_RUNTIME_DIR", bringup.runtime_folder)
        with tool0.connect() as robot:
            yield robot


@pytest.fixture
def paused(robot: tool0.Robot) -> None:
    """Let the robot's time stand still at its start."""
    robot.pause()
    robot.reset()


def is_paused(ros: Ros) -> bool:
    """Return whether Gazebo's time stands still."""
    return "pause: True" in ros.run(
        "rosservice", "call", "/gazebo/get_physics_properties"
    )


def test_time_runs_when_the_controllers_are_loaded(ros: Ros, paused: None) -> None:
    assert is_paused(ros)
    answer = ros.outcome(system_python(), SCRIPT, *STARTED, "_patience:=60")
    assert answer.returncode == 0, answer.stderr
    assert "all the same" not in answer.stdout + answer.stderr
    assert not is_paused(ros)


def test_time_runs_in_the_end_without_a_controller(ros: Ros, paused: None) -> None:
    answer = ros.outcome(system_python(), SCRIPT, "no_such", "_patience:=0.5")
    assert answer.returncode == 0, answer.stderr
    assert "one of no_such; time runs all the same" in answer.stdout + answer.stderr
    assert not is_paused(ros)


def test_time_stands_still_until_the_joints_are_in_place(
    ros: Ros, paused: None
) -> None:
    """spawn_model sets them a second after the robot appears."""
    joints = ("-J", "elbow_joint", "1.2", "-J", "wrist_1_joint", "-0.5")
    with subprocess.Popen(
        [system_python(), "-u", SCRIPT, *STARTED, *joints, "_patience:=60"],
        env=dict(ros.tools),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as script:
        try:
            assert script.stdout is not None
            waiting = next(line for line in script.stdout if "waiting" in line)
            assert "elbow_joint is at 1.5708 instead of 1.2" in waiting
            assert is_paused(ros)
            place = "{model_name: robot, joint_names: [elbow_joint, wrist_1_joint], "
            place += "joint_positions: [1.2, -0.5]}"
            ros.run("rosservice", "call", "/gazebo/set_model_configuration", place)
            output, _ = script.communicate(timeout=TIMEOUT)
        finally:
            script.kill()
    assert script.returncode == 0, output
    assert "all the same" not in output
    assert not is_paused(ros)


@pytest.mark.parametrize(
    ("joint", "complaint"),
    [
        ("elbow_joint", "elbow_joint is at 1.5708 instead of 1.2"),
        ("elbow", "elbow (Gazebo has no joint of that name)"),
    ],
)
def test_time_runs_in_the_end_without_the_joints(
    ros: Ros, paused: None, joint: str, complaint: str
) -> None:
    joints = ("-J", "wrist_3_joint", "0.0", "-J", joint, "1.2")
    answer = ros.outcome(system_python(), SCRIPT, *STARTED, *joints, "_patience:=0.5")
    assert answer.returncode == 0, answer.stderr
    expected = f"not in place within 0.5 s: {complaint}; time runs all the same"
    assert expected in answer.stdout + answer.stderr
    assert not is_paused(ros)
