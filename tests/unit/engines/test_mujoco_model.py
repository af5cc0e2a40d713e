"""What MuJoCo makes of a robot model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tool0.description.catalogue import arms
from tool0.description.config import SPAWN_Z
from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble, load_robot, named_poses
from tool0.description.model import (
    Collision,
    Inertial,
    Interface,
    Joint,
    JointLimits,
    JointType,
    Link,
    RobotModel,
    Transmission,
)
from tool0.description.shapes import Mesh, Sphere
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.engines.mujoco.model import build_spec, to_mjcf
from tool0.errors import ModelError, SourceLocation

TWO_ROBOTS = Path("tests/data/description/two_robots.urdf.xacro")
TOOL = (0.07, 0.25)
"""Radius and length of a cylinder on the flange, as large as any gripper [m]."""


def random_position(model: RobotModel, seed: int) -> dict[str, float]:
    """Every movable joint somewhere, mimic joints where their masters put them."""
    rng = np.random.default_rng(seed)
    position = {
        joint.name: rng.uniform(
            max(joint.limits.lower, -3.0), min(joint.limits.upper, 3.0)
        )
        for joint in model.movable_joints
        if joint.mimic is None
    }
    for joint in model.movable_joints:
        if joint.mimic is not None:
            master = position[joint.mimic.joint]
            position[joint.name] = joint.mimic.multiplier * master + joint.mimic.offset
    return position


def named_robot(name: str) -> RobotModel:
    if name == "two_robots":
        return load_robot(TWO_ROBOTS).model
    arm, _, gripper = name.partition("_")
    return assemble(arm, gripper).model


@pytest.fixture(scope="module", params=["ur5_2f85", "ur10e_none", "two_robots"])
def robot(request: pytest.FixtureRequest) -> RobotModel:
    return named_robot(request.param)


@pytest.mark.slow
@pytest.mark.parametrize("arm", arms())
def test_an_arm_with_a_long_tool_touches_nothing_in_its_poses(arm: str) -> None:
    description = assemble(arm, gripper=None)
    spec = build_spec(description.model, dt=0.001, ground=-SPAWN_Z)
    flange, (radius, length) = spec.site("tool0"), TOOL
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, flange.quat)
    flange.parent.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=(radius, length / 2, 0.0),
        pos=flange.pos + turn.reshape(3, 3)[:, 2] * (length / 2),
        quat=flange.quat,
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    for pose in named_poses(description).values():
        for joint, position in pose.items():
            data.joint(joint).qpos[0] = position
        mujoco.mj_forward(model, data)
        assert data.ncon == 0
    data.joint("shoulder_lift_joint").qpos[0] = 0.7  # into the ground
    mujoco.mj_forward(model, data)
    assert data.ncon > 0


def placed(model: RobotModel, seed: int) -> tuple[MujocoEngine, dict[str, float]]:
    engine = MujocoEngine(model, ground=None)
    position = random_position(model, seed)
    engine.data.qpos[:] = [position[name] for name in engine.joint_names]
    mujoco.mj_forward(engine.model, engine.data)
    return engine, position


@pytest.mark.parametrize("seed", range(4))
def test_every_link_is_where_our_kinematics_puts_it(
    robot: RobotModel, seed: int
) -> None:
    engine, position = placed(robot, seed)
    for link, pose in link_poses(robot, position).items():
        site = engine.data.site(link)
        np.testing.assert_allclose(site.xpos, pose.position, atol=1e-9)
        np.testing.assert_allclose(
            site.xmat.reshape(3, 3), np.array(pose.rotation), atol=1e-9
        )


@pytest.mark.parametrize("seed", range(3))
def test_merged_links_keep_mass_and_centre_of_mass(
    robot: RobotModel, seed: int
) -> None:
    engine, position = placed(robot, seed)
    frames = link_poses(robot, position)
    moving = {joint.child for joint in robot.movable_joints}
    mass, moment = 0.0, np.zeros(3)
    for link in robot.links:
        above = link.name
        while above != robot.root and above not in moving:
            above = robot.parent_joint[above].parent
        if above == robot.root or link.inertial is None:
            continue  # what never moves has no mass in MuJoCo
        inertial = link.inertial
        center = frames[link.name].apply(inertial.origin.xyz)
        mass += inertial.mass
        moment += inertial.mass * np.array(center)
    assert engine.model.body_mass[1:].sum() == pytest.approx(mass, rel=1e-12)
    center = (engine.model.body_mass[1:] @ engine.data.xipos[1:]) / mass
    np.testing.assert_allclose(center, moment / mass, atol=1e-9)


def test_motors_limits_and_rotors_are_those_of_the_description(
    robot: RobotModel,
) -> None:
    engine = MujocoEngine(robot)
    motors = [engine.model.actuator(i).name for i in range(engine.model.nu)]
    assert sorted(motors) == sorted(robot.transmission_by_joint)
    for joint in robot.movable_joints:
        compiled = engine.model.joint(joint.name)
        np.testing.assert_allclose(
            compiled.range, [joint.limits.lower, joint.limits.upper]
        )
        drive = robot.transmission_by_joint.get(joint.name)
        armature = engine.model.dof_armature[compiled.dofadr[0]]
        assert armature == pytest.approx(drive.armature if drive else 0.0)


@pytest.mark.parametrize("name", ["ur5_2f85", "two_robots"])
def test_the_written_mjcf_is_the_same_robot(name: str) -> None:
    model = named_robot(name)
    ours = MujocoEngine(model).model
    again = mujoco.MjModel.from_xml_string(to_mjcf(model))
    assert (again.nq, again.nu, again.neq) == (ours.nq, ours.nu, ours.neq)
    assert again.nmesh > 0
    np.testing.assert_allclose(
        again.body_mass.sum(), ours.body_mass.sum(), rtol=1e-5
    )  # to_xml writes six digits


def test_a_moving_link_without_mass_is_refused_by_name(skew_model: RobotModel) -> None:
    links = tuple(
        Link(name="rod") if link.name == "rod" else link for link in skew_model.links
    )
    model = replace(
        skew_model,
        links=links,
        locations={"link:rod": SourceLocation(Path("cell.urdf"), 7)},
    )
    with pytest.raises(ModelError) as error:
        MujocoEngine(model)
    assert error.value.location == model.locations["link:rod"]
    assert "'rod'" in str(error.value)


def test_floating_joints_are_refused_by_name(skew_model: RobotModel) -> None:
    joints = tuple(
        replace(joint, type=JointType.FLOATING) if joint.name == "slide" else joint
        for joint in skew_model.joints
    )
    with pytest.raises(ModelError) as error:
        MujocoEngine(replace(skew_model, joints=joints, transmissions=()))
    assert "'slide'" in str(error.value)


def with_mesh(model: RobotModel, path: Path) -> RobotModel:
    shape = Collision(geometry=Mesh(uri=str(path), path=path))
    links = tuple(
        replace(link, collisions=(shape,)) if link.name == "rod" else link
        for link in model.links
    )
    return replace(model, links=links)


@pytest.mark.parametrize("name", ["rod.stl", "rod.dae"])
def test_a_mesh_that_mujoco_cannot_read_is_refused_by_name(
    skew_model: RobotModel, tmp_path: Path, name: str
) -> None:
    path = tmp_path / name
    path.write_bytes(b"this is no mesh" * 20)
    model = with_mesh(skew_model, path)
    for attempt in (MujocoEngine, to_mjcf):
        with pytest.raises(ModelError) as error:
            attempt(model)
        assert path.name in str(error.value)


def test_a_robot_may_have_no_motor_and_even_no_joint() -> None:
    rooted = Link(name="world", collisions=(Collision(geometry=Sphere(radius=0.1)),))
    engine = MujocoEngine(
        RobotModel(name="stone", root="world", links=(rooted,), joints=())
    )
    engine.reset([])
    engine.write([])
    engine.step()
    assert engine.read().position == []


def test_a_wheel_without_limits_turns_freely() -> None:
    wheel = Joint(
        name="wheel",
        type=JointType.CONTINUOUS,
        parent="world",
        child="rim",
        limits=JointLimits(effort=2.0),
        axis=(0.0, 0.0, 1.0),
    )
    rim = Link(name="rim", inertial=Inertial(mass=1.0, ixx=0.1, iyy=0.1, izz=0.1))
    drive = Transmission(name="drive", joint="wheel", interfaces=(Interface.EFFORT,))
    engine = MujocoEngine(
        RobotModel(
            name="wheel",
            root="world",
            links=(Link(name="world"), rim),
            joints=(wheel,),
            transmissions=(drive,),
        )
    )
    engine.reset([0.0])
    for _ in range(1000):
        engine.write([2.0])
        engine.step()
    state = engine.read()
    assert state.velocity[0] == pytest.approx(20.0, rel=1e-6)  # 2 N·m on 0.1 kg·m²
    assert state.position[0] == pytest.approx(10.0, rel=1e-2)


def test_a_link_at_rest_does_not_collide_with_what_it_carries() -> None:
    def ball(name: str, radius: float) -> Link:
        return Link(
            name=name,
            inertial=Inertial(mass=1.0, ixx=0.1, iyy=0.1, izz=0.1),
            collisions=(Collision(geometry=Sphere(radius=radius)),),
        )

    def robot(base: float, table: float) -> MujocoEngine:
        wheel = Joint(
            name="wheel",
            type=JointType.CONTINUOUS,
            parent="base",
            child="rim",
            axis=(0.0, 0.0, 1.0),
        )
        mounts = (
            Joint(name=name, type=JointType.FIXED, parent="world", child=name)
            for name in ("base", "table")
        )
        return MujocoEngine(
            RobotModel(
                name="wheel",
                root="world",
                links=(
                    Link(name="world"),
                    ball("base", base),
                    ball("table", table),
                    ball("rim", 0.2),
                ),
                joints=(*mounts, wheel),
                self_collide=True,
            ),
            ground=None,
        )

    for sizes in ((0.2, 1e-3), (1e-3, 0.2)):
        engine = robot(*sizes)
        engine.reset([0.0])
        engine.write([0.0])
        engine.step()
        pairs = {frozenset((c.first, c.second)) for c in engine.world.contacts()}
        assert pairs == {frozenset(("rim", "table"))}
