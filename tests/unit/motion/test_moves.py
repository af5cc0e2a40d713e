"""Laws of single moves: durations by the formulas, the tool on its path."""

import numpy as np
import pytest
from arm_rig import ur5
from moves_rig import HOME, MovesRig

from tool0.description.catalogue import arms
from tool0.description.loading import assemble
from tool0.description.transform_arrays import rotation_vector
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import find_chains
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.moves import Move


@pytest.fixture(scope="module")
def rig() -> MovesRig:
    return MovesRig(InverseKinematics(ur5()))


def test_movej_turns_all_joints_in_proportion(rig: MovesRig) -> None:
    plan = rig.plan(rig.joint([0.8, 0.4, -0.2, 0.0, 0.1, -0.8], a=1.0, v=0.5))
    path = plan.path
    times, q, qd = path.times, path.positions, path.velocities
    np.testing.assert_allclose(times, [0.0, 0.5, 1.6, 2.1], atol=1e-9)
    np.testing.assert_allclose(qd[1], [0.5, 0.25, -0.125, 0.0, 0.0625, -0.5])
    np.testing.assert_allclose(q[1] - HOME, qd[1] * 0.25, atol=1e-12)
    np.testing.assert_allclose(plan.end - HOME, [0.8, 0.4, -0.2, 0.0, 0.1, -0.8])
    rig.check(plan)


def test_movej_to_a_pose_takes_the_nearest_posture(rig: MovesRig) -> None:
    change = np.array([0.3, 0.2, -0.1, 0.1, 0.2, 0.3])
    T = rig.tool((HOME + change)[None])[0]
    pose = [*T[:3, 3], *rotation_vector(T[:3, :3])]
    plan = rig.plan(Move(kind="joint", pose=pose, a=1.4, v=1.05))
    np.testing.assert_allclose(plan.end, HOME + change, atol=1e-8)


@pytest.mark.parametrize("xyz", [(0.0, 0.5, 0.0), (0.03, 0.0, -0.04), (0, 0, 0.01)])
def test_movel_keeps_the_tool_on_its_line(rig: MovesRig, xyz: tuple[float]) -> None:
    turn = (0.1, -0.2, 0.05)
    plan = rig.plan(rig.tool_move(xyz, turn))
    _, T, V = rig.played(plan)
    length = float(np.linalg.norm(xyz))
    direction = np.array(xyz) / length
    away = T[:, :3, 3] - rig.home[:3, 3]
    off = away - np.outer(away @ direction, direction)
    assert np.linalg.norm(off, axis=1).max() < 1e-4
    pace = max(length, np.linalg.norm(turn) / 4.0)
    ramped = pace > 0.25**2 / 1.2
    expected = pace / 0.25 + 0.25 / 1.2 if ramped else 2 * np.sqrt(pace / 1.2)
    assert plan.duration == pytest.approx(expected, abs=1e-9)
    if ramped:
        top = 0.25 * length / pace
        assert np.linalg.norm(V, axis=1).max() == pytest.approx(top, rel=1e-3)
    # The turn goes along with the displacement.
    part = (away @ direction) / length
    for k in (500, 1000, 1500):
        turned = rotation_vector(T[k, :3, :3] @ rig.home[:3, :3].T)
        np.testing.assert_allclose(turned, part[k] * np.array(turn), atol=1e-3)
    rig.check(plan)


def test_a_turn_in_place_is_four_times_as_fast_in_radians(rig: MovesRig) -> None:
    plan = rig.plan(rig.tool_move((0, 0, 0), (0.0, 0.0, 1.0), v=0.1, a=0.5))
    assert plan.duration == pytest.approx(1.0 / 0.4 + 0.1 / 0.5, abs=1e-6)
    _, T, _ = rig.played(plan)
    assert np.linalg.norm(T[:, :3, 3] - rig.home[:3, 3], axis=1).max() < 1e-4


@pytest.mark.parametrize("mode", [0, 1])
def test_movec_stays_on_its_circle(rig: MovesRig, mode: int) -> None:
    via, end = rig.pose((0.1, 0.1, 0.0)), rig.pose((0.0, 0.2, 0.0), (0.0, 0.0, 0.3))
    move = Move(kind="circular", via=via, pose=end, a=1.2, v=0.2, mode=mode)
    plan = rig.plan(move)
    _, T, V = rig.played(plan)
    centre = rig.home[:3, 3] + [0.0, 0.1, 0.0]
    away = T[:, :3, 3] - centre
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 0.1, atol=1e-4)
    assert np.abs(away[:, 2]).max() < 1e-4
    assert away[:, 0].max() == pytest.approx(0.1, abs=1e-4)
    length = np.pi * 0.1
    assert plan.duration == pytest.approx(length / 0.2 + 0.2 / 1.2, abs=1e-9)
    assert np.linalg.norm(V, axis=1).max() == pytest.approx(0.2, rel=1e-3)
    turned = rotation_vector(T[-1, :3, :3] @ rig.home[:3, :3].T)
    expected = [0.0, 0.0, 0.3] if mode == 0 else [0.0, 0.0, np.pi]
    np.testing.assert_allclose(np.abs(turned), expected, atol=1e-4)
    rig.check(plan)


@pytest.mark.parametrize("rests", [1, 2])
def test_a_time_replaces_speed_and_acceleration(rig: MovesRig, rests: int) -> None:
    radius = 0.0 if rests == 2 else 0.03
    for move in (
        rig.joint([0.4, 0, 0, 0, 0, 0], t=1.5, r=radius, a=0.0, v=0.0),
        rig.tool_move((0.1, 0.2, 0.0), t=1.5, r=radius, a=0.0, v=0.0),
    ):
        plan = rig.plan(move)
        if rests == 2:
            assert plan.duration == pytest.approx(1.5, abs=1e-9)
        else:
            assert plan.zones[0] < 1.5 < plan.duration + 0.1
        rig.check(plan)


def test_too_fast_a_move_becomes_slower_and_says_so(rig: MovesRig) -> None:
    plan = rig.plan(rig.joint([0.8, 0, 0, 0, 0, 0], a=40.0, v=10.0))
    fastest = rig.kinematics.fastest[0]
    assert np.abs(plan.path.velocities).max() == pytest.approx(fastest, rel=2e-3)
    plan = rig.plan(rig.tool_move((0.1, 0.3, 0.0), a=10.0, v=3.0))
    rig.check(plan)
    (warning,) = plan.warnings
    assert "move 1 (movel)" in str(warning)
    assert "instead of 3" in str(warning)


def test_nothing_to_do_takes_no_time(rig: MovesRig) -> None:
    plan = rig.plan(rig.joint([0.0] * 6), rig.tool_move((0.0, 0.0, 0.0)))
    assert plan.duration == 0.0
    assert plan.begins == plan.zones == (0.0, 0.0)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("far", ("move 2 (movel)", "out of reach")),
        ("through the base", ("move 2 (movel)", "the tool is at")),
        ("limits", ("move 2 (movej)", "'shoulder_pan_joint'", "7.0000")),
        ("straight arc", ("move 2 (movec)", "on a line")),
    ],
)
def test_errors_name_the_move_and_the_reason(
    rig: MovesRig, name: str, words: tuple[str, ...]
) -> None:
    first = rig.joint([0.1, 0, 0, 0, 0, 0])
    moves = {
        "far": [first, rig.tool_move((-1.0, 0.0, 0.0))],
        "through the base": [first, rig.tool_move((0.9, 0.22, 0.0))],
        "limits": [first, rig.joint([7.0, 0, 0, 0, 0, 0])],
        "straight arc": [
            rig.tool_move((0.0, 0.0, 0.05)),
            Move(
                kind="circular",
                via=rig.pose((0.0, 0.0, 0.1)),
                pose=rig.pose((0.0, 0.0, 0.15)),
                a=1.2,
                v=0.25,
            ),
        ],
    }[name]
    with pytest.raises(UnreachableError) as caught:
        rig.plan(*moves)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    "start",
    [(0.0, -0.8, 0.0, -1.2, -1.2, 0.0), (0.2, -1.2, 1.3, -1.0, 1e-3, 0.0)],
    ids=["elbow", "wrist"],
)
def test_singular_starts_are_refused(rig: MovesRig, start: tuple[float, ...]) -> None:
    stretched = MovesRig(rig.kinematics, np.array(start))
    with pytest.raises(UnreachableError, match=r"move 1 \(movel\).*singular"):
        stretched.plan(stretched.tool_move((0.1, 0.0, -0.05), (0.0, 0.3, 0.0)))


def test_a_move_is_checked_when_it_is_made() -> None:
    for wrong in (
        {"kind": "joint", "a": 1.0, "v": 1.0},
        {"kind": "joint", "q": [0.0] * 6, "a": 0.0, "v": 1.0},
        {"kind": "joint", "q": [0.0] * 5, "a": 1.0, "v": 1.0},
        {"kind": "joint", "q": [float("nan")] * 6, "a": 1.0, "v": 1.0},
        {"kind": "linear", "q": [0.0] * 6, "a": 1.0, "v": 1.0, "r": -0.1},
        {"kind": "circular", "pose": [0.0] * 6, "a": 1.0, "v": 1.0},
        {"kind": "linear", "pose": [0.0] * 6, "a": 1.0, "v": 1.0, "w": 0.0},
        {"kind": "linear", "pose": [0.0] * 6, "a": 1.0, "v": 1.0, "w": float("nan")},
    ):
        with pytest.raises(ControlError):
            Move(**wrong)


@pytest.mark.slow
@pytest.mark.parametrize("name", arms())
def test_every_arm_of_the_catalogue_moves(name: str) -> None:
    (chain,) = find_chains(assemble(name, gripper=None).model).values()
    rig = MovesRig(InverseKinematics(chain))
    reach = rig.kinematics.geometry.reach
    plan = rig.plan(
        rig.joint([0.4, 0.1, 0.1, 0, 0.1, 0.3], r=0.05 * reach),
        rig.tool_move((0.15 * reach, 0.2 * reach, -0.1 * reach), r=0.05 * reach),
        rig.tool_move((0.15 * reach, 0.0, -0.1 * reach), (0.2, 0.0, 0.1)),
    )
    rig.check(plan)
    assert not plan.warnings
