"""Worlds and models of a person's own, and what Gazebo makes of wrong ones."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest
from in_gazebo import BringUp, gazebo_with, gz

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ConfigError, DescriptionError, EngineError, SourceLocation

BOX = """\
    <link name="link">
      <inertial><mass>1.0</mass></inertial>
      <collision name="collision">
        <geometry><box><size>0.1 0.1 0.1</size></box></geometry>
      </collision>
    </link>"""
WORLD = f"""\
<?xml version="1.0"?>
<sdf version="1.6">
  <world name="theirs">
    <gravity>0 0 -5</gravity>
    <physics type="ode">
      <max_step_size>0.004</max_step_size>
      <real_time_update_rate>250</real_time_update_rate>
    </physics>
    <model name="crate">
      <pose>2 0 3 0 0 0</pose>
{BOX}
    </model>
  </world>
</sdf>
"""
MODEL = f"""\
<sdf version="1.6">
  <model name="whatever">
{BOX}
  </model>
</sdf>
"""
ASIDE = Pose(xyz=(2.0, 0.0, 1.0))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "mine.sdf"


def test_a_world_of_ones_own_is_used_at_the_robots_step(
    tmp_path: Path, bring_up: BringUp
) -> None:
    world = tmp_path / "theirs.world"
    world.write_text(WORLD)
    robot, engine = bring_up(engine_options={"world": world})
    robot.run(0.5)
    assert robot.time == pytest.approx(0.5)
    x, _, z, *_ = map(float, gz(engine, "model", "-m", "crate", "-p").split())
    assert x == pytest.approx(2.0)
    assert z == pytest.approx(3.0 - 5.0 * 0.5**2 / 2.0, abs=0.005)  # its own gravity
    position = robot.joint_state.position
    assert position["elbow_joint"] == pytest.approx(math.pi / 2, abs=0.02)


def test_the_weight_of_things_is_that_of_the_world(
    tmp_path: Path, bring_up: BringUp
) -> None:
    world = tmp_path / "slope.world"
    world.write_text(WORLD.replace("0 0 -5", "-3 0 -4").replace("2 0 3", "2 5 3"))
    robot, engine = bring_up(engine_options={"world": world})
    assert engine.world.gravity == (-3.0, 0.0, -4.0)
    robot.run(2.0)
    pull = np.array(robot.pose("tool0").rotation) @ robot.force_torque.read().force
    np.testing.assert_allclose(pull, 0.921 * np.array(engine.world.gravity), atol=0.01)


def test_a_world_is_read_relative_to_where_the_person_is(
    tmp_path: Path, bring_up: BringUp, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "theirs.world").write_text(WORLD)
    monkeypatch.chdir(tmp_path)
    _, engine = bring_up(engine_options={"world": "theirs.world"})
    engine.world.delete("crate")


@pytest.mark.parametrize(
    ("text", "line", "named"),
    [
        (WORLD.replace("</world>", "</wrld>"), 18, ""),
        (MODEL, 1, "<sdf>"),
        (WORLD.replace('<link name="link">', "<link>"), None, "element[link]"),
    ],
)
def test_a_world_that_is_none_is_named(
    text: str, line: int | None, named: str, file: Path
) -> None:
    file.write_text(text)
    with pytest.raises(DescriptionError) as error:
        tool0.bringup(simulation=gazebo_with(world=file))
    assert error.value.location == SourceLocation(file, line)
    assert named in str(error.value)


@pytest.mark.parametrize("gripper", ["2f85", None])
def test_physics_other_than_ode_is_refused(
    gripper: str | None, file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file.write_text(WORLD.replace('physics type="ode"', 'physics type="bullet"'))
    with pytest.raises(EngineError) as error:
        tool0.bringup(simulation=gazebo_with(world=file), gripper=gripper)
    for name in ("'bullet'", '"ode"'):
        assert name in str(error.value)
    assert caplog.records == []


def test_a_world_that_is_not_there_is_named() -> None:
    with pytest.raises(DescriptionError) as error:
        tool0.bringup(simulation=gazebo_with(world="nowhere.world"))
    assert "nowhere.world" in str(error.value)


def test_what_a_world_lacks_is_told_and_the_rest_is_used(
    file: Path, bring_up: BringUp, caplog: pytest.LogCaptureFixture
) -> None:
    plugin = '<plugin name="p" filename="libnowhere.so"/>'
    file.write_text(WORLD.replace("<model", f"{plugin}<model"))
    robot, _ = bring_up(engine_options={"world": file})
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert "libnowhere.so: cannot open shared object file" in record.getMessage()
    robot.run(0.01)


def test_the_usual_start_has_nothing_to_complain_of(
    bring_up: BringUp, caplog: pytest.LogCaptureFixture
) -> None:
    bring_up()
    assert caplog.records == []


@pytest.mark.parametrize("option", ["world", "gui"])
def test_what_is_for_gazebo_is_refused_elsewhere(option: str) -> None:
    simulation = tool0.SimulationConfig(engine_options={option: True})
    with pytest.raises(ConfigError) as error:
        tool0.bringup(simulation=simulation)
    assert f"'{option}'" in str(error.value)


def test_a_model_comes_and_goes_while_the_robot_is_up(
    file: Path, bring_up: BringUp
) -> None:
    file.write_text(MODEL)
    robot, engine = bring_up()
    robot.run(0.1)
    before = robot.joint_state
    engine.world.spawn_file("crate", file, ASIDE)
    x, _, z, *_ = map(float, gz(engine, "model", "-m", "crate", "-p").split())
    assert (x, z) == pytest.approx((2.0, 1.1))  # the robot's root is 0.1 m up
    assert robot.joint_state == before  # no time has passed
    robot.run(0.2)
    fallen = gz(engine, "model", "-m", "crate", "-p").split()
    assert float(fallen[2]) == pytest.approx(1.1 - 9.8 * 0.2**2 / 2.0, abs=0.005)
    engine.world.delete("crate")
    robot.run(0.1)
    assert robot.time == pytest.approx(0.4)
    engine.world.spawn_file("crate", file, ASIDE)  # the name is free again


def test_models_that_cannot_come_or_go_are_named(
    file: Path, bring_up: BringUp, tmp_path: Path
) -> None:
    cube = SceneObject(name="cube", geometry=Box(size=(0.1, 0.1, 0.1)), pose=ASIDE)
    robot, engine = bring_up(scene=Scene(objects=(cube,)))
    file.write_text(MODEL)
    engine.world.spawn_file("crate", file, ASIDE)
    for name in ("crate", "cube"):
        with pytest.raises(EngineError) as taken:
            engine.world.spawn_file(name, file, ASIDE)
        assert f"'{name}'" in str(taken.value)
    for name in ("crote", "ur5_robot"):
        with pytest.raises(EngineError) as kept:
            engine.world.delete(name)
        assert f"'{name}'" in str(kept.value)
    with pytest.raises(DescriptionError) as absent:
        engine.world.spawn_file("other", tmp_path / "nowhere.sdf", ASIDE)
    assert "nowhere.sdf" in str(absent.value)
    for text, line in ((MODEL.replace("</model>", ""), 10), (WORLD, 1)):
        file.write_text(text)
        with pytest.raises(DescriptionError) as error:
            engine.world.spawn_file("other", file, ASIDE)
        assert error.value.location == SourceLocation(file, line)
    for old, new, named in (
        ('<link name="link">', "<link>", "element[link]"),
        ("1.0</mass>", "-1.0</mass>", "mass"),
    ):
        file.write_text(MODEL.replace(old, new))
        with pytest.raises(EngineError) as refused:
            engine.world.spawn_file("other", file, ASIDE)
        assert named in str(refused.value)
        with pytest.raises(EngineError):
            engine.world.delete("other")  # what was built of it is gone
    robot.run(0.01)
    assert robot.snapshot.fault is None


def test_pausing_holds_time_while_gazebo_goes_on_answering(bring_up: BringUp) -> None:
    robot, engine = bring_up(realtime=True)
    robot.run(0.05)
    robot.pause()
    held = robot.snapshot
    told = gz(engine, "model", "-m", "ur5_robot", "-p").split()
    assert [float(part) for part in told] == pytest.approx([0, 0, 0.1, 0, 0, 0])
    assert robot.snapshot.time == held.time
    assert robot.joint_state.position == dict(
        zip(held.joint_names, held.position, strict=True)
    )
    robot.step(5)
    assert robot.time == pytest.approx(held.time + 0.005)
    robot.resume()
    robot.run(0.05)


@pytest.mark.parametrize("realtime", [False, True])
def test_who_pauses_the_world_in_gazebo_does_not_block_the_robot(
    realtime: bool, bring_up: BringUp
) -> None:
    robot, engine = bring_up(realtime=realtime)
    for _ in range(2):
        gz(engine, "world", "-p", "1")
        robot.run(0.1)


@pytest.mark.parametrize("reset", ["-r", "-o", "-t"])
def test_who_resets_the_world_in_gazebo_gets_the_robot_back(
    reset: str, bring_up: BringUp
) -> None:
    robot, engine = bring_up()
    for goal in robot.move_joints({"shoulder_pan_joint": -0.6}):
        goal.wait(timeout=10.0)
    robot.run(0.5)
    held = robot.joint_state.position
    time = robot.time
    gz(engine, "world", reset)
    robot.run(6.0)
    assert robot.time == pytest.approx(time + 6.0)
    assert robot.joint_state.position == pytest.approx(held, abs=0.01)


def test_contacts_of_many_things_are_told_in_parts(
    file: Path, bring_up: BringUp
) -> None:
    """A packet of the bridge's holds 400 pairs of shapes, or fewer of long names."""
    n, side = 100, 0.02  # [m]
    links = "".join(
        f"""<link name="link_{i}"><pose>{i % 10 * 0.03} {i // 10 * 0.03} 0 0 0 0</pose>
        <inertial><mass>0.1</mass><inertia><ixx>1e-5</ixx><iyy>1e-5</iyy>
        <izz>1e-5</izz></inertia></inertial>
        <collision name="{"x" * 700}{i}"><geometry><box>
        <size>{side} {side} {side}</size></box></geometry></collision></link>"""
        for i in range(n)
    )
    file.write_text(f'<sdf version="1.6"><model name="m">{links}</model></sdf>')
    robot, engine = bring_up(gripper=None)
    engine.world.spawn_file("crowd", file, Pose(xyz=(2.0, 0.0, side / 2.0 - 0.1)))
    robot.contacts()
    robot.run(0.3)
    (contact,) = robot.contacts()
    assert {contact.first, contact.second} == {"ground", "crowd"}
    assert abs(contact.force[2]) == pytest.approx(n * 0.1 * 9.8, rel=0.01)
