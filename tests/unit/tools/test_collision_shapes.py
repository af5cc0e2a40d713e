"""The collision primitives of assembled robots, measured with MuJoCo's distances."""

import itertools
import math

import mujoco
import numpy as np
import pytest
from arm_shapes import ARMS
from meshes.arm import GAP, arm_shape
from meshes.arm_parameters import ArmParameters
from meshes.gripper import (
    INNER_PIVOT,
    OUTER_FINGER,
    OUTER_KNUCKLE,
    OUTER_PIVOT,
    PAD,
    gripper_shape,
)
from meshes.model import Cylinder, LinkShape

CLOSED = 0.8133
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

    def __init__(self, arm: ArmParameters | None, *, gripper: bool) -> None:
        self.spec = mujoco.MjSpec()
        self.joint_of_finger: list[tuple[str, float]] = []
        flange = self.spec.worldbody
        if arm:
            flange = self._add_arm(arm)
        if gripper:
            self._add_gripper(flange)
        self.model = self.spec.compile()
        self.data = mujoco.MjData(self.model)

    def _add_arm(self, arm: ArmParameters) -> mujoco.MjsBody:
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
        return body

    def _add_gripper(self, flange: mujoco.MjsBody) -> None:
        links = gripper_shape().links
        base = self._add(flange, "gripper", links["base"])
        for side, sign in (("left", -1), ("right", 1)):
            yaw = (0, 0, 0 if sign == 1 else math.pi)
            for name, (y, z) in (("outer", OUTER_PIVOT), ("inner", INNER_PIVOT)):
                knuckle = f"{name}_knuckle"
                xyz = (0, sign * y, z)
                body = self._add(base, f"{side}_{knuckle}", links[knuckle], xyz, yaw)
                self._swing(body, 1.0)
                if name == "outer":
                    crank = body
            for link, (y, z) in (
                ("outer_finger", OUTER_KNUCKLE),
                ("inner_finger", OUTER_FINGER),
                ("inner_finger_pad", PAD),
            ):
                crank = self._add(crank, f"{side}_{link}", links[link], (0, y, z))
                if link == "inner_finger":
                    self._swing(crank, -1.0)

    def _swing(self, body: mujoco.MjsBody, sign: float) -> None:
        body.add_joint(name=body.name, axis=(1, 0, 0))
        self.joint_of_finger.append((body.name, sign))

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

    def pose(self, arm: tuple[float, ...] = (), finger: float = 0.0) -> None:
        for link, position in zip(ARM_LINKS[1:], arm, strict=False):
            self.data.joint(link).qpos = position
        for joint, sign in self.joint_of_finger:
            self.data.joint(joint).qpos = sign * finger
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


def gripper_links() -> list[str]:
    fingers = ("outer_knuckle", "outer_finger", "inner_knuckle", "inner_finger")
    sides = itertools.product(("left", "right"), (*fingers, "inner_finger_pad"))
    return ["gripper", *(f"{side}_{link}" for side, link in sides)]


FIXED = {
    frozenset({f"{side}_{a}", f"{side}_{b}"})
    for side in ("left", "right")
    for a, b in (
        ("outer_knuckle", "outer_finger"),
        ("inner_finger", "inner_finger_pad"),
    )
}
"""Links that do not move against each other, and may touch."""


@pytest.mark.parametrize("pose", POSES.values(), ids=POSES)
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_no_two_links_of_an_arm_touch(
    arm: ArmParameters, pose: tuple[float, ...]
) -> None:
    robot = Assembly(arm, gripper=False)
    robot.pose(pose)
    for first, second in itertools.combinations(ARM_LINKS, 2):
        assert robot.distance(first, second) > 0.001, (first, second)


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_neighbours_face_each_other_across_a_ring_at_any_angle(
    arm: ArmParameters,
) -> None:
    robot = Assembly(arm, gripper=False)
    rng = np.random.default_rng(seed=0)
    for pose in rng.uniform(-2.6, 2.6, size=(10, 6)):  # the elbow folds no further
        robot.pose(tuple(pose))
        for first, second in itertools.pairwise(ARM_LINKS):
            gap = robot.distance(first, second)
            assert 0.25 * GAP < gap < 1.01 * GAP, (first, second, pose)


@pytest.mark.parametrize("pose", POSES.values(), ids=POSES)
def test_an_open_or_closed_gripper_does_not_touch_a_ur5(
    pose: tuple[float, ...],
) -> None:
    robot = Assembly(ARMS["ur5"], gripper=True)
    for finger in (0.0, CLOSED):
        robot.pose(pose, finger)
        for first, second in itertools.product(ARM_LINKS[:-1], gripper_links()):
            assert robot.distance(first, second) > 0.001, (first, second)


@pytest.mark.parametrize("finger", np.linspace(0.0, CLOSED, 12))
def test_only_the_closed_pads_touch_within_the_gripper(finger: float) -> None:
    robot = Assembly(None, gripper=True)
    robot.pose(finger=finger)
    pads = frozenset({"left_inner_finger_pad", "right_inner_finger_pad"})
    for pair in itertools.combinations(gripper_links(), 2):
        if frozenset(pair) not in FIXED | {pads}:
            assert robot.distance(*pair) > 0.0005, pair
    opening = 2 * (0.0054057553 + 0.0376 * np.cos(finger) - 0.0430 * np.sin(finger))
    assert robot.distance(*pads) == pytest.approx(min(opening, FAR), abs=2e-5)


@pytest.mark.parametrize("finger", np.linspace(0.0, 0.79, 9))
def test_a_grasped_box_touches_the_pads_alone(finger: float) -> None:
    robot = Assembly(None, gripper=True)
    # Derived from the joints' origins: the pads' distance, and their height.
    opening = 2 * (0.0054057553 + 0.0376 * np.cos(finger) - 0.0430 * np.sin(finger))
    height = 0.087324 + 0.0376 * np.sin(finger) + 0.0430 * np.cos(finger)
    box = robot.spec.worldbody.add_body(name="box", pos=(0, 0, height))
    half = (0.03, opening / 2, 0.025)  # taller and wider than a pad
    box.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half)
    robot.model = robot.spec.compile()
    robot.data = mujoco.MjData(robot.model)
    robot.pose(finger=finger)
    for link in gripper_links():
        distance = robot.distance("box", link)
        if link.endswith("pad"):
            assert distance == pytest.approx(0.0, abs=2e-5)
        else:
            assert distance > 0.001, link
