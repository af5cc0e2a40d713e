import math

import numpy as np
import pytest

from tool0.description.catalogue import assemble
from tool0.description.forward_kinematics import link_pose, link_poses
from tool0.description.model import RobotModel
from tool0.description.transform import Pose, Transform, to_transform
from tool0.errors import ModelError

ARM = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
# Denavit-Hartenberg constants of the UR5: CB3 user manual, table C.3 [m, rad].
D = (0.089159, 0, 0, 0.10915, 0.09465, 0.0823)
A = (0, -0.425, -0.39225, 0, 0, 0)
ALPHA = (math.pi / 2, 0, 0, math.pi / 2, -math.pi / 2, 0)


@pytest.fixture(scope="module")
def model() -> RobotModel:
    return assemble().model


def random_transform(rng: np.random.Generator) -> Transform:
    x, y, z, roll, pitch, yaw = rng.uniform(-3, 3, size=6)
    return to_transform(Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw)))


def assert_same(actual: Transform, expected: Transform) -> None:
    np.testing.assert_allclose(actual.matrix, expected.matrix, atol=1e-12)


def test_composition_is_that_of_matrices_and_inverses_undo() -> None:
    rng = np.random.default_rng(seed=0)
    for _ in range(50):
        a, b, c = (random_transform(rng) for _ in range(3))
        np.testing.assert_allclose((a @ b).matrix, a.matrix @ b.matrix, atol=1e-12)
        assert_same((a @ b) @ c, a @ (b @ c))
        assert_same(a @ a.inverse(), Transform())
        assert_same(a.inverse() @ a, Transform())
        np.testing.assert_allclose(
            (*a.apply((1, 2, 3)), 1), a.matrix @ (1, 2, 3, 1), atol=1e-12
        )


def test_quaternions_rotate_as_the_matrix_does() -> None:
    rng = np.random.default_rng(seed=1)
    half_turns = [
        to_transform(Pose(rpy=rpy))
        for rpy in ((math.pi, 0, 0), (0, math.pi, 0), (0, 0, math.pi))
    ]
    for T in [*half_turns, *(random_transform(rng) for _ in range(100))]:
        w, x, y, z = T.quat_wxyz
        assert w >= 0
        assert math.hypot(w, x, y, z) == pytest.approx(1)
        v = np.array((x, y, z))
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        R = (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * cross
        np.testing.assert_allclose(T.rotation, R, atol=1e-9)


def test_the_arm_is_where_its_denavit_hartenberg_constants_say(
    model: RobotModel,
) -> None:
    rng = np.random.default_rng(seed=2)
    for _ in range(50):
        q = rng.uniform(-math.pi, math.pi, size=6)
        expected = np.eye(4)
        for theta, d, a, alpha in zip(q, D, A, ALPHA, strict=True):
            c, s, ca, sa = (f(t) for t in (theta, alpha) for f in (math.cos, math.sin))
            expected = expected @ [
                [c, -s * ca, s * sa, a * c],
                [s, c * ca, -c * sa, a * s],
                [0, sa, ca, d],
                [0, 0, 0, 1],
            ]
        position = dict(zip(ARM, q, strict=True))
        T_base_tool0 = link_pose(model, position, "tool0", relative_to="base")
        np.testing.assert_allclose(T_base_tool0.matrix, expected, atol=1e-9)


def test_poses_between_links_invert_each_other(model: RobotModel) -> None:
    position = dict.fromkeys(ARM, 0.7)
    there = link_pose(model, position, "tool0", relative_to="forearm_link")
    back = link_pose(model, position, "forearm_link", relative_to="tool0")
    assert_same(there @ back, Transform())
    assert_same(link_pose(model, position, "tool0", relative_to="tool0"), Transform())
    assert link_pose(model, position, "tool0") == link_poses(model, position)["tool0"]


@pytest.mark.parametrize("q", [0.0, 0.1, 0.35, 0.6, 0.8, 0.8133])
def test_the_gap_between_the_pads_is_the_gripper_s_opening(
    model: RobotModel, q: float
) -> None:
    (gripper,) = model.grippers
    T_left_right = link_pose(
        model, {"finger_joint": q}, "right_inner_finger_pad", "left_inner_finger_pad"
    )
    x, y, z = T_left_right.position
    gap = abs(y) - 0.00635  # each pad's face is half its thickness from its centre
    assert gap * math.copysign(1, -y) == pytest.approx(gripper.opening(q), abs=1e-9)
    assert (x, z) == pytest.approx((0, 0), abs=1e-12)
    assert abs(T_left_right.quat_wxyz[3]) == pytest.approx(1)  # half round z


def test_a_mimic_joint_follows_unless_it_is_given(model: RobotModel) -> None:
    follows = {"finger_joint": 0.5}
    spelled_out = {
        "finger_joint": 0.5,
        "right_finger_joint": 0.5,
        "left_inner_knuckle_joint": 0.5,
        "right_inner_knuckle_joint": 0.5,
        "left_inner_finger_joint": -0.5,
        "right_inner_finger_joint": -0.5,
    }
    assert link_poses(model, follows) == link_poses(model, spelled_out)
    broken = {**follows, "right_finger_joint": 0.0}
    assert link_poses(model, follows) != link_poses(model, broken)


def test_unknown_names_are_refused(model: RobotModel) -> None:
    with pytest.raises(ModelError, match="'elbow'; did you mean 'elbow_joint'"):
        link_poses(model, {"elbow": 1.0})
    with pytest.raises(ModelError, match="unknown link 'tool1'; did you mean 'tool0'"):
        link_pose(model, {}, "tool1")
    with pytest.raises(ModelError, match="unknown link 'bse'"):
        link_pose(model, {}, "tool0", relative_to="bse")


def test_a_transform_prints_short() -> None:
    T = Transform(position=(1.0, -1e-12, 0.25))
    assert repr(T) == "Transform(position=(1, 0, 0.25), quat_wxyz=(1, 0, 0, 0))"
