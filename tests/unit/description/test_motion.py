"""How links move: laws, and differences of where they are."""

from collections.abc import Mapping

import numpy as np

from tool0.description.catalogue import assemble
from tool0.description.forward_kinematics import FrameMotion, link_motions, link_poses
from tool0.description.model import Joint, JointType, Link, Mimic, RobotModel
from tool0.description.transform import (
    Pose,
    Transform,
    from_quaternion,
    to_pose,
    to_transform,
)

H = 1e-6  # [s]; central differences err by O(h^2)


def random_transform(rng: np.random.Generator) -> Transform:
    x, y, z, roll, pitch, yaw = rng.uniform(-3, 3, size=6)
    return to_transform(Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw)))


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
        back = motion.placed_in(frame).seen_from(FrameMotion(pose=frame))
        np.testing.assert_allclose(back.pose.matrix, motion.pose.matrix, atol=1e-12)
        np.testing.assert_allclose(back.linear, motion.linear, atol=1e-12)
        np.testing.assert_allclose(back.angular, motion.angular, atol=1e-12)


def test_a_motion_stands_still_seen_from_itself() -> None:
    motion = random_motion(np.random.default_rng(seed=4))
    still = motion.seen_from(motion)
    np.testing.assert_allclose(still.pose.matrix, np.eye(4), atol=1e-12)
    assert (still.linear, still.angular) == ((0, 0, 0), (0, 0, 0))


def test_quaternions_and_poses_of_urdf_come_back() -> None:
    rng = np.random.default_rng(seed=5)
    upright = [
        to_transform(Pose(rpy=(0.3, pitch, -0.8))) for pitch in (np.pi / 2, -np.pi / 2)
    ]
    for T in [*upright, *(random_transform(rng) for _ in range(50))]:
        longer = [-3.0 * part for part in T.quat_wxyz]
        same = from_quaternion(T.position, longer)
        np.testing.assert_allclose(same.matrix, T.matrix, atol=1e-12)
        np.testing.assert_allclose(to_transform(to_pose(T)).matrix, T.matrix, atol=1e-8)
