"""Shapes of the grippers: what is drawn, and what touches, between open and closed."""

from __future__ import annotations

import itertools
from pathlib import Path

import make_meshes
import mujoco
import numpy as np
import pytest
import yaml
from meshes.gripper import gripper_shape

from tool0.description.catalogue import find_part, grippers
from tool0.description.forward_kinematics import link_poses
from tool0.description.grasp_frames import grasp_frame, pad_links
from tool0.description.loading import assemble, named_poses
from tool0.description.model import ParallelGripper, RobotModel
from tool0.engines.mujoco.model import build_spec, collision_name, compile_spec

pytestmark = pytest.mark.slow

FAR = 0.1  # [m], distances beyond are all the same
ARM_POSES = ("home", "up", "ready")
SHARES = np.linspace(0.0, 1.0, 9).tolist()
"""Of the largest opening."""


class Robot:
    """An arm with a gripper, and the distances between its links."""

    def __init__(self, name: str) -> None:
        description = assemble(gripper=name)
        self.poses = named_poses(description)
        self.model: RobotModel = description.model
        (self.gripper,) = self.model.grippers
        self.spec = build_spec(self.model, dt=0.001)
        self._compile()
        base = self.model.joint(self.gripper.joint).parent
        self.links = [
            name
            for name in self.model.links_from(base)
            if self.model.link(name).collisions
        ]

    def add_box(self, size: tuple[float, ...], pose: np.ndarray) -> None:
        body = self.spec.worldbody.add_body(name="box", pos=pose[:3, 3])
        quat = np.empty(4)
        mujoco.mju_mat2Quat(quat, pose[:3, :3].ravel())
        body.quat = quat
        body.add_geom(name="box", type=mujoco.mjtGeom.mjGEOM_BOX, size=size)
        self._compile()

    def _compile(self) -> None:
        self._mj = compile_spec(self.spec)
        self._data = mujoco.MjData(self._mj)

    def put(self, opening: float, arm: str = "home") -> dict[str, np.ndarray]:
        """Pose the robot; return the frame of each link in its root."""
        drive = self.gripper.position(opening)
        position = {**self.poses[arm], self.gripper.joint: drive}
        for joint in self.model.movable_joints:
            mimic = joint.mimic
            q = mimic.multiplier * drive if mimic else position.get(joint.name, 0.0)
            self._data.joint(joint.name).qpos = q
        mujoco.mj_forward(self._mj, self._data)
        frames = link_poses(self.model, position)
        return {name: frame.matrix for name, frame in frames.items()}

    def distance(self, first: str, second: str) -> float:
        """Return the distance between two links' shapes [m]; negative: overlap."""
        return min(
            mujoco.mj_geomDistance(self._mj, self._data, a, b, FAR, np.zeros(6))
            for a, b in itertools.product(self._geoms(first), self._geoms(second))
        )

    def _geoms(self, name: str) -> list[int]:
        if name == "box":
            return [self._mj.geom("box").id]
        link = self.model.link(name)
        return [
            self._mj.geom(collision_name(link, number)).id
            for number in range(len(link.collisions))
        ]


@pytest.fixture(params=grippers())
def robot(request: pytest.FixtureRequest) -> Robot:
    return Robot(request.param)


def may_touch(model: RobotModel, first: str, second: str) -> bool:
    """Return whether two links are neighbours, or both are pads."""
    joints = {frozenset({joint.parent, joint.child}) for joint in model.joints}
    pads = {name for name in (first, second) if model.link(name).surface}
    return frozenset({first, second}) in joints or len(pads) == 2


def gap(gripper: ParallelGripper, opening: float) -> float:
    return min(gripper.opening(gripper.position(opening)), FAR)


def test_only_the_closed_pads_touch_within_a_gripper(robot: Robot) -> None:
    pads = pad_links(robot.model, robot.gripper)
    for share in SHARES:
        opening = share * robot.gripper.max_opening
        robot.put(opening)
        for pair in itertools.combinations(robot.links, 2):
            if not may_touch(robot.model, *pair):
                assert robot.distance(*pair) > 0.0004, (pair, opening)
        assert robot.distance(*pads) == pytest.approx(
            gap(robot.gripper, opening), abs=3e-5
        )


@pytest.mark.parametrize("pose", ARM_POSES)
def test_a_gripper_touches_no_link_of_the_arm(robot: Robot, pose: str) -> None:
    arm = [
        link.name
        for link in robot.model.links
        if link.collisions
        and link.name not in robot.links
        and "wrist_3" not in link.name
    ]
    for opening in (0.0, robot.gripper.max_opening):
        robot.put(opening, pose)
        for pair in itertools.product(arm, robot.links):
            assert robot.distance(*pair) > 0.001, pair


@pytest.mark.parametrize("share", [0.1, 0.4, 0.7, 1.0])
def test_a_grasped_box_touches_the_pads_alone(robot: Robot, share: float) -> None:
    opening = share * robot.gripper.max_opening
    frames = robot.put(opening)
    frame = grasp_frame(robot.model, robot.gripper, opening, "tool0").matrix
    tip = frames["tool0"] @ frame
    thick = robot.model.link(robot.links[-1]).collisions[0].geometry.size  # type: ignore[union-attr]
    # wider than a pad, and as tall
    robot.add_box((0.03, opening / 2, thick[2] / 2), tip)
    robot.put(opening)
    for link in robot.links:
        distance = robot.distance("box", link)
        if robot.model.link(link).surface:
            assert distance == pytest.approx(0.0, abs=3e-5)
        else:
            assert distance > 0.0004, link


@pytest.mark.parametrize("name", grippers())
def test_the_pad_touches_with_exactly_its_box_and_is_drawn_as_large(name: str) -> None:
    folder = find_part("gripper", name).folder
    size = yaml.safe_load((folder / "kinematics.yaml").read_text())["kinematics"]
    (pad,) = (
        shape
        for link, shape in gripper_shape(folder).links.items()
        if link.endswith("pad")
    )
    assert list(pad.collision[0].size) == size["pad_size"]  # type: ignore[union-attr]
    solids = [solid for solids in pad.visual.values() for solid in solids]
    drawn = np.concatenate([solid.corners for solid in solids]).reshape(-1, 3)
    np.testing.assert_allclose(np.ptp(drawn, axis=0), size["pad_size"], atol=2e-6)


@pytest.mark.parametrize("name", grippers())
def test_a_gripper_s_meshes_are_small(name: str) -> None:
    folder = Path(make_meshes.PACKAGE, "meshes", name)
    assert sum(file.stat().st_size for file in folder.rglob("*.stl")) <= 150_000
