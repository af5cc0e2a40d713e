"""The world by Gazebo's names, with a real robot, without ROS."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest

import tool0
from tool0.description.bodies import moving_bodies
from tool0.description.loading import assemble
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box, Compound
from tool0.description.transform import Pose, Transform
from tool0.errors import ControlError
from tool0.ros1.gazebo.world import GazeboChanges, GazeboWorld, lumped_links
from tool0.ros1.messages import MAX_VALUE, to_motion, to_transform

SPAWN_Z = 0.3
TABLE = SceneObject(
    name="table", geometry=Box(size=(0.2, 0.2, 0.2)), pose=Pose(xyz=(0.7, 0.0, 0.0))
)
OFFSET = """<sdf version='1.6'><model name='any'><pose>0 0 0.5 0 0 0</pose>
<link name='body'><pose>0 0 0.1 0 0 1</pose><collision name='shape'>
<pose>0.2 0 0 0 0 0</pose><geometry><sphere><radius>0.05</radius></sphere></geometry>
</collision></link></model></sdf>"""


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(
        scene=Scene((TABLE,)),
        simulation=tool0.SimulationConfig(spawn_z=SPAWN_Z),
        realtime=False,
        paused=True,
    ) as robot:
        yield robot


@pytest.fixture
def world(robot: tool0.Robot) -> GazeboWorld:
    return GazeboWorld(robot)


def vector(x: float, y: float, z: float) -> SimpleNamespace:
    return SimpleNamespace(x=x, y=y, z=z)


def pose(
    x: float = 0.0,
    y: float = 0.0,
    z: float = 0.0,
    quat_xyzw: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
) -> SimpleNamespace:
    qx, qy, qz, qw = quat_xyzw
    turn = SimpleNamespace(x=qx, y=qy, z=qz, w=qw)
    return SimpleNamespace(position=vector(x, y, z), orientation=turn)


def twist(
    linear: tuple[float, float, float] = (0.0, 0.0, 0.0),
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> SimpleNamespace:
    return SimpleNamespace(linear=vector(*linear), angular=vector(*angular))


def request(name: str, xml: str, at: SimpleNamespace) -> SimpleNamespace:
    return SimpleNamespace(
        model_name=name, model_xml=xml, initial_pose=at, reference_frame=""
    )


def test_models_are_in_the_world_at_the_spawn_height(world: GazeboWorld) -> None:
    models = world.now().models()
    assert list(models) == ["ground_plane", "robot", "table"]
    assert models["ground_plane"].pose == Transform()
    assert models["robot"].pose.position == (0.0, 0.0, SPAWN_Z)
    assert models["table"].pose.position == pytest.approx((0.7, 0.0, SPAWN_Z))


def test_links_have_their_model_s_name_or_none(
    robot: tool0.Robot, world: GazeboWorld
) -> None:
    view = world.now()
    x, y, z = robot.pose("tool0").position
    for name in ("robot::tool0", "ur5_robot::tool0", "tool0"):
        found = view.link(name)
        assert found is not None
        assert found.pose.position == pytest.approx((x, y, z + SPAWN_Z))
    table = view.link("table::link")
    assert table is not None
    assert table.pose.position == pytest.approx((0.7, 0.0, SPAWN_Z))
    for name in ("", "link", "robot::", "robot::link", "table::tool0", "a::b::c"):
        assert view.link(name) is None


@pytest.mark.parametrize("name", ["", "world", "map", "/map"])
def test_names_of_the_world_s_frame(world: GazeboWorld, name: str) -> None:
    assert world.now().frame(name).pose == Transform()


def test_an_unknown_frame_is_refused(world: GazeboWorld) -> None:
    with pytest.raises(ControlError) as error:
        world.now().frame("tool1")
    assert "'tool1'" in str(error.value)


def test_joints_are_found_with_their_model_s_name(world: GazeboWorld) -> None:
    for name in ("elbow_joint", "robot::elbow_joint", "ur5_robot::elbow_joint"):
        joint = world.joint(name)
        assert joint is not None
        assert joint.name == "elbow_joint"
    for name in ("", "table::elbow_joint", "robot::elbow"):
        assert world.joint(name) is None


def test_gazebo_keeps_the_base_and_the_links_that_move() -> None:
    model = assemble().model
    links = lumped_links(model)
    assert links[0] == "base_link"
    assert links[1:] == tuple(body.joint.child for body in moving_bodies(model))


def test_a_model_is_where_it_was_spawned_whatever_its_shape_s_offset(
    robot: tool0.Robot, world: GazeboWorld
) -> None:
    changes = GazeboChanges(robot, world, lambda time: None)
    changes.spawn_model(request("ball", OFFSET, pose(0.5, 0.1, 1.0)), None)
    view = world.now()
    ball, link = view.model("ball"), view.link("ball::body")
    assert ball is not None
    assert link is not None
    assert ball.pose.position == pytest.approx((0.5, 0.1, 1.5))
    assert link.pose.position == pytest.approx((0.5, 0.1, 1.6))
    state = robot.snapshot.objects[1]
    c, s = np.cos(1.0), np.sin(1.0)
    assert state.position == pytest.approx(
        (0.5 + 0.2 * c, 0.1 + 0.2 * s, 1.6 - SPAWN_Z)
    )


def test_set_model_state_sets_pose_and_velocity(
    robot: tool0.Robot, world: GazeboWorld
) -> None:
    changes = GazeboChanges(robot, world, lambda time: None)
    changes.spawn_model(request("ball", OFFSET, pose(0.5, 0.1, 1.0)), None)
    changes.place(
        SimpleNamespace(
            model_name="ball",
            reference_frame="robot",
            pose=pose(0.1, 0.2, 1.0, (0.0, 0.0, 2.0, 2.0)),
            twist=twist((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)),
        )
    )
    ball = world.now().model("ball")
    assert ball is not None
    assert ball.pose.position == pytest.approx((0.1, 0.2, 1.0 + SPAWN_Z))
    assert ball.pose.quat_wxyz == pytest.approx((0.5**0.5, 0.0, 0.0, 0.5**0.5))
    assert ball.linear == pytest.approx((1.0, 2.0, 3.0))
    assert ball.angular == pytest.approx((4.0, 5.0, 6.0))


def test_an_object_of_the_same_name_has_a_model_of_its_own(
    robot: tool0.Robot, world: GazeboWorld
) -> None:
    changes = GazeboChanges(robot, world, lambda time: None)
    changes.spawn_model(request("ball", OFFSET, pose(0.5, 0.1, 1.0)), None)
    robot.scene.remove("ball")
    robot.scene.add(
        SceneObject(
            name="ball", geometry=TABLE.geometry, pose=Pose(xyz=(0.7, 0.0, 0.5))
        )
    )  # by the panel, say
    view = world.now()
    assert view.link("ball::body") is None
    ball = view.model("ball")
    assert ball is not None
    assert ball.pose.position == pytest.approx((0.7, 0.0, 0.5 + SPAWN_Z))


def test_a_model_of_several_shapes_has_the_frame_of_its_link(
    robot: tool0.Robot, world: GazeboWorld
) -> None:
    more = "<collision name='b'><geometry><box><size>1 1 1</size></box></geometry>"
    text = OFFSET.replace("</link>", f"{more}</collision></link>")
    changes = GazeboChanges(robot, world, lambda time: None)
    changes.spawn_model(request("ball", text, pose(0.5, 0.1, 1.0)), None)
    ball = world.now().model("ball")
    assert ball is not None
    assert ball.pose.position == pytest.approx((0.5, 0.1, 1.5))
    state = robot.snapshot.objects[1]
    assert state.position == pytest.approx((0.5, 0.1, 1.6 - SPAWN_Z))
    robot.scene.remove("ball")
    shape = Compound(parts=((TABLE.geometry, Pose()),) * 2)
    again = robot.scene.add("ball", shape, xyz=(0.7, 0.0, 0.5))
    assert world.model_of(again).collisions == ("collision", "collision_1")


def test_a_quaternion_of_zeros_is_no_rotation() -> None:
    assert to_transform(pose(1.0, 2.0, 3.0)) == Transform(position=(1.0, 2.0, 3.0))


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 2 * MAX_VALUE])
def test_values_that_are_too_large_are_refused(bad: float) -> None:
    with pytest.raises(ControlError) as error:
        to_transform(pose(0.0, bad, 0.0))
    assert str(bad) in str(error.value)
    for velocity in (twist(linear=(0.0, 0.0, bad)), twist(angular=(bad, 0.0, 0.0))):
        with pytest.raises(ControlError) as error:
            to_motion(pose(), velocity)
        assert str(bad) in str(error.value)


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_an_orientation_that_is_not_finite_is_refused(bad: float) -> None:
    with pytest.raises(ControlError) as error:
        to_transform(pose(quat_xyzw=(0.0, bad, 0.0, 1.0)))
    assert str(bad) in str(error.value)


@pytest.mark.parametrize("name", ["robot", "ur5_robot", "ground_plane", "nobody"])
def test_only_objects_are_deleted(
    robot: tool0.Robot, world: GazeboWorld, name: str
) -> None:
    with pytest.raises(ControlError):
        GazeboChanges(robot, world, lambda time: None).delete_model(
            SimpleNamespace(model_name=name), None
        )
    assert list(world.now().models()) == ["ground_plane", "robot", "table"]
