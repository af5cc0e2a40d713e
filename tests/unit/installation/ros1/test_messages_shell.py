"""``tool0 ros1 env``, and what ROS 1's own commands then know; they need no master."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from promised import require_ros

pytestmark = pytest.mark.slow

FORGET = ("PYTHONPATH", "ROS_PACKAGE_PATH")
EVALUATE = f'eval "$({sys.executable} -m tool0 ros1 env)" && '


@pytest.fixture(autouse=True)
def bare_shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require_ros()
    for variable in FORGET:
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "it's a $cache"))


def shell(script: str, **variables: str) -> str:
    answer = subprocess.run(
        ["sh", "-c", script],
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


def test_a_person_can_ask_rosmsg_and_rossrv_for_our_types() -> None:
    script = "rosmsg md5 control_msgs/FollowJointTrajectoryAction && "
    script += "rossrv md5 controller_manager_msgs/SwitchController && "
    script += "rosmsg show -r control_msgs/JointTolerance && "
    script += "rossrv show gazebo_msgs/GetJointProperties"
    lines = shell(EVALUATE + script).splitlines()
    assert "bc4f9b743838566551c0390c65f1a248" in lines
    assert "b29a7abc673b2c54c14b54e50f8d06a5" in lines
    assert "float64 acceleration" in lines
    assert "uint8 REVOLUTE=0" in lines


def test_what_the_variables_held_stays_before() -> None:
    held = {"PYTHONPATH": "/a b:/c", "ROS_PACKAGE_PATH": "/d"}
    script = EVALUATE + 'printf "%s\\n" "$PYTHONPATH" "$ROS_PACKAGE_PATH"'
    python, ros = shell(script, **held).splitlines()
    assert python.startswith("/a b:/c:/")
    assert ros.startswith("/d:/")
    folder = Path(python.rpartition(":")[2])
    assert (folder / "control_msgs" / "package.xml").is_file()
    assert ros.rpartition(":")[2] == str(folder)


def test_saying_it_twice_is_saying_it_once() -> None:
    say = 'printf "%s\\n" "$PYTHONPATH" "$ROS_PACKAGE_PATH"'
    assert shell(EVALUATE + EVALUATE + say) == shell(EVALUATE + say)


def test_it_says_why_it_cannot(tmp_path: Path) -> None:
    (tmp_path / "it's a $cache").touch()
    answer = subprocess.run(
        [sys.executable, "-m", "tool0", "ros1", "env"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (answer.returncode, answer.stdout) == (2, "")
    assert "cannot write the cache" in answer.stderr
