"""Poses and velocities of links: laws, and what is known of the UR5 and 2F-85."""

import math
from collections.abc import Mapping

import numpy as np
import pytest

from tool0.description.forward_kinematics import (
    FrameMotion,
    joint_positions,
    link_motions,
    link_pose,
    link_poses,
)
from tool0.description.loading import assemble
from tool0.description.model import Joint, JointType, Link, Mimic, RobotModel
from tool0.description.transform import Pose, Transform, to_transform
from tool0.errors import LimitsError, ModelError

H = 1e-6  # [s]; central differences err by O(h^2)

ARM = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)


@pytest.fixture(scope="module")
def model() -> RobotModel:
    return assemble().model


def random_transform(rng: np.random.Generator) -> Transform:
    x, y, z, roll, pitch, yaw = rng.uniform(-3, 3, size=6)
    return to_transform(Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw)))


def assert_same(actual: Transform, expected: Transform) -> None:
    np.testing.assert_allclose(actual.matrix, expected.matrix, atol=1e-12)


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


def test_unknown_names_are_refused_with_the_nearest(model: RobotModel) -> None:
    with pytest.raises(ModelError) as joint:
        link_poses(model, {"elbow": 1.0})
    with pytest.raises(ModelError) as link:
        link_pose(model, {}, "tool1")
    assert "'elbow_joint'" in str(joint.value)
    assert "'tool0'" in str(link.value)
    with pytest.raises(ModelError):
        link_pose(model, {}, "tool0", relative_to="bse")


def random_motion(rng: np.random.Generator) -> FrameMotion:
    linear, angular = rng.uniform(-2, 2, size=(2, 3))
    return FrameMotion(
        pose=random_transform(rng), linear=tuple(linear), angular=tuple(angular)
    )


def after(motion: FrameMotion, duration: float) -> np.ndarray:
    """Return where the frame is a little later, shape (4, 4), to first order."""
    x, y, z = np.multiply(motion.angular, duration)
    turn = np.eye(3) + np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    later = np.eye(4)
    later[:3, :3] = turn @ motion.pose.rotation
    later[:3, 3] = motion.pose.position + np.multiply(motion.linear, duration)
    return later


def assert_moves_as(motion: FrameMotion, before: np.ndarray, later: np.ndarray) -> None:
    """Compare with the poses ``H`` before and after."""
    rate = (later - before) / (2 * H)
    np.testing.assert_allclose(motion.linear, rate[:3, 3], atol=1e-7)
    spin = rate[:3, :3] @ np.transpose(motion.pose.rotation)
    np.testing.assert_allclose(
        motion.angular, (spin[2, 1], spin[0, 2], spin[1, 0]), atol=1e-7
    )


def assert_is_derivative(
    model: RobotModel, position: Mapping[str, float], velocity: Mapping[str, float]
) -> None:
    def poses(time: float) -> dict[str, Transform]:
        return link_poses(
            model, {name: q + velocity[name] * time for name, q in position.items()}
        )

    now, before, later = poses(0.0), poses(-H), poses(H)
    motions = link_motions(model, position, velocity)
    assert motions.keys() == now.keys()
    for link, motion in motions.items():
        assert motion.pose == now[link]
        assert_moves_as(motion, before[link].matrix, later[link].matrix)


def test_the_links_velocities_are_the_derivatives_of_their_poses() -> None:
    rng = np.random.default_rng(seed=0)
    model = assemble().model
    driven = [joint.name for joint in model.movable_joints if joint.mimic is None]
    for _ in range(5):
        position, velocity = rng.uniform(-2, 2, size=(2, len(driven)))
        assert_is_derivative(
            model,
            dict(zip(driven, position, strict=True)),
            dict(zip(driven, velocity, strict=True)),
        )


def test_prismatic_joints_and_their_mimics_count() -> None:
    rng = np.random.default_rng(seed=1)
    turned = Pose(xyz=(0.1, 0.2, 0.3), rpy=(0.4, -0.5, 0.6))
    model = RobotModel(
        name="gantry",
        root="a",
        links=tuple(Link(name=name) for name in "abcd"),
        joints=(
            Joint(
                name="slide",
                type=JointType.PRISMATIC,
                parent="a",
                child="b",
                origin=turned,
                axis=(0.0, 0.6, 0.8),
            ),
            Joint(
                name="turn",
                type=JointType.CONTINUOUS,
                parent="b",
                child="c",
                origin=turned,
                axis=(0.0, 0.0, 1.0),
            ),
            Joint(
                name="follow",
                type=JointType.PRISMATIC,
                parent="c",
                child="d",
                origin=turned,
                mimic=Mimic(joint="turn", multiplier=-0.5, offset=0.1),
            ),
        ),
    )
    for _ in range(5):
        q, qd = rng.uniform(-2, 2, size=(2, 2))
        assert_is_derivative(
            model,
            {"slide": q[0], "turn": q[1]},
            {"slide": qd[0], "turn": qd[1]},
        )


def test_what_is_carried_moves_firmly() -> None:
    rng = np.random.default_rng(seed=2)
    for _ in range(20):
        motion, fixed = random_motion(rng), random_transform(rng)
        carried = motion.carry(fixed)
        before, later = (after(motion, t) @ fixed.matrix for t in (-H, H))
        assert_moves_as(carried, before, later)
        np.testing.assert_allclose(
            carried.carry(fixed.inverse()).linear, motion.linear, atol=1e-12
        )


def test_placing_in_a_frame_and_looking_from_it_undo_each_other() -> None:
    rng = np.random.default_rng(seed=3)
    for _ in range(20):
        motion, frame = random_motion(rng), random_transform(rng)
        back = motion.placed_in(frame).relative_to(FrameMotion(pose=frame))
        np.testing.assert_allclose(back.pose.matrix, motion.pose.matrix, atol=1e-12)
        np.testing.assert_allclose(back.linear, motion.linear, atol=1e-12)
        np.testing.assert_allclose(back.angular, motion.angular, atol=1e-12)


def test_a_motion_stands_still_relative_to_itself() -> None:
    motion = random_motion(np.random.default_rng(seed=4))
    still = motion.relative_to(motion)
    np.testing.assert_allclose(still.pose.matrix, np.eye(4), atol=1e-12)
    assert (still.linear, still.angular) == ((0, 0, 0), (0, 0, 0))


OTHERWISE = [0.1, 0.2, 0.05, 9.9]  # the last one mimics: 0.2 - 0.5 · bend


def test_joints_that_are_not_given_stay_and_mimic_joints_follow(
    skew_model: RobotModel,
) -> None:
    assert joint_positions(skew_model, {}, OTHERWISE) == [0.1, 0.2, 0.05, 0.1]
    for limit in (-2.8, 2.8):
        assert joint_positions(skew_model, {"lift": limit}, OTHERWISE)[0] == limit
    moved = joint_positions(skew_model, {"bend": 1.0}, OTHERWISE)
    assert moved == pytest.approx([0.1, 1.0, 0.05, -0.3])


@pytest.mark.parametrize("value", [2.9, -2.9, math.inf, math.nan])
def test_a_position_outside_the_limits_is_refused(
    skew_model: RobotModel, value: float
) -> None:
    with pytest.raises(LimitsError) as error:
        joint_positions(skew_model, {"lift": value}, OTHERWISE)
    assert "'lift'" in str(error.value)
    assert "[-2.8, 2.8]" in str(error.value)


@pytest.mark.parametrize(
    ("joint", "names"),
    [("lfit", "'lift'"), ("cap_joint", "'cap_joint'"), ("follower", "'bend'")],
    ids=["unknown", "fixed", "mimic"],
)
def test_a_joint_that_cannot_be_placed_is_refused(
    skew_model: RobotModel, joint: str, names: str
) -> None:
    with pytest.raises(ModelError) as error:
        joint_positions(skew_model, {joint: 0.0}, OTHERWISE)
    assert names in str(error.value)
