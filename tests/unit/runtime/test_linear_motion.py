"""Laws of straight motions: line and limits are kept, and errors say where."""

import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from arm_rig import calibration, ur5

from tool0.control.spline import Knots, Motion, hold
from tool0.description.model import TIME_TO_FULL_SPEED
from tool0.description.transform import Pose, as_matrix
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.kinematics.line import LinePath
from tool0.protocol.trajectories import TrajectoryPoint
from tool0.runtime.linear_motion import PERIOD, LinearLimits, LinearMotion

pytestmark = pytest.mark.slow

HOME = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])
PAD = as_matrix(Pose(xyz=(0.01, 0.0, 0.15), rpy=(0.2, 0.0, 0.3)))
FASTEST = np.pi
STRONGEST = FASTEST / TIME_TO_FULL_SPEED
USUAL = LinearLimits(speed=0.25, acceleration=1.2, angular_speed=1.0)
QUICK = LinearLimits(speed=3.0, acceleration=30.0, angular_speed=20.0)
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


def planned(
    arm: InverseKinematics, end: Pose, limits: LinearLimits, start: Array = HOME
) -> tuple[LinePath, list[TrajectoryPoint]]:
    begin = arm.chain.forward(start[None]).T_base_tip[0] @ PAD
    line = LinePath(begin, begin @ as_matrix(end), PAD)
    return line, LinearMotion(arm, line, start, limits, [STRONGEST] * 6).points()


def played(start: Array, points: list[TrajectoryPoint], times: Array) -> Array:
    """Return how the joints move as a controller plays it, shape (n, 6, 3)."""
    joints = []
    for k in range(6):
        way = [
            (
                point.time_from_start,
                Motion(
                    point.positions[k],
                    (point.velocities or ())[k],
                    (point.accelerations or ())[k],
                ),
            )
            for point in points
        ]
        rest = hold(0.0, float(start[k]))
        spline = rest.spliced(0.0, 0.0, Knots.of(way), suspects=range(1, len(way)))
        joints.append([spline.sample(time) for time in times.tolist()])
    return np.array(joints).transpose(1, 0, 2)


@pytest.mark.parametrize("limits", [USUAL, QUICK], ids=["usual", "quick"])
@pytest.mark.parametrize("end", ENDS.values(), ids=ENDS.keys())
def test_the_tool_keeps_to_its_line_and_all_to_their_limits(
    end: Pose, limits: LinearLimits, arm: InverseKinematics
) -> None:
    line, points = planned(arm, end, limits)
    duration = points[-1].time_from_start
    times = np.linspace(0.0, duration, 1500)
    motion = played(HOME, points, times)
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
    assert speed.max() < limits.speed * 1.001
    turning = np.abs(np.diff(s)) * line.angle / times[1]
    assert turning.max() < limits.angular_speed * 1.001
    assert np.abs(motion[:, :, 1]).max() < FASTEST * 1.001
    assert np.abs(motion[:, :, 2]).max() < STRONGEST * 1.01


def test_a_calibrated_arm_keeps_to_its_line_too(tmp_path: Path) -> None:
    own = InverseKinematics(ur5(kinematics_params=calibration(tmp_path)))
    line, points = planned(own, Pose(xyz=(0.0, 0.2, 0.1)), USUAL)
    tool = own.chain.forward(np.array([p.positions for p in points])).T_base_tip @ PAD
    start, last = line.tool(np.array([0.0, 1.0]))
    way = last[:3, 3] - start[:3, 3]
    s = (tool[:, :3, 3] - start[:3, 3]) @ way / (way @ way)
    np.testing.assert_allclose(tool, line.tool(s), atol=1e-8)


def test_points_lie_close_and_end_at_rest(arm: InverseKinematics) -> None:
    _, points = planned(arm, ENDS["aside"], USUAL)
    times = [0.0, *(point.time_from_start for point in points)]
    assert np.diff(times).max() <= PERIOD * 1.0001
    assert points[-1].velocities == points[-1].accelerations == (0.0,) * 6


def test_the_speed_is_reached_where_nothing_is_in_the_way(
    arm: InverseKinematics,
) -> None:
    line, points = planned(arm, ENDS["down"], USUAL)
    ramp = USUAL.speed / USUAL.acceleration
    least = line.length / USUAL.speed + ramp
    assert least < points[-1].time_from_start < least + 0.11


def test_a_line_near_a_singularity_is_slower_by_its_joints(
    arm: InverseKinematics,
) -> None:
    durations = []
    for wrist in (-0.1, -0.5):  # at 0 its axes are parallel
        start = np.array([0.0, -1.2, 1.6, -2.0, wrist, 0.3])
        _, points = planned(arm, Pose(xyz=(0.0, 0.0, -0.2)), QUICK, start)
        durations.append(points[-1].time_from_start)
        motion = played(start, points, np.linspace(0, durations[-1], 800))
        share = np.abs(motion[:, :, 2]).max() / (STRONGEST)
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
    begin = arm.chain.forward(HOME[None]).T_base_tip[0]
    T_tip_tool = as_matrix(Pose(xyz=(tool, 0.0, 0.0)))
    start = begin @ T_tip_tool
    line = LinePath(start, as_matrix(Pose(xyz=(distance, 0, 0))) @ start, T_tip_tool)
    tracemalloc.start()
    try:
        with pytest.raises(UnreachableError, match="out of reach"):
            LinearMotion(arm, line, HOME, USUAL, [STRONGEST] * 6)
        assert tracemalloc.get_traced_memory()[1] < 1e6
    finally:
        tracemalloc.stop()


def test_a_line_of_a_very_long_tool_is_bounded(arm: InverseKinematics) -> None:
    begin = arm.chain.forward(HOME[None]).T_base_tip[0]
    T_tip_tool = as_matrix(Pose(xyz=(1e5, 0.0, 0.0)))
    end = begin @ as_matrix(Pose(rpy=(0.0, 0.0, 0.5))) @ T_tip_tool
    line = LinePath(begin @ T_tip_tool, end, T_tip_tool)
    with pytest.raises(UnreachableError, match="too long"):
        LinearMotion(arm, line, HOME, USUAL, [STRONGEST] * 6)


@pytest.mark.parametrize("speed", [1e-6, 1e6])
@pytest.mark.parametrize("acceleration", [1e-6, 1e6])
def test_extreme_limits_have_a_timing(
    speed: float, acceleration: float, arm: InverseKinematics
) -> None:
    limits = LinearLimits(speed=speed, acceleration=acceleration, angular_speed=1.0)
    _, points = planned(arm, Pose(xyz=(0.0, 0.0, 0.05)), limits)
    assert 0 < len(points) <= 1000
    assert np.isfinite(points[-1].time_from_start)


def test_a_line_through_a_singularity_says_where(arm: InverseKinematics) -> None:
    start = np.array([0.3, -1.2, 1.6, -0.7, -0.3, 0.3])
    begin = arm.chain.forward(start[None]).T_base_tip[0]
    through = start * [1, 1, 1, 1, -1, 1]  # the wrist goes through 0
    end = arm.chain.forward(through[None]).T_base_tip[0]
    line = LinePath(begin, end, np.eye(4))
    with pytest.raises(UnreachableError) as caught:
        LinearMotion(arm, line, start, USUAL, [STRONGEST] * 6)
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


@pytest.mark.parametrize("name", ["speed", "acceleration", "angular_speed"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_limits_are_above_zero(name: str, value: float) -> None:
    values = {"speed": 0.1, "acceleration": 1.0, "angular_speed": 1.0, name: value}
    with pytest.raises(ControlError) as caught:
        LinearLimits(**values)
    assert name in str(caught.value)
