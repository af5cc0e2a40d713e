from __future__ import annotations

import math
import threading

import pytest
from raises_naming import raises_naming
from skew_rig import build_core, build_loop

import tool0
from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ControlError
from tool0.protocol.bus import WasReset

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
    with raises_naming(ControlError, "'cube'"):
        core.scene.place(state)
    assert core.engine.world.object_states() == before


def test_the_event_of_a_reset_says_what_time_it_is() -> None:
    core = build_core(control_period=0.004)
    loop, bus = build_loop(core)
    reader = bus.subscribe()
    loop.run(0.24)
    loop.call(lambda: loop.reset({}, keep_time=True))
    assert core.time == core.state.time == pytest.approx(0.24)
    loop.run(0.1)
    loop.call(lambda: loop.reset({}, keep_time=False))
    assert list(reader.events) == [
        WasReset(pytest.approx(0.24), step=60),
        WasReset(0.0, step=85),
    ]


@pytest.mark.slow
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
        assert done.wait(30.0)
        assert goal.status.value == "SUCCEEDED"
        assert robot.scene.objects == ()
