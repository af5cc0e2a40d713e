"""The collision primitives of assembled arms, measured with MuJoCo's distances."""

import itertools
import math

import mujoco
import numpy as np
import pytest
from arm_shapes import ARMS
from meshes.arm import GAP, arm_shape
from meshes.arm_parameters import ArmParameters
from meshes.model import Cylinder, LinkShape

HOME = (0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0)
POSES = {
    "home": HOME,
    "zero": (0.0,) * 6,
    "upright": (0.0, -1.5708, 0.0, -1.5708, 0.0, 0.0),
    "folded": (0.0, -1.5708, 2.6, -1.5708, -1.5708, 0.0),
    "folded back": (0.0, -1.5708, -2.6, -1.5708, -1.5708, 0.0),
}
ARM_LINKS = (
    "base",
    "shoulder",
    "upper_arm",
    "forearm",
    "wrist_1",
    "wrist_2",
    "wrist_3",
)
FAR = 0.1  # [m], distances beyond are all the same


class Assembly:
    """A robot of collision primitives; a body is named for its link."""

    def __init__(self, arm: ArmParameters) -> None:
        self.spec = mujoco.MjSpec()
        self._add_arm(arm)
        self.model = self.spec.compile()
        self.data = mujoco.MjData(self.model)

    def _add_arm(self, arm: ArmParameters) -> None:
        shape, quarter = arm_shape(arm), math.pi / 2
        origins = (
            ((0, 0, arm.d1), 0.0),
            ((0, 0, 0), quarter),
            ((-arm.a2, 0, 0), 0.0),
            ((-arm.a3, 0, arm.d4), 0.0),
            ((0, -arm.d5, 0), quarter),
            ((0, arm.d6, 0), -quarter),
        )
        body = self._add(self.spec.worldbody, "base", shape.links["base"])
        for link, (xyz, roll) in zip(ARM_LINKS[1:], origins, strict=True):
            body = self._add(body, link, shape.links[link], xyz, (roll, 0, 0))
            body.add_joint(name=link, axis=(0, 0, 1))

    def _add(
        self,
        parent: mujoco.MjsBody,
        name: str,
        shape: LinkShape,
        xyz: tuple[float, float, float] = (0, 0, 0),
        rpy: tuple[float, float, float] = (0, 0, 0),
    ) -> mujoco.MjsBody:
        body = parent.add_body(
            name=name, pos=xyz, quat=quat_wxyz(rpy), mass=1, inertia=(1, 1, 1)
        )
        for primitive in shape.collision:
            pose = {"pos": primitive.xyz, "quat": quat_wxyz(primitive.rpy)}
            if isinstance(primitive, Cylinder):
                size = (primitive.radius, primitive.length / 2, 0)
                kind = mujoco.mjtGeom.mjGEOM_CYLINDER
            else:
                size = tuple(side / 2 for side in primitive.size)
                kind = mujoco.mjtGeom.mjGEOM_BOX
            body.add_geom(type=kind, size=size, **pose)
        return body

    def pose(self, arm: tuple[float, ...]) -> None:
        for link, position in zip(ARM_LINKS[1:], arm, strict=True):
            self.data.joint(link).qpos = position
        mujoco.mj_forward(self.model, self.data)

    def distance(self, first: str, second: str) -> float:
        """Distance between two links' shapes [m], negative if they overlap."""
        pairs = itertools.product(self._geoms(first), self._geoms(second))
        return min(
            mujoco.mj_geomDistance(self.model, self.data, a, b, FAR, np.zeros(6))
            for a, b in pairs
        )

    def _geoms(self, link: str) -> range:
        body = self.model.body(link)
        first = int(body.geomadr[0])
        return range(first, first + int(body.geomnum[0]))


def quat_wxyz(rpy: tuple[float, float, float]) -> np.ndarray:
    quat = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in zip(np.eye(3), rpy, strict=True):
        turn, product = np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, axis, angle)
        mujoco.mju_mulQuat(product, turn, quat)
        quat = product
    return quat


@pytest.mark.slow
@pytest.mark.parametrize("pose", POSES.values(), ids=POSES)
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_no_two_links_of_an_arm_touch(
    arm: ArmParameters, pose: tuple[float, ...]
) -> None:
    robot = Assembly(arm)
    robot.pose(pose)
    for first, second in itertools.combinations(ARM_LINKS, 2):
        assert robot.distance(first, second) > 0.001, (first, second)


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_neighbours_face_each_other_across_a_ring_at_any_angle(
    arm: ArmParameters,
) -> None:
    robot = Assembly(arm)
    rng = np.random.default_rng(seed=0)
    for pose in rng.uniform(-2.6, 2.6, size=(10, 6)):  # the elbow folds no further
        robot.pose(tuple(pose))
        for first, second in itertools.pairwise(ARM_LINKS):
            gap = robot.distance(first, second)
            assert 0.25 * GAP < gap < 1.01 * GAP, (first, second, pose)
