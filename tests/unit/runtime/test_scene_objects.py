"""The scene as commands change it, and what a person may write."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from skew_rig import build_core, build_loop, follow

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ConfigError, ControlError, EngineError
from tool0.hardware.engine import ObjectState
from tool0.runtime.bus import WasReset

HERE = (5.0, 0.0, 1.0)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def cube(name: str = "cube", mass: float | None = 0.1) -> SceneObject:
    return SceneObject(
        name=name, geometry=Box(size=(0.1, 0.1, 0.1)), pose=Pose(xyz=HERE), mass=mass
    )


def test_a_snapshot_says_whose_its_states_are() -> None:
    core = build_core()
    loop, bus = build_loop(core)
    loop.call(lambda: core.scene.spawn(cube()))
    one = bus.latest
    assert one is not None
    assert [item.name for item in one.scene] == ["cube"]
    loop.run(0.1)
    two = bus.latest
    assert two is not None
    assert two.scene is one.scene
    assert two.objects != one.objects
    loop.call(lambda: core.scene.spawn(cube("other", mass=None)))
    loop.call(lambda: core.scene.delete("cube"))
    three = bus.latest
    assert three is not None
    assert [item.name for item in three.scene] == ["other"]
    assert [state.name for state in three.objects] == ["other"]


def test_an_object_never_has_the_name_of_a_link() -> None:
    core = build_core()
    with pytest.raises(ConfigError):
        core.scene.spawn(cube("upper"))
    assert core.scene.objects == ()
    assert core.engine.world.object_states() == ()


def test_what_the_engine_refuses_is_not_in_the_scene() -> None:
    core = build_core()
    core.scene.spawn(cube())
    objects = core.scene.objects
    with pytest.raises(EngineError):
        core.scene.spawn(cube())
    with pytest.raises(EngineError):
        core.scene.delete("other")
    assert core.scene.objects is objects


def test_a_quaternion_may_have_any_length() -> None:
    core = build_core()
    core.scene.spawn(cube())
    core.scene.place(ObjectState("cube", HERE, (0.0, 3.0, 0.0, 4.0)))
    (state,) = core.engine.world.object_states()
    assert state.quat_wxyz == pytest.approx((0.0, 0.6, 0.0, 0.8))


@pytest.mark.parametrize(
    "state",
    [
        ObjectState("cube", (math.nan, 0.0, 0.0), UPRIGHT),
        ObjectState("cube", HERE, (0.0, 0.0, 0.0, 0.0)),
        ObjectState("cube", HERE, (math.nan, 0.0, 0.0, 1.0)),
        ObjectState("cube", HERE, UPRIGHT, linear=(math.inf, 0.0, 0.0)),
        ObjectState("cube", HERE, UPRIGHT, angular=(0.0, math.nan, 0.0)),
    ],
)
def test_only_finite_states_can_be_placed(state: ObjectState) -> None:
    core = build_core()
    core.scene.spawn(cube())
    before = core.engine.world.object_states()
    with pytest.raises(ControlError, match=r"'cube'"):
        core.scene.place(state)
    assert core.engine.world.object_states() == before


@pytest.mark.parametrize("period", [0.001, 0.004])
def test_a_reset_can_keep_the_time(period: float) -> None:
    core = build_core(control_period=period)
    follow(core, [0.7, -0.9], 0.4)
    for _ in range(123):
        core.tick()
    core.reset({}, keep_time=True)
    assert core.ticks == 123
    assert core.time == core.state.time == pytest.approx(123 * period)
    goal = follow(core, [0.7, -0.9], 0.4)
    for _ in range(round(1.0 / period)):
        core.tick()
    assert goal.status.is_terminal
    assert core.state.position[:2] == pytest.approx([0.7, -0.9], abs=1e-2)
    core.reset({}, keep_time=False)
    assert core.time == core.state.time == 0.0


def test_the_event_of_a_reset_says_what_time_it_is() -> None:
    loop, bus = build_loop(build_core())
    reader = bus.subscribe()
    loop.run(0.25)
    loop.call(lambda: loop.reset({}, keep_time=True))
    loop.call(lambda: loop.reset({}, keep_time=False))
    assert list(reader.events) == [WasReset(pytest.approx(0.25)), WasReset(0.0)]


def test_the_parameters_of_a_loaded_controller_can_be_read() -> None:
    core = build_core()
    assert core.manager.spec("arm") is core.manager.spec("arm")
    assert core.manager.spec("group").joints == ("lift", "bend")
    with pytest.raises(ControlError) as caught:
        core.manager.spec("amr")
    assert "'arm'" in str(caught.value)


# ---- the facade ---------------------------------------------------------------------


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(gripper=None, realtime=False) as robot:
        yield robot


def test_positions_may_be_any_sequence_of_numbers(robot: tool0.Robot) -> None:
    robot.scene.add(cube())
    robot.scene.place("cube", np.array([1, 2, 3]), [0, 0, 0, 2], linear=np.ones(3))
    (state,) = robot.snapshot.objects
    assert (state.position, state.quat_wxyz) == ((1, 2, 3), (0, 0, 0, 1))
    assert state.linear == (1, 1, 1)
    assert all(type(part) is float for part in (*state.position, *state.linear))


@pytest.mark.parametrize(
    "options",
    [
        {"position": (1.0, 2.0)},
        {"quat_wxyz": (1.0, 0.0, 0.0)},
        {"linear": (1.0,)},
        {"angular": ()},
    ],
)
def test_each_part_has_its_number_of_values(
    robot: tool0.Robot, options: dict[str, tuple[float, ...]]
) -> None:
    robot.scene.add(cube())
    with pytest.raises(ControlError):
        robot.scene.place("cube", **{"position": HERE, **options})  # type: ignore[arg-type]


def test_a_controller_tells_its_parameters(robot: tool0.Robot) -> None:
    spec = robot.controller("eff_joint_traj_controller").spec
    assert spec.type == "effort_controllers/JointTrajectoryController"
    assert spec.joints[2] == "elbow_joint"
    robot.controller("joint_group_eff_controller").spec  # noqa: B018  # not running


def test_what_comes_in_real_time_makes_no_goal_fail() -> None:
    with tool0.bringup() as robot:
        done = threading.Event()
        arm = robot.controller("eff_joint_traj_controller")
        goal = arm.move({"elbow_joint": 1.4}, speed=1.0)
        goal.when_finished(lambda _: done.set())
        for i in range(10):
            robot.scene.add(cube(f"cube{i}", mass=None))
        for i in range(10):
            robot.scene.remove(f"cube{i}")
        assert done.wait(10.0)
        assert goal.status.value == "SUCCEEDED"
        assert robot.scene.objects == ()
