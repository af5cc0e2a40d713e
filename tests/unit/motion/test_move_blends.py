"""Laws of blends: smooth, within their radius, and the same whenever they are known."""

import numpy as np
import pytest
from arm_rig import ur5
from hypothesis import given, settings
from hypothesis import strategies as st
from moves_rig import HOME, MovesRig

from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.moves import Move, MovePlan
from tool0.motion.planner import MovePlanner

RIG = MovesRig(InverseKinematics(ur5()))
CORNER = np.array([0.12, 0.0, -0.1])


def first_and_second(name: str, radius: float, **options: float) -> list[Move]:
    """Return two moves that meet near CORNER."""
    kinds = {"l": "linear", "p": "process", "s": "servo_circular"}
    moves = []
    for k, kind in enumerate(name):
        xyz = CORNER + np.array([0.0, 0.2 * k, 0.0])
        turn = (0.1 * k, 0.0, -0.2 * k)
        blend = radius if k < len(name) - 1 else 0.0
        if kind == "j":
            target = RIG.planner.plan(HOME, [RIG.tool_move(xyz, turn)]).end
            moves.append(RIG.joint(target - HOME, r=blend, **options))
        elif kind == "c":
            via = RIG.pose(xyz + np.array([0.05, -0.1, 0.0]))
            moves.append(
                Move(
                    kind="circular",
                    via=via,
                    pose=RIG.pose(xyz, turn),
                    r=blend,
                    **({"a": 1.2, "v": 0.25} | options),
                )
            )
        else:
            moves.append(RIG.tool_move(xyz, turn, kind=kinds[kind], r=blend, **options))
    return moves


def blend_times(plan: MovePlan) -> np.ndarray:
    """Return times within the blend of two moves, until it is left."""
    return np.linspace(plan.zones[0], plan.duration, 4001)


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.005, 0.04])
@pytest.mark.parametrize(
    "name", ["jj", "ll", "jl", "lj", "pp", "lp", "ss", "lc", "cl", "pc", "cj"]
)
def test_a_blend_is_smooth_and_stays_within_its_radius(
    name: str, radius: float
) -> None:
    moves = first_and_second(name, radius)
    plan = RIG.plan(*moves)
    RIG.check(plan)
    assert not plan.warnings
    single = RIG.plan(moves[0])
    assert single.zones == plan.zones[:1]  # entered alike, whatever comes next
    waypoint = RIG.tool(single.end[None])[0, :3, 3]
    times = np.linspace(0.0, plan.duration, 8001)
    motion = plan.path.at(times)
    away = np.linalg.norm(RIG.tool(motion.positions)[:, :3, 3] - waypoint, axis=1)
    before = times < plan.zones[0]
    assert away[before].min() > radius - 1e-4
    assert away.min() > 1e-6  # it is not reached, but passed
    inside = away < radius - 1e-6
    assert np.diff(np.flatnonzero(inside)).max() == 1
    speeds = np.abs(motion.velocities[inside]).max(axis=1)
    assert speeds.min() > 0.02  # without a stop
    # Both moves are as planned alone where they are not blended.
    alone = single.path.at(times[before]).positions
    np.testing.assert_allclose(motion.positions[before], alone, atol=1e-9)
    if name[1] in "lps":
        after = times > times[np.flatnonzero(inside)[-1]] + 1e-3
        points = RIG.tool(motion.positions[after])[:, :3, 3]
        end = RIG.tool(plan.end[None])[0, :3, 3]
        line = (end - waypoint) / np.linalg.norm(end - waypoint)
        off = points - waypoint - np.outer((points - waypoint) @ line, line)
        assert np.linalg.norm(off, axis=1).max() < 1e-4


def test_a_blend_of_lines_at_equal_speeds_is_a_parabola() -> None:
    moves = first_and_second("ll", 0.03)
    plan = RIG.plan(*moves)
    times, T, V = RIG.played(plan, 8001)
    W = np.array(moves[0].pose[:3])  # type: ignore[index]
    within = np.linalg.norm(T[:, :3, 3] - W, axis=1) < 0.0299
    accelerations = np.diff(V[within], axis=0) / times[1]
    spread = np.ptp(accelerations, axis=0)
    assert spread.max() < 0.02 * np.abs(accelerations).max()
    u1 = W - RIG.home[:3, 3]
    u2 = np.array(moves[1].pose[:3]) - W  # type: ignore[index]
    change = 0.25 * (u2 / np.linalg.norm(u2) - u1 / np.linalg.norm(u1))
    np.testing.assert_allclose(
        accelerations.mean(axis=0), change / (2 * 0.03 / 0.25), rtol=0.02
    )


def test_movep_keeps_its_speed_in_the_corner() -> None:
    plan = RIG.plan(*first_and_second("pp", 0.04))
    _, _, V = RIG.played(plan, 8001)
    speeds = np.linalg.norm(V, axis=1)
    ramps = int(8000 * 0.25 / 1.2 / plan.duration) + 1
    np.testing.assert_allclose(speeds[ramps:-ramps], 0.25, rtol=2e-3)


def test_overlapping_blends_become_smaller_with_a_warning() -> None:
    moves = [
        RIG.tool_move((0.1, 0.0, -0.1), r=0.06),
        RIG.tool_move((0.1, 0.08, -0.1), r=0.06),
        RIG.tool_move((0.0, 0.08, -0.1)),
    ]
    plan = RIG.plan(*moves)
    RIG.check(plan)
    (warning,) = plan.warnings
    assert "move 2" in str(warning)
    assert "overlap" in str(warning)


def test_turning_back_is_a_blend_too() -> None:
    moves = [
        RIG.tool_move((0.1, 0.0, -0.1), r=0.03),
        RIG.tool_move((0.0, 0.0, 0.0), r=0.03),
        RIG.joint([0.3, 0, 0, 0, 0, 0]),
    ]
    RIG.check(RIG.plan(*moves))


def test_without_a_next_move_it_ends_at_rest_in_time() -> None:
    for name in ("j", "l", "p"):
        move = first_and_second(name + "l", 0.03)[0]
        plan = RIG.plan(move)
        stopped = RIG.plan(
            Move(kind=move.kind, q=move.q, pose=move.pose, a=move.a, v=move.v, r=0.0)
        )
        RIG.check(plan)
        np.testing.assert_allclose(plan.end, stopped.end, atol=1e-9)
        assert plan.zones[0] < plan.duration <= stopped.duration + 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.0, 0.004, 0.05, 0.1])
@pytest.mark.parametrize("name", ["jj", "ll", "jl", "lj", "pp", "cl"])
def test_a_move_that_comes_later_continues_the_motion(name: str, late: float) -> None:
    first, second = first_and_second(name, 0.03)
    plan = RIG.plan(first)
    time = plan.zones[0] + late
    rest = RIG.planner.resume(plan, time, [second])
    assert rest is not None
    start = plan.path.at(np.array([time]))
    np.testing.assert_allclose(rest.path.positions[0], start.positions[0], atol=1e-5)
    np.testing.assert_allclose(rest.path.velocities[0], start.velocities[0], atol=1e-3)
    RIG.check(rest)
    together = RIG.plan(first, second)
    np.testing.assert_allclose(rest.end, together.end, atol=1e-9)
    if late == 0.0:  # nothing is lost
        assert time + rest.duration == pytest.approx(together.duration, abs=1e-9)
        x = np.linspace(0.0, rest.duration, 101)
        np.testing.assert_allclose(
            rest.path.at(x).positions, together.path.at(time + x).positions, atol=1e-9
        )
    else:
        assert time + rest.duration >= together.duration - 1e-6


def test_too_late_or_too_early_to_blend() -> None:
    first, second = first_and_second("ll", 0.03)
    plan = RIG.plan(first)
    assert RIG.planner.resume(plan, plan.duration, [second]) is None
    assert RIG.planner.resume(plan, plan.duration - 1e-7, [second]) is None
    assert RIG.planner.resume(RIG.plan(second), 0.1, [first]) is None
    with pytest.raises(ControlError, match="can be left from"):
        RIG.planner.resume(plan, plan.zones[0] - 0.1, [second])


def test_another_tool_is_blended_by_the_joints() -> None:
    first, second = first_and_second("ll", 0.03)
    plan = RIG.plan(first)
    bare = MovePlanner(RIG.kinematics)
    rest = bare.resume(plan, plan.zones[0], [second])
    assert rest is not None
    RIG.check(rest)


def test_which_move_is_executed() -> None:
    plan = RIG.plan(*first_and_second("jlp", 0.03))
    middle = [(a + b) / 2 for a, b in zip(plan.begins, plan.zones, strict=True)]
    assert [plan.move_at(time) for time in middle] == [0, 1, 2]
    assert plan.move_at(plan.duration) == 2


POINTS = st.tuples(st.floats(-0.1, 0.2), st.floats(-0.2, 0.3), st.floats(-0.2, 0.15))
TURNS = st.tuples(*[st.floats(-0.4, 0.4)] * 3)


@st.composite
def random_moves(draw: st.DrawFn) -> list[Move]:
    moves = []
    for _ in range(draw(st.integers(1, 4))):
        kind = draw(st.sampled_from(["j", "linear", "process", "c"]))
        options = {
            "r": draw(st.sampled_from([0.0, 0.01, 0.05, 0.2])),
            "a": draw(st.floats(0.3, 4.0)),
            "v": draw(st.floats(0.05, 1.5)),
        }
        if kind == "j":
            change = draw(st.tuples(*[st.floats(-0.5, 0.5)] * 6))
            moves.append(RIG.joint(change, **options))
        elif kind == "c":
            via, end = RIG.pose(draw(POINTS)), RIG.pose(draw(POINTS), draw(TURNS))
            moves.append(Move(kind="circular", via=via, pose=end, mode=0, **options))
        else:
            moves.append(RIG.tool_move(draw(POINTS), draw(TURNS), kind, **options))
    return moves


@pytest.mark.slow
@settings(max_examples=40, deadline=None, derandomize=True)
@given(random_moves())
def test_any_sequence_is_smooth_or_refused(moves: list[Move]) -> None:
    try:
        plan = RIG.plan(*moves)
    except UnreachableError:
        return
    RIG.check(plan)


@pytest.mark.slow
@settings(max_examples=30, deadline=None, derandomize=True)
@given(random_moves(), st.floats(0.0, 0.2))
def test_any_sequence_that_comes_move_by_move_is_smooth(
    moves: list[Move], late: float
) -> None:
    plan = RIG.planner.plan(HOME, [])
    for move in moves:
        try:
            rest = None
            if plan.tail is not None:
                time = plan.tail.entry + late
                rest = RIG.planner.resume(plan, time, [move])
            if rest is None:
                rest = RIG.planner.plan(plan.end, [move])
            else:
                old = plan.path.at(np.array([time]))
                np.testing.assert_allclose(
                    rest.path.positions[0], old.positions[0], atol=1e-4
                )
                np.testing.assert_allclose(
                    rest.path.velocities[0], old.velocities[0], atol=5e-3
                )
        except UnreachableError:
            return
        RIG.check(rest)
        plan = rest
