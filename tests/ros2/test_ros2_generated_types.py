"""Types that tool0 generated go through ROS 2 as those of its own packages do."""

import json
import subprocess
from pathlib import Path

from ros2_domain import TIMEOUT, Domain

PROGRAM = Path(__file__).parent / "client" / "round_trip.py"
SUCCEEDED = 4


def test_an_action_and_a_service_make_a_round_trip(own_domain: Domain) -> None:
    answer = subprocess.run(
        [own_domain.ros2.python, PROGRAM],
        env=dict(own_domain.ros_environment),
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=True,
    )
    assert json.loads(answer.stdout) == {
        "status": SUCCEEDED,
        "error_code": -5,
        "error_string": "é, at last",
        "joint_names": ["a", "b"],
        "desired": [0.5, -1.0],
        "position": [7.0, 0.25],
    }
    assert "ype support" not in answer.stderr  # all kinds of it are there
    assert "truncated" not in answer.stderr
