"""Every example runs as it stands, without a display and without a warning."""

from __future__ import annotations

import ast
import contextlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from promised import ROS2, require_gl, require_ur_rtde
from ros import free_port
from ros2_domain import Domain

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.py"))
_LATE = re.compile(r"\d+ ticks began late in the last second")
"""What an example in real time says on a busy machine."""


SUCCEEDED = r"GoalResult\(status=SUCCEEDED, error_code=0, error_string=''\)"
PRINTED = {
    "01_hello_arm": [
        SUCCEEDED,
        r"3\.[0-7]\d* 1\.(3[89]|4[01])\d* Transform\(position.*",
    ],
    "02_gripper": [
        r"opening 8\d\.\d mm",
        r"SUCCEEDED after .* s: (39|40)\.\d mm, finger_joint .* rad",
        r"SUCCEEDED after .* s: (9|10)\.\d mm, finger_joint .* rad",
        r"SUCCEEDED after .* s: 8[45]\.\d mm, finger_joint .* rad",
        r"holding_inside: 4[45]\.\d mm wide, gOBJ 2",
        r"at_target: open [01]\.\d mm, gOBJ 3",
    ],
    "03_own_controllers": [
        r"gripper_controller +running +effort_controllers/GripperActionController",
        r"arm_controller +running +effort_controllers/JointTrajectoryController",
        r"(Goal|Gripper)Result\(status=SUCCEEDED, .*",
        r"GripperResult\(status=SUCCEEDED, .* reached_goal=True, .*\)",
    ],
    "04_own_robot": [
        *(
            rf"{side}_{part} (GoalStatus\.)?SUCCEEDED"
            for part in ("arm", "gripper")
            for side in ("left", "right")
        ),
        r"left tool seen from the right one: Transform\(.*",
    ],
    "05_trajectories": [
        f"there and back: {SUCCEEDED}",
        r"too strict: GoalResult\(status=ABORTED, error_code=-4, "
        r"error_string='shoulder_pan_joint path error .*",
        r"replaced at .* rad: GoalResult\(status=PREEMPTED, .*",
        f"the new one: {SUCCEEDED}",
        r"cancelled: GoalResult\(status=PREEMPTED, .*, speed now 0\.00\d\d rad/s",
        r"rejected: -1 .* 5 positions for 6 joints\.",
    ],
    "06_time": [
        r"paused at 0\.5\d\d s, the goal is ACTIVE",
        "stopped: PREEMPTED",
        r"refused: the emergency stop is engaged; .*",
        r"reset: 0\.0 s, elbow 1\.0 rad",
        rf"{SUCCEEDED} after 1\.\d simulated seconds",
    ],
    "07_scene": [
        "around it: table, red cube, .*",
        r"the gripper stands at (4\d|3\d) mm",
        r"the red cube is lifted to 0\.[23]\d m",
        r"the blue cube is still at .* m",
        r"the die came to lie at 0\.0\d m",
        r"after a reset the red cube lies at 0\.00 m",
    ],
    "08_panel": [
        r"connected to tool0 .*",
        *("accepted 1", "accepted 2"),
        r"t = .* s: the elbow is there",
    ],
    "09_gazebo": [r"never more than \d+\.\d\d mrad apart|nothing to compare with: .*"],
    "10_ros1": [r"error_code: 0|ROS 1 is not available: .*"],
    "11_check": [
        r"line 4, error: .*'finger_joint'.*",
        r"line 5, error: .*did you mean 'finger_joint'\?",
        r"errors: 2, warnings: 1",
    ],
    "12_camera": [
        r"seen at +([+-]\d\.\d{3} ?){3} m",
        r"its middle: ([+-]\d\.\d{3} ?){3} m",
        r"a video of \d\d+ pictures",
    ],
    "13_move_to": [
        f"there: {SUCCEEDED}",
        f"down: {SUCCEEDED}",
        rf"flipped: {SUCCEEDED} .*",
        "refused: .*",
    ],
    "15_record": [
        r"\d+ samples, 0 missed: \(\d+, 12\)",
        r"largest error: 1\d\.\d mrad, with p = 500: 5\d\.\d mrad",
    ],
    "16_cell": [
        r"robots: left: ur5e \+ 2f85, right: ur3e",
        "cameras: left_wrist, right_wrist, scene",
        r"left_eff_joint_traj_controller (GoalStatus\.)?SUCCEEDED",
        r"right_eff_joint_traj_controller (GoalStatus\.)?SUCCEEDED",
        "left gripper: (29|30|31) mm",
        r"left wrist: [89]\.\d N",
        r"tools apart: \d\.\d\d m",
        "stopped: True",
    ],
    "17_train_reach": [
        r"success before: \d%",
        r"generation 7: mean reward -0\.\d+",
        r"success after: (8\d|9\d|100)%",
    ],
    "18_batch": [
        r"forces on the pads of copy 5: \[(49|50|51)\. (49|50|51)\.\] N",
        "0.05 kg lifted with 25 N 50 N 100 N 200 N",
        "3.00 kg lifted with 100 N 200 N",
        r"shapes: \(16, 12\) \(16, 3\) \(16, 4\)",
        r"times after the reset: \[0\. +2\.5\] s",
    ],
    "19_ros2": [
        r"Goal successfully reached!|ROS 2 is not available: .*",
        *([] if ROS2 is None else [r"elbow_joint: 1\.4"]),
    ],
    "20_ur_rtde": [
        *("moveJ: True", "moveL: True", r"down by 0\.1 m"),
        r"wrist_3 has turned to (0\.99\d|1\.0\d*) rad",
        "reachable: True",
    ],
    "21_urscript": ["Robotmode: RUNNING", "back to within a millimetre: True"],
    "22_ur_pick": [
        "OBJ 2 is an object between the fingers",
        "OBJ 3 is an arrival",
        "in: True",
    ],
    "23_robotiq_socket": [
        "activated, fault 0",
        r"closed: holds something at 13\d",
        "opened: has arrived at [345]",
    ],
    "14_pick": [r"holding_inside, gOBJ 2", r"the cube weighs (9\d|10\d) g, .*"],
    "24_program": [
        r"paused in step \(2,\)",
        "succeeded",
        r"def program_pick\(\):",
    ],
    "25_recording": [
        r"\d+ snapshots, complete: True",
        r"0\.\d\d s: eff_joint_traj_controller: goal succeeded",
        r"1\.\d\d s: gripper_controller: goal succeeded",
        r"largest error of the elbow: 1\d\.\d mrad",
        r"the red cube moved by 0\.\d mm",
    ],
    "26_joint_impedance": [
        r"at rest: 0\.00\d rad off",
        r"pushed: 0\.\d\d rad off, torque mode",
        r"released: 0\.0\d\d rad off",
        "then: stop",
    ],
    "27_cartesian_impedance": [r"at most [1-6]\d mm off the circle"],
    "28_plan_around": [
        "holding_inside",
        r"free: False; '\w+' would be .* mm in 'wall'",
        r"refused: the motion would collide after .* in 'wall'; .*",
        r"\d+ corners, \d\.\d s",
        r"least: \d.* mm, .* and .*",
        SUCCEEDED,
        "in the bin: True",
        SUCCEEDED,
    ],
    "29_own_task": [r"solved in \d\d steps"],
    "30_clone_expert": [
        r"\d{4} actions of the expert",
        r"success: (100|9\d|8\d)% of 50",  # the loop: collect, train, evaluate
    ],
}
"""Example → what some of its lines are, in this order."""
WITHOUT_VIDEO = """
import runpy, sys
sys.modules["av"] = None
runpy.run_path(sys.argv[1], run_name="__main__")
"""


def run(example: Path, folder: Path, *before: str) -> str:
    """Run it elsewhere, with warnings as errors, and return what it printed."""
    environment = {k: v for k, v in os.environ.items() if k != "DISPLAY"}
    warnings = ["-W", "error"]
    if example.stem.endswith("_ros1"):
        environment["ROS_MASTER_URI"] = f"http://127.0.0.1:{free_port()}"
        environment["ROS_HOME"] = environment["ROS_LOG_DIR"] = str(folder.parent)
        warnings = []  # rospy has its own
    with contextlib.ExitStack() as stack:
        if example.stem.endswith("_ros2") and ROS2 is not None:
            environment |= stack.enter_context(Domain()).environment
        done = subprocess.run(
            [sys.executable, *warnings, *before, str(example)],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    said = [line for line in done.stderr.splitlines() if not _LATE.fullmatch(line)]
    assert said == []
    return done.stdout


def test_they_are_numbered_without_a_gap() -> None:
    numbers = [int(path.name.partition("_")[0]) for path in EXAMPLES]
    assert numbers == list(range(1, len(EXAMPLES) + 1))
    assert len(EXAMPLES) >= 6


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_is_short(example: Path, tmp_path: Path) -> None:
    if example.stem.endswith("_camera"):
        require_gl()
    text = example.read_text()
    if "from rtde_" in text:
        require_ur_rtde()
    assert len(text.splitlines()) < 60
    ast.parse(text, feature_version=(3, 10))
    lines = iter(run(example, tmp_path).splitlines())
    for pattern in PRINTED[example.stem]:
        assert any(re.fullmatch(pattern, line) for line in lines), pattern
    assert not list(tmp_path.iterdir())  # it leaves nothing behind


def test_the_video_of_an_example_needs_an_extra_and_says_so(tmp_path: Path) -> None:
    require_gl()
    (camera,) = (path for path in EXAMPLES if path.stem.endswith("_camera"))
    assert "'.[video]'" in (ast.get_docstring(ast.parse(camera.read_text())) or "")
    printed = run(camera, tmp_path, "-c", WITHOUT_VIDEO)
    assert re.search(r"^no video: .*pip install '\.\[video\]'", printed, re.M)
