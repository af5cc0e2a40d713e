"""Laws of the inverse kinematics: it undoes the forward one, and finds all there is."""

from pathlib import Path

import numpy as np
import pytest
from arm_rig import calibration, old_model, only_chain, ur5

from tool0.description.posture import Branch
from tool0.description.transform import Pose, pose_matrix
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import ArmChain, Array
from tool0.kinematics.geometry import ArmGeometry, wrapped
from tool0.kinematics.inverse import InverseKinematics

N_POSES = 200
HOME = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])
USUAL = Branch(shoulder="left", elbow="up", wrist="no_flip")


@pytest.fixture(scope="module")
def arm() -> InverseKinematics:
    return InverseKinematics(ur5())


def reached(chain: ArmChain, q: object) -> Array:
    return chain.forward(np.array(q, dtype=float).reshape(-1, 6)).T_base_tip


def check_all_branches(arm: InverseKinematics, seed: int, n: int = N_POSES) -> None:
    """Solve for random poses; the elbow stays within its limits of half a turn."""
    counts = []
    for q in np.random.default_rng(seed).uniform(-np.pi, np.pi, (n, 6)):
        T = reached(arm.chain, q)[0]
        found = arm.solutions(T, q)
        positions = np.array([list(item.positions.values()) for item in found])
        poses = reached(arm.chain, positions)
        np.testing.assert_allclose(poses, np.broadcast_to(T, poses.shape), atol=2e-9)
        np.testing.assert_allclose(positions[0], q, atol=1e-6)
        assert arm.branch(q) == found[0].branch
        assert len({item.branch for item in found}) == len(found)
        assert sorted(item.distance for item in found) == [i.distance for i in found]
        counts.append(len(found))
    assert max(counts) == 8
    assert counts.count(8) > n // 2


def test_every_branch_of_random_poses_is_found(arm: InverseKinematics) -> None:
    check_all_branches(arm, seed=0)


@pytest.mark.slow
def test_a_calibrated_arm_is_solved_by_its_own_lengths(tmp_path: Path) -> None:
    chain = ur5(kinematics_params=calibration(tmp_path))
    q = HOME[None]
    apart = reached(chain, q)[0, :3, 3] - reached(ur5(), q)[0, :3, 3]
    assert np.linalg.norm(apart) > 1e-3  # else this would test nothing
    arm = InverseKinematics(chain)
    check_all_branches(arm, seed=1)
    for q in np.random.default_rng(2).uniform(-np.pi, np.pi, (N_POSES, 6)):
        if min(abs(float(sign[0])) for sign in arm.geometry.signs(q[None])) > 0.1:
            found = arm.solutions(reached(chain, q)[0], HOME)  # from elsewhere, too
            away = [np.array(list(item.positions.values())) - q for item in found]
            assert np.abs(wrapped(np.array(away))).max(axis=1).min() < 1e-6


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
@pytest.mark.parametrize("elbow", ["0 1 0", "0 -1 0"])
def test_other_conventions_of_the_same_arm(
    kind: str, elbow: str, tmp_path: Path
) -> None:
    model = old_model(tmp_path, kind=kind, elbow=elbow)
    check_all_branches(InverseKinematics(only_chain(model)), seed=2, n=50)


def test_an_arm_of_another_build_is_refused(tmp_path: Path) -> None:
    chain = only_chain(old_model(tmp_path, elbow="1 0 0"))
    with pytest.raises(ControlError) as caught:
        InverseKinematics(chain)
    assert "'tool0'" in str(caught.value)


SINGULAR = {
    "upright": [0, -np.pi / 2, 0, -np.pi / 2, 0, 0],
    "zero": [0, 0, 0, 0, 0, 0],
    "wrist": [0.3, -1.2, 1.1, -0.7, 0, 0.4],
    "wrist turned": [0.3, -1.2, 1.1, -0.7, np.pi, 0.4],
    "elbow": [0.3, -1.2, 0, -0.7, 1.1, 0.4],
    "wrist and elbow": [0.3, -1.2, 0, -0.7, 0, 0.4],
    "shoulder": [0.3, -1.9, 1.4, 0.0, 1.1, 0.4],
}


@pytest.mark.parametrize("q", SINGULAR.values(), ids=SINGULAR.keys())
@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9, 1e-7, 1e-5])
def test_where_branches_meet_the_present_posture_is_a_solution(
    q: list[float], off: float, arm: InverseKinematics
) -> None:
    present = np.array(q, dtype=float) + off * np.array([1, -1, 0.5, 2, -0.7, 1])
    if q is SINGULAR["shoulder"]:  # the wrist's centre over the axis of the base
        for _ in range(20):
            h, (now, _, _) = 1e-6, arm.geometry.signs(present[None])
            moved = present + h * np.eye(6)[3]
            slope = (arm.geometry.signs(moved[None]).shoulder - now) / h
            present[3] -= float(((now - off) / slope)[0])
    T = reached(arm.chain, present)[0]
    found = arm.solutions(T, present)
    positions = np.array([list(item.positions.values()) for item in found])
    assert np.isfinite(positions).all()
    poses = reached(arm.chain, positions)
    np.testing.assert_allclose(poses, np.broadcast_to(T, poses.shape), atol=2e-9)
    np.testing.assert_allclose(positions[0], present, atol=1e-4)


def test_a_branch_is_taken_as_asked(arm: InverseKinematics) -> None:
    T = reached(arm.chain, HOME)[0]
    assert arm.branch(HOME) == USUAL
    every = arm.solutions(T, HOME)
    for item in every:
        assert arm.solutions(T, HOME, item.branch) == (item,)
    down = arm.solutions(T, HOME, Branch(elbow="down"))
    assert down == tuple(item for item in every if item.branch.elbow == "down")
    assert len(down) == len(every) // 2


def test_branches_are_as_the_words_say(arm: InverseKinematics) -> None:
    """Look at the links: where the elbow is, and on which side the upper arm."""
    T = reached(arm.chain, HOME)[0]
    for item in arm.solutions(T, HOME):
        q = np.array(list(item.positions.values()))
        _, axes, points = (values[0] for values in arm.chain.forward(q[None]))
        shoulder, elbow, wrist = points[1], points[2], points[3]
        to_wrist = wrist - shoulder
        share = (elbow - shoulder) @ to_wrist / (to_wrist @ to_wrist)
        is_up = elbow[2] > (shoulder + share * to_wrist)[2]
        assert is_up == (item.branch.elbow == "up")
        # The upper arm is beside the base along the second axis.
        ahead = points[5] - points[0]
        left = np.cross([0.0, 0.0, 1.0], ahead)
        assert (axes[1] @ left > 0) == (item.branch.shoulder == "left")
        assert (np.sin(q[4]) < 0) == (item.branch.wrist == "no_flip")


def test_a_branch_out_of_reach_tells_those_that_reach(arm: InverseKinematics) -> None:
    rng = np.random.default_rng(3)
    for q in rng.uniform(-np.pi, np.pi, (100, 6)):
        T = reached(arm.chain, q)[0]
        found = {item.branch.wrist for item in arm.solutions(T, q)}
        if found == {"flip"}:
            with pytest.raises(UnreachableError) as caught:
                arm.solutions(T, q, Branch(wrist="no_flip"))
            assert "flip" in str(caught.value)
            return
    pytest.fail("every pose had both")


def test_joints_make_the_turns_that_bring_them_nearest(arm: InverseKinematics) -> None:
    q = np.array([3.0, -1.2, 1.1, -3.0, 1.1, -3.1])
    T = reached(arm.chain, q)[0]
    for turns in ([-1, 0, 0, 1, 0, 1], [0, 0, 0, 1, -1, 0], [-1, 1, 0, 0, 0, 1]):
        near = q + 2 * np.pi * np.array(turns)
        found = arm.solutions(T, near)[0]
        np.testing.assert_allclose(list(found.positions.values()), near, atol=1e-9)
    far = arm.solutions(T, q + 20 * np.pi)
    limit = 2 * np.pi + 1e-9
    for item in far:
        assert all(abs(value) <= limit for value in item.positions.values())


@pytest.mark.parametrize(
    ("xyz", "bound"),
    [((2.0, 0.0, 0.0), "0.912 m"), ((0.0, 0.0, 0.4), "0.109 m")],
)
def test_out_of_reach_says_how_far(
    xyz: tuple[float, float, float], bound: str, arm: InverseKinematics
) -> None:
    with pytest.raises(UnreachableError) as caught:
        arm.solutions(pose_matrix(Pose(xyz=xyz, rpy=(3.14159, 0.0, 0.0))), HOME)
    assert bound in str(caught.value)


def test_limits_in_the_way_are_named(tmp_path: Path) -> None:
    chain = only_chain(old_model(tmp_path, lower="2.9"))
    q = np.array([3.0, 4.0, 5.0, 5.5, 4.5, 6.0])
    T = reached(chain, q)[0]
    arm = InverseKinematics(chain)
    found = arm.solutions(T, q)[0].positions
    np.testing.assert_allclose(list(found.values()), q, atol=1e-9)
    with pytest.raises(UnreachableError) as caught:
        arm.solutions(T @ pose_matrix(Pose(rpy=(0.0, 0.0, 1.3))), q)
    assert "[2.900" in str(caught.value)


def test_a_branch_has_no_other_names(arm: InverseKinematics) -> None:
    with pytest.raises(ControlError):
        arm.solutions(np.eye(4), np.zeros(6), "up")  # type: ignore[arg-type]
    with pytest.raises(ControlError) as caught:
        Branch(elbow="left")  # type: ignore[arg-type]
    assert "'up' or 'down'" in str(caught.value)
    assert str(USUAL) == "left, up, no_flip"


def test_many_poses_are_solved_as_one_is() -> None:
    chain = ur5()
    geometry = ArmGeometry(chain)
    poses = reached(chain, np.random.default_rng(4).uniform(-3, 3, (50, 6)))
    together = geometry.solve(poses)
    for pose, found in zip(poses, together, strict=True):
        np.testing.assert_array_equal(geometry.solve(pose[None])[0], found)
