"""Laws of straight motions: line and limits are kept, and errors say where."""

import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from arm_rig import calibration, ur5

from tool0.control.spline import Knots, hold
from tool0.description.model import TIME_TO_FULL_SPEED
from tool0.description.transform import Pose, as_matrix
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.line import LinePath
from tool0.motion.linear import plan_line
from tool0.motion.path import Path as JointPath
from tool0.simulation.paths import motion_plan

pytestmark = pytest.mark.slow

HOME = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])
PAD = as_matrix(Pose(xyz=(0.01, 0.0, 0.15), rpy=(0.2, 0.0, 0.3)))
FASTEST = np.pi
STRONGEST = FASTEST / TIME_TO_FULL_SPEED
USUAL = {"speed": 0.25, "acceleration": 1.2, "angular_speed": 1.0}
QUICK = {"speed": 3.0, "acceleration": 30.0, "angular_speed": 20.0}
ENDS = {
    "down": Pose(xyz=(0.0, 0.0, 0.2)),
    "aside": Pose(xyz=(-0.35, 0.1, 0.05), rpy=(0.3, 0.2, -0.5)),
    "turn": Pose(rpy=(0.0, 0.0, 1.5)),
    "far": Pose(xyz=(0.4, 0.0, -0.1), rpy=(0.0, 0.3, 2.0)),
}
"""In the tool's frame at the start."""


@pytest.fixture(scope="module")
def arm() -> InverseKinematics:
    return InverseKinematics(ur5())


def line_to(
    arm: InverseKinematics, end: Pose, start: Array = HOME, tool: Array = PAD
) -> LinePath:
    begin = arm.chain.forward(start[None]).T_base_tip[0] @ tool
    return LinePath(begin, begin @ as_matrix(end))


def planned(
    arm: InverseKinematics,
    end: Pose,
    limits: dict[str, float],
    start: Array = HOME,
    tool: Array = PAD,
) -> tuple[LinePath, JointPath]:
    line = line_to(arm, end, start, tool)
    T_base_end = line.tool(np.ones(1))[0]
    path = plan_line(arm, start, T_base_end, tool, T_root_base=np.eye(4), **limits)
    return line, path


def played(start: Array, path: JointPath, times: Array) -> Array:
    """Return how the joints move as a controller plays it, shape (n, 6, 3)."""
    joints = []
    for q, way in zip(start.tolist(), motion_plan(path), strict=True):
        rest = hold(0.0, q)
        spline = rest.spliced(0.0, 0.0, Knots.of(way), suspects=range(1, len(way)))
        joints.append([spline.sample(time) for time in times.tolist()])
    return np.array(joints).transpose(1, 0, 2)


@pytest.mark.parametrize("limits", [USUAL, QUICK], ids=["usual", "quick"])
@pytest.mark.parametrize("end", ENDS.values(), ids=ENDS.keys())
def test_the_tool_keeps_to_its_line_and_all_to_their_limits(
    end: Pose, limits: dict[str, float], arm: InverseKinematics
) -> None:
    line, path = planned(arm, end, limits)
    times = np.linspace(0.0, path.duration, 1500)
    motion = played(HOME, path, times)
    tool = arm.chain.forward(motion[:, :, 0]).T_base_tip @ PAD
    # Where on the line it is: by its place, or by its turn if it stays.
    start, last = line.tool(np.array([0.0, 1.0]))
    np.testing.assert_allclose(tool[0], start, atol=1e-8)
    np.testing.assert_allclose(tool[-1], last, atol=1e-8)
    if line.length > 0.0:
        way = last[:3, 3] - start[:3, 3]
        s = (tool[:, :3, 3] - start[:3, 3]) @ way / (way @ way)
    else:
        s = np.arccos((np.einsum("nij,ij->n", tool[:, :3, :3], start[:3, :3]) - 1) / 2)
        s /= line.angle
    apart = np.abs(tool - line.tool(s))
    assert apart[:, :3, 3].max() < 1e-6
    assert apart.max() < 1e-5
    # Its speed, and those of the joints.
    speed = np.linalg.norm(np.diff(tool[:, :3, 3], axis=0), axis=1) / times[1]
    assert speed.max() < limits["speed"] * 1.001
    turning = np.abs(np.diff(s)) * line.angle / times[1]
    assert turning.max() < limits["angular_speed"] * 1.001
    assert np.abs(motion[:, :, 1]).max() < FASTEST * 1.001
    assert np.abs(motion[:, :, 2]).max() < STRONGEST * 1.01


def test_a_calibrated_arm_keeps_to_its_line_too(tmp_path: Path) -> None:
    own = InverseKinematics(ur5(kinematics_params=calibration(tmp_path)))
    line, path = planned(own, Pose(xyz=(0.0, 0.2, 0.1)), USUAL)
    tool = own.chain.forward(path.positions).T_base_tip @ PAD
    start, last = line.tool(np.array([0.0, 1.0]))
    way = last[:3, 3] - start[:3, 3]
    s = (tool[:, :3, 3] - start[:3, 3]) @ way / (way @ way)
    np.testing.assert_allclose(tool, line.tool(s), atol=1e-8)


def test_it_ends_at_rest(arm: InverseKinematics) -> None:
    _, path = planned(arm, ENDS["aside"], USUAL)
    assert not path.velocities[-1].any()
    assert (np.diff(path.times) > 0.0).all()


def test_the_speed_is_reached_where_nothing_is_in_the_way(
    arm: InverseKinematics,
) -> None:
    line, path = planned(arm, ENDS["down"], USUAL)
    ramp = USUAL["speed"] / USUAL["acceleration"]
    least = line.length / USUAL["speed"] + ramp
    assert least < path.duration < least + 0.11


def test_a_line_near_a_singularity_is_slower_by_its_joints(
    arm: InverseKinematics,
) -> None:
    durations = []
    for wrist in (-0.1, -0.5):  # at 0 its axes are parallel
        start = np.array([0.0, -1.2, 1.6, -2.0, wrist, 0.3])
        _, path = planned(arm, Pose(xyz=(0.0, 0.0, -0.2)), QUICK, start)
        durations.append(path.duration)
        motion = played(start, path, np.linspace(0, path.duration, 800))
        share = np.abs(motion[:, :, 2]).max() / STRONGEST
        assert 0.45 < share < 1.01
    assert durations[0] > 1.5 * durations[1]


@pytest.mark.parametrize("end", [Pose(xyz=(0.0, -0.9, 0.0)), Pose(xyz=(0.0, 0.0, 1.4))])
def test_a_line_out_of_reach_says_where(end: Pose, arm: InverseKinematics) -> None:
    with pytest.raises(UnreachableError) as caught:
        planned(arm, end, USUAL)
    assert re.search(r" \d+% ", str(caught.value))


@pytest.mark.parametrize("tool", [0.0, 1e4])
@pytest.mark.parametrize("distance", [50.0, 500.0, 1e6])
def test_a_line_far_out_of_reach_takes_no_memory(
    distance: float, tool: float, arm: InverseKinematics
) -> None:
    T_tip_tool = as_matrix(Pose(xyz=(tool, 0.0, 0.0)))
    begin = arm.chain.forward(HOME[None]).T_base_tip[0] @ T_tip_tool
    end = as_matrix(Pose(xyz=(distance, 0, 0))) @ begin
    tracemalloc.start()
    try:
        with pytest.raises(UnreachableError, match="out of reach"):
            plan_line(arm, HOME, end, T_tip_tool, T_root_base=np.eye(4), **USUAL)
        assert tracemalloc.get_traced_memory()[1] < 1e6
    finally:
        tracemalloc.stop()


def test_a_line_of_a_very_long_tool_is_bounded(arm: InverseKinematics) -> None:
    T_tip_tool = as_matrix(Pose(xyz=(1e5, 0.0, 0.0)))
    begin = arm.chain.forward(HOME[None]).T_base_tip[0]
    end = begin @ as_matrix(Pose(rpy=(0.0, 0.0, 0.5))) @ T_tip_tool
    with pytest.raises(UnreachableError, match="too long"):
        plan_line(arm, HOME, end, T_tip_tool, T_root_base=np.eye(4), **USUAL)


@pytest.mark.parametrize("speed", [1e-6, 1e6])
@pytest.mark.parametrize("acceleration", [1e-6, 1e6])
def test_extreme_limits_have_a_timing(
    speed: float, acceleration: float, arm: InverseKinematics
) -> None:
    limits = {"speed": speed, "acceleration": acceleration, "angular_speed": 1.0}
    _, path = planned(arm, Pose(xyz=(0.0, 0.0, 0.05)), limits)
    assert 0 < len(path.times) <= 1000
    assert np.isfinite(path.duration)


def test_a_line_through_a_singularity_says_where(arm: InverseKinematics) -> None:
    start = np.array([0.3, -1.2, 1.6, -0.7, -0.3, 0.3])
    through = start * [1, 1, 1, 1, -1, 1]  # the wrist goes through 0
    end = arm.chain.forward(through[None]).T_base_tip[0]
    with pytest.raises(UnreachableError) as caught:
        plan_line(arm, start, end, np.eye(4), T_root_base=np.eye(4), **USUAL)
    assert re.search(r" \d+% ", str(caught.value))


@pytest.mark.parametrize("q", [[0.0] * 6, [0, -np.pi / 2, 0, -np.pi / 2, 0, 0]])
@pytest.mark.parametrize(
    "way", [Pose(xyz=(0.0, 0.0, -0.1)), Pose(xyz=(0.1, 0.0, 0.0)), Pose(rpy=(0, 1, 0))]
)
def test_no_line_begins_where_the_arm_is_singular(
    q: list[float], way: Pose, arm: InverseKinematics
) -> None:
    with pytest.raises(UnreachableError):
        planned(arm, way, USUAL, np.array(q))


def test_limits_of_joints_are_kept(arm: InverseKinematics) -> None:
    start = HOME + 5.5 * np.eye(6)[5]
    with pytest.raises(UnreachableError) as caught:
        planned(arm, Pose(rpy=(0.0, 0.0, 1.5)), USUAL, start)
    assert "'wrist_3_joint'" in str(caught.value)


def test_no_way_is_refused(arm: InverseKinematics) -> None:
    with pytest.raises(ControlError):
        planned(arm, Pose(), USUAL)


def test_half_a_turn_is_a_line_too() -> None:
    end = as_matrix(Pose(rpy=(0.0, 0.0, np.pi)))
    line = LinePath(np.eye(4), end)
    assert line.angle == pytest.approx(np.pi)
    np.testing.assert_allclose(line.tool(np.array([1.0]))[0], end, atol=1e-9)
