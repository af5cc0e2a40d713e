"""All forms of forward kinematics are one: MuJoCo's."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import skew_robot

from tool0.description.bodies import moving_bodies
from tool0.description.flat_frames import FlatTree
from tool0.description.forward_kinematics import link_motions, link_poses
from tool0.description.joint_tree import JointTree, LinkFrames, place_links
from tool0.description.loading import assemble, load_robot
from tool0.description.model import RobotModel
from tool0.description.transform import Transform
from tool0.description.transform_arrays import Array, Frames
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.kinematics.chain import find_chains

N = 6
DATA = Path(__file__).parents[2] / "data" / "description"


def _two_robots() -> RobotModel:
    return load_robot(DATA / "two_robots.urdf.xacro").model


ROBOTS = {
    "ur5_2f85": lambda: assemble("ur5", "2f85").model,
    "ur3e_hande": lambda: assemble("ur3e", "hande").model,
    "two_robots": _two_robots,
    "skew": skew_robot.build_model,
}


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request: pytest.FixtureRequest) -> RobotModel:
    return ROBOTS[request.param]()


@pytest.fixture(scope="module")
def free(robot: RobotModel) -> dict[str, Array]:
    """Positions of the joints that mimic no other."""
    rng = np.random.default_rng(5)
    names = [joint.name for joint in robot.movable_joints if joint.mimic is None]
    return {name: rng.uniform(-2.5, 2.5, N) for name in names}


@pytest.fixture(scope="module")
def expected(robot: RobotModel, free: dict[str, Array]) -> list[dict[str, Transform]]:
    """The poses of all links, one by one."""
    return [
        link_poses(robot, {name: float(q[k]) for name, q in free.items()})
        for k in range(N)
    ]


@pytest.fixture(scope="module")
def q(robot: RobotModel, free: dict[str, Array]) -> Array:
    """Positions of all joints, (n, n_joints)."""
    columns = []
    for joint in robot.movable_joints:
        mimic = joint.mimic
        columns.append(
            free[joint.name]
            if mimic is None
            else mimic.multiplier * free[mimic.joint] + mimic.offset
        )
    return np.stack(columns, axis=1)


def test_they_are_those_of_mujoco(
    robot: RobotModel, q: Array, expected: list[dict[str, Transform]]
) -> None:
    engine = MujocoEngine(robot)
    data = engine.data
    for k in range(N):
        data.qpos[: q.shape[1]] = q[k]
        mujoco.mj_kinematics(engine.model, data)
        for link in robot.links:
            site, pose = data.site(link.name), expected[k][link.name]
            np.testing.assert_allclose(pose.position, site.xpos, atol=1e-12)
            np.testing.assert_allclose(
                pose.rotation, site.xmat.reshape(3, 3), atol=1e-12
            )


def test_many_postures_are_as_one(
    robot: RobotModel, free: dict[str, Array], expected: list[dict[str, Transform]]
) -> None:
    links = [link.name for link in robot.links]
    for name, frames in LinkFrames(robot, links).poses(free, N).items():
        assert_same(frames, [poses[name] for poses in expected])


def test_a_link_alone_is_as_among_all(
    robot: RobotModel, free: dict[str, Array]
) -> None:
    links = [link.name for link in robot.links]
    together = LinkFrames(robot, links).poses(free, N)
    for name in links:
        (alone,) = LinkFrames(robot, [name]).poses(free, N).values()
        np.testing.assert_array_equal(alone.position, together[name].position)
        np.testing.assert_array_equal(alone.rotation, together[name].rotation)


def test_flat_frames_are_those_of_the_links_turned_to_z(
    robot: RobotModel, q: Array, expected: list[dict[str, Transform]]
) -> None:
    bodies = moving_bodies(robot)
    tree = FlatTree([body.tree_joint for body in bodies])
    for k in range(N):
        for body, turn, frame in zip(
            bodies, tree.turns, tree.frames(q[k].tolist()), strict=True
        ):
            pose = expected[k][body.joint.child]
            np.testing.assert_allclose(frame[9:], pose.position, atol=1e-12)
            turned = np.reshape(frame[:9], (3, 3)).T
            np.testing.assert_allclose(turned, pose.rotation @ turn, atol=1e-12)


def test_the_bodies_of_the_dynamics_are_the_links(
    robot: RobotModel, q: Array, expected: list[dict[str, Transform]]
) -> None:
    bodies = moving_bodies(robot)
    tree = JointTree([body.tree_joint for body in bodies])
    rotations, origins, axes = tree.forward(q)
    for i, body in enumerate(bodies):
        poses = [links[body.joint.child] for links in expected]
        assert_same(Frames(origins[:, i], rotations[i]), poses)
        along = [pose.rotate(body.joint.axis) for pose in poses]
        np.testing.assert_allclose(axes[:, i], along, atol=1e-12)


def test_velocities_are_derivatives(robot: RobotModel, free: dict[str, Array]) -> None:
    h = 1e-6
    at = {name: float(q[0]) for name, q in free.items()}
    rate = {name: float(q[1]) for name, q in free.items()}
    behind, ahead = (
        link_poses(robot, {name: at[name] + way * h * rate[name] for name in at})
        for way in (-1.0, 1.0)
    )
    for name, motion in link_motions(robot, at, rate).items():
        first, second = behind[name], ahead[name]
        linear = np.subtract(second.position, first.position) / (2 * h)
        np.testing.assert_allclose(motion.linear, linear, atol=1e-7)
        turn = (second @ first.inverse()).rotation_vector
        np.testing.assert_allclose(motion.angular, np.array(turn) / (2 * h), atol=1e-7)


def test_an_arm_is_part_of_its_robot(
    robot: RobotModel, free: dict[str, Array], expected: list[dict[str, Transform]]
) -> None:
    for chain in find_chains(robot).values():
        q = np.stack([free[name] for name in chain.joint_names], axis=1)
        found = chain.forward(q).T_base_tip
        poses = [links[chain.base].inverse() @ links[chain.tip] for links in expected]
        assert_same(Frames(found[:, :3, 3], found[:, :3, :3]), poses)


def test_links_are_placed_up_to_a_root() -> None:
    placed = place_links(_two_robots(), ["left_tool0"], "left_base_link")
    assert len(placed.joints) == len(placed.tree) == 6
    assert placed.placements["left_tool0"][0] == 5


def assert_same(frames: Frames, poses: list[Transform]) -> None:
    np.testing.assert_allclose(
        frames.position, [pose.position for pose in poses], atol=1e-12
    )
    np.testing.assert_allclose(
        frames.rotation, [pose.rotation for pose in poses], atol=1e-12
    )
