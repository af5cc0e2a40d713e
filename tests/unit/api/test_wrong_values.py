"""Values of wrong types, given to every public method: a Tool0Error that says so."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from served import serving

import tool0
from tool0.errors import Tool0Error
from tool0.protocol.trajectories import FollowTrajectory
from tool0.scene import Box, Cylinder, Pose, Sphere

pytestmark = pytest.mark.slow

ARM = "eff_joint_traj_controller"
WRONG: dict[str, object] = {
    "None": None,
    "text": "1",
    "bytes": b"x",
    "fraction": 1.5,
    "negative": -1,
    "bool": True,
    "nan": math.nan,
    "infinite": math.inf,
    "huge": 10**400,
    "tiny": 5e-324,
    "empty list": [],
    "numbers": (1, 2),
    "texts": ["a"],
    "nested": [[1]],
    "mapping": {"a": "b"},
    "wrong keys": {1: 2},
    "huge position": {"elbow_joint": 10**400},
    "no position": {"elbow_joint": None},
    "object": object(),
    "complex": 1j,
    "array": np.array([1, 2]),
    "nan of numpy": np.float64("nan"),
    "class": int,
    "long text": "x" * 300,
    "half a character": "\ud800",
    "names with half a character": ["\ud800"],
    "nobody's home": "~nobody/x",
}
POINTS = [tool0.TrajectoryPoint([0.0] * 6, time_from_start=1.0)]
BALL = Sphere(radius=0.01)
Call = Callable[[Any, Any], object]


def _arm(robot: Any) -> Any:
    return robot.controller(ARM)


def _below(robot: Any) -> Pose:
    x, y, z = robot.arm.pose().position
    return Pose(xyz=(x, y, z - 0.01), rpy=(math.pi, 0.0, 0.0))


CALLS: dict[str, Call] = {
    "controller": lambda r, w: r.controller(w),
    "load": lambda r, w: r.load(w),
    "load(config)": lambda r, w: r.load("x", 0 if w is None else w),
    "unload": lambda r, w: r.unload(w),
    "switch(start)": lambda r, w: r.switch(start=w),
    "switch(stop)": lambda r, w: r.switch(stop=w),
    "switch(strict)": lambda r, w: r.switch(strict=w),
    "run": lambda r, w: r.run(w),
    "step": lambda r, w: r.step(w),
    "set_speed": lambda r, w: r.set_speed(w),
    "reset": lambda r, w: r.reset(w),
    "reset(keep_time)": lambda r, w: r.reset(keep_time=w),
    "emergency_stop": lambda r, w: r.emergency_stop(w),
    "move_joints": lambda r, w: r.move_joints(w),
    "move_joints(speed)": lambda r, w: r.move_joints({"elbow_joint": 1.0}, speed=w),
    "move_joints(duration)": lambda r, w: r.move_joints(
        {"elbow_joint": 1.0},
        duration=w,
    ),
    "save_pose": lambda r, w: r.save_pose(w) if not isinstance(w, str) else None,
    "delete_pose": lambda r, w: r.delete_pose(w),
    "go_to_pose": lambda r, w: r.go_to_pose(w),
    "pose": lambda r, w: r.pose(w),
    "pose(relative_to)": lambda r, w: r.pose("tool0", w),
    "subscribe": lambda r, w: r.subscribe(w).close(),
    "camera": lambda r, w: r.camera(w),
    "force_torque_of": lambda r, w: r.force_torque_of(w),
    "follow": lambda r, w: _arm(r).follow(w),
    "follow(point)": lambda r, w: _arm(r).follow([w]),
    "follow(names)": lambda r, w: _arm(r).follow(POINTS, joint_names=w),
    "follow(stamp)": lambda r, w: _arm(r).follow(POINTS, stamp=w),
    "follow(path)": lambda r, w: _arm(r).follow(POINTS, path_tolerance=w),
    "follow(elbow)": lambda r, w: _arm(r).follow(
        POINTS,
        goal_tolerance={"elbow_joint": w},
    ),
    "follow(goal)": lambda r, w: _arm(r).follow(POINTS, goal_tolerance=w),
    "follow(time)": lambda r, w: _arm(r).follow(POINTS, goal_time_tolerance=w),
    "follow(request)": lambda r, w: r.channel.call(
        FollowTrajectory(controller=ARM, points=w)
    ),
    "record": lambda r, w: r.record(w).stop(),
    "start_recording": lambda r, w: r.start_recording(w),
    "start_recording(cameras)": lambda r, w: r.start_recording(cameras=w),
    "episodes.open": lambda r, w: r.episodes.open(w),
    "samples(timeout)": lambda r, w: r.force_torque.samples(timeout=w),
    "digital output": lambda r, w: r.arm.control_box.set_digital_output(w, True),
    "digital input": lambda r, w: r.arm.control_box.set_digital_input(w, True),
    "set_payload": lambda r, w: r.arm.control_box.set_payload(1.0, w),
    "gripper.tcp": lambda r, w: r.gripper.tcp(w),
    "gripper.tcp(link)": lambda r, w: r.gripper.tcp(relative_to=w),
    "command_trajectory": lambda r, w: _arm(r).command_trajectory(w),
    "move": lambda r, w: _arm(r).move(w),
    "steer": lambda r, w: _arm(r).steer(w),
    "command": lambda r, w: _arm(r).command(w),
    "command_gripper": lambda r, w: _arm(r).command_gripper(w),
    "query_state": lambda r, w: _arm(r).query_state(w),
    "wait": lambda r, w: (
        _arm(r).move({"elbow_joint": 1.5}).wait(0 if w is None or w is math.inf else w)
    ),
    "when_finished": lambda r, w: (
        w is int or _arm(r).move({"elbow_joint": 1.5}).when_finished(w)
    ),
    "TrajectoryPoint": lambda r, w: tool0.TrajectoryPoint(w),
    "TrajectoryPoint(v)": lambda r, w: tool0.TrajectoryPoint([0.0], w),
    "TrajectoryPoint(time)": lambda r, w: tool0.TrajectoryPoint(
        [0.0],
        time_from_start=w,
    ),
    "gripper.move": lambda r, w: r.gripper.move(opening=w),
    "gripper.move(position)": lambda r, w: r.gripper.move(position=w),
    "gripper.move(speed)": lambda r, w: r.gripper.move(opening=0.04, speed=w),
    "gripper.move(force)": lambda r, w: r.gripper.move(opening=0.04, force=w),
    "gripper.wait": lambda r, w: r.gripper.wait(0 if w is None or w is math.inf else w),
    "scene.add": lambda r, w: r.scene.add(w, BALL),
    "scene.add(shape)": lambda r, w: r.scene.add("a", w),
    "scene.add(sphere)": lambda r, w: r.scene.add("b", Sphere(radius=w)),
    "scene.add(box)": lambda r, w: r.scene.add("c", Box(size=w)),
    "scene.add(cylinder)": lambda r, w: r.scene.add(
        "d",
        Cylinder(radius=0.1, length=w),
    ),
    "scene.add(xyz)": lambda r, w: r.scene.add("e", BALL, xyz=w),
    "scene.add(mass)": lambda r, w: r.scene.add("f", BALL, mass=w),
    "scene.add(rgba)": lambda r, w: r.scene.add("g", BALL, rgba=w),
    "scene.remove": lambda r, w: r.scene.remove(w),
    "scene.place": lambda r, w: r.scene.place("none", w),
    "scene.pose": lambda r, w: r.scene.pose(w),
    "arm.pose": lambda r, w: r.arm.pose(tip=w),
    "arm.pose(tool)": lambda r, w: r.arm.pose(tool=w),
    "inverse_kinematics": lambda r, w: r.arm.inverse_kinematics(w),
    "inverse_kinematics(near)": lambda r, w: r.arm.inverse_kinematics(
        r.arm.pose(),
        near=w,
    ),
    "inverse_kinematics(branch)": lambda r, w: r.arm.inverse_kinematics(
        r.arm.pose(),
        branch=w,
    ),
    "move_to": lambda r, w: r.arm.move_to(w),
    "move_to(xyz)": lambda r, w: r.arm.move_to(Pose(xyz=w)),
    "move_to(speed)": lambda r, w: r.arm.move_to(r.arm.pose(), speed=w),
    "move_linear": lambda r, w: r.arm.move_linear(w),
    "move_linear(rpy)": lambda r, w: r.arm.move_linear(Pose(rpy=w)),
    "move_linear(speed)": lambda r, w: r.arm.move_linear(
        _below(r),
        speed=w,
    ),
    "move_linear(acceleration)": lambda r, w: r.arm.move_linear(
        _below(r),
        acceleration=w,
    ),
    "force_torque.start": lambda r, w: r.force_torque.start(w),
}
NEVER_RIGHT = ("object", "complex", "class")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some words are names of files."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def local() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


@pytest.fixture(scope="module")
def remote(
    local: tool0.Robot, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tool0.Robot]:
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("run")
        folder.chmod(0o700)
        patch.setenv("XDG_RUNTIME_DIR", str(folder))
        with serving(local), tool0.connect() as robot:
            yield robot


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("where", ["local", "remote"])
def test_a_wrong_value_is_an_error_of_ours(
    name: str, where: str, request: pytest.FixtureRequest
) -> None:
    robot: tool0.Robot = request.getfixturevalue(where)
    for kind, value in WRONG.items():
        robot.emergency_stop(engaged=False)
        robot.resume()
        robot.switch(start=[ARM], strict=False)
        if name == "run" and kind in ("fraction", "bool"):
            continue  # a duration is right
        try:
            CALLS[name](robot, value)
        except Tool0Error:
            continue
        assert kind not in NEVER_RIGHT or name == "when_finished", kind
    for item in robot.scene:
        robot.scene.remove(item)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda r: r.run("1"), "run: 'duration': Expected `float`, got `str`"),
        (lambda r: r.run(10**400), "run: 'duration': Number out of range"),
        (lambda r: r.step(1.5), "step: 'ticks': Expected `int`, got `float`"),
        (lambda r: r.controller(3), "controller: 'name': Expected `str`, got `int`"),
        (lambda r: r.load(None), "load_controller: 'name': Expected `str`"),
        (lambda r: _arm(r).follow(None), "follow: 'points': need TrajectoryPoints"),
        (
            lambda r: _arm(r).move({"elbow_joint": "x"}),
            "'positions': Expected `float`, got `str`",
        ),
        (
            lambda r: r.arm.move_linear(_below(r), acceleration=5e-324),
            "'acceleration': Expected `float` >= 1e-06",
        ),
        (
            lambda r: tool0.TrajectoryPoint([0.0], time_from_start=10**400),
            "time_from_start of a trajectory point must be numbers",
        ),
        (
            lambda r: tool0.TrajectoryPoint([0.0], 1.0),
            "velocities of a trajectory point must be numbers, got 1.0; for a time, "
            "write time_from_start=1.0",
        ),
        (lambda r: r.move_joints([1]), "'positions': Expected `mapping`, got `list`"),
        (lambda r: r.arms["left"], "no arm 'left'; valid: arm"),
        (lambda r: r.grippers["griper"], "no gripper 'griper'; did you mean 'gripper'"),
        (lambda r: r.cameras["wirst"], "no camera 'wirst'; did you mean 'wrist'?"),
    ],
)
def test_the_message_names_the_parameter(
    call: Callable[[Any], object], said: str, local: tool0.Robot
) -> None:
    with pytest.raises(Tool0Error) as error:
        call(local)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda r: r.start_recording(3), "start_recording: 'file': expected a path"),
        (lambda r: r.start_recording(cameras="wrist"), "'cameras': Expected `list`"),
        (lambda r: r.record("fast"), "rate fast Hz is outside [0.001, 500] Hz"),
        (
            lambda r: r.arm.control_box.set_payload(1.0, (1e300, 0.0, 0.0)),
            "'center_of_gravity': Expected `float` <= 1000.0",
        ),
        (lambda r: r.record(1e-320), "rate 1e-320 Hz is outside [0.001, 500] Hz"),
        (lambda r: r.controller("\ud800"), "'\\ud800' is no Unicode text"),
        (
            lambda r: r.channel.call(FollowTrajectory(controller=ARM, points=3)),
            "the points must be TrajectoryPoints, got 3",
        ),
    ],
)
def test_what_fuzzing_found_is_explained(
    call: Callable[[Any], object], said: str, local: tool0.Robot
) -> None:
    with pytest.raises(Tool0Error) as error:
        call(local)
    assert said in str(error.value)


def test_any_sequence_and_mapping_is_taken(local: tool0.Robot) -> None:
    names = {ARM: None}
    local.switch(stop=names.keys())
    local.switch(start=(ARM,))
    local.reset({"elbow_joint": np.float64(1.2)})
    arm = _arm(local)
    arm.move({"elbow_joint": np.int64(1)}).cancel()
    arm.follow(iter(POINTS), joint_names=list(arm.spec.joints)).cancel()
