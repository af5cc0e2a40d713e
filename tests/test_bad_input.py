"""Bad input: a clear error that names the thing, and the robot goes on undisturbed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from flat_options import configured
from served import use_folder
from ur5_rig import ARM, AWAY, GRIPPER, HOME, POST, point, positions, worst_departure

import tool0
from tool0.api.controller import ControllerHandle
from tool0.control.goal import GoalStatus
from tool0.errors import (
    ClaimError,
    ConfigError,
    ControlError,
    DescriptionError,
    GoalRejectedError,
    ModelError,
    TransportError,
)

NAN = math.nan
INVALID_GOAL = GoalRejectedError.INVALID_GOAL
INVALID_JOINTS = GoalRejectedError.INVALID_JOINTS

# ---- goals: refused, and what runs goes on ------------------------------------------

Send = Callable[[ControllerHandle], object]

BAD_GOALS: dict[str, tuple[Send, int, str]] = {
    "unknown joint": (
        lambda arm: arm.follow(
            [point(AWAY, 1.0)],
            joint_names=["elbow", *list(map(str, range(5)))],
        ),
        INVALID_JOINTS,
        "unknown joint 'elbow'; did you mean 'elbow_joint'",
    ),
    "too few joints": (
        lambda arm: arm.follow([point([0.0], 1.0)], joint_names=["elbow_joint"]),
        INVALID_JOINTS,
        "names 1 of 6 joints and lacks shoulder_pan_joint",
    ),
    "a joint twice": (
        lambda arm: arm.follow([point(AWAY, 1.0)], joint_names=["elbow_joint"] * 6),
        INVALID_JOINTS,
        "'elbow_joint' is named twice",
    ),
    "no joint names": (
        lambda arm: arm.follow([point(AWAY, 1.0)], joint_names=[]),
        INVALID_JOINTS,
        "names 0 of 6 joints",
    ),
    "five positions": (
        lambda arm: arm.follow([point(AWAY[:5], 1.0)]),
        INVALID_GOAL,
        "Point 0 has 5 positions for 6 joints",
    ),
    "seven positions": (
        lambda arm: arm.follow([point((*AWAY, 0.0), 1.0)]),
        INVALID_GOAL,
        "Point 0 has 7 positions for 6 joints",
    ),
    "no positions": (
        lambda arm: arm.follow([point((), 1.0)]),
        INVALID_GOAL,
        "Point 0 has 0 positions",
    ),
    "five velocities": (
        lambda arm: arm.follow([point(AWAY, 1.0, [0.0] * 5)]),
        INVALID_GOAL,
        "Point 0 has 5 velocities for 6 joints",
    ),
    "NaN position": (
        lambda arm: arm.follow([point((*AWAY[:5], NAN), 1.0)]),
        INVALID_GOAL,
        "positions nan for joint 'wrist_3_joint'",
    ),
    "infinite velocity": (
        lambda arm: arm.follow([point(AWAY, 1.0, [math.inf] * 6)]),
        INVALID_GOAL,
        "velocities inf for joint 'shoulder_pan_joint'",
    ),
    "NaN time": (
        lambda arm: arm.follow([point(AWAY, NAN)]),
        INVALID_GOAL,
        "point 0 has time_from_start nan",
    ),
    "NaN stamp": (
        lambda arm: arm.follow([point(AWAY, 1.0)], stamp=NAN),
        INVALID_GOAL,
        "stamp nan",
    ),
    "NaN tolerance": (
        lambda arm: arm.follow([point(AWAY, 1.0)], path_tolerance={"elbow_joint": NAN}),
        INVALID_GOAL,
        "nan.* of 'elbow_joint'",
    ),
    "NaN grace": (
        lambda arm: arm.follow([point(AWAY, 1.0)], goal_time_tolerance=NAN),
        INVALID_GOAL,
        "goal_time_tolerance nan",
    ),
    "tolerance of an unknown joint": (
        lambda arm: arm.follow([point(AWAY, 1.0)], goal_tolerance={"elbow": 0.1}),
        INVALID_JOINTS,
        "tolerance for unknown joint 'elbow'; did you mean 'elbow_joint'",
    ),
    "times that stand still": (
        lambda arm: arm.follow([point(AWAY, 1.0), point(HOME, 1.0)]),
        INVALID_GOAL,
        "not strictly increasing in time. Point 1 is at 1.0 s",
    ),
    "times that run back": (
        lambda arm: arm.follow([point(AWAY, 2.0), point(HOME, 1.0)]),
        INVALID_GOAL,
        "not strictly increasing in time",
    ),
    "all points in the past": (
        lambda arm: arm.follow([point(AWAY, 0.1), point(HOME, 0.2)], stamp=0.05),
        INVALID_GOAL,
        r"Dropping all 2 trajectory point\(s\).*\n.*0\.250s in the past",
    ),
    "a time of zero": (
        lambda arm: arm.follow([point(AWAY, 0.0)]),
        INVALID_GOAL,
        r"Dropping all 1 trajectory point\(s\)",
    ),
    "beyond a limit": (
        lambda arm: arm.follow([point((9.0, *AWAY[1:]), 1.0)]),
        INVALID_GOAL,
        "point 0 wants joint 'shoulder_pan_joint' at 9, which is beyond its limits",
    ),
    "words for numbers": (
        lambda arm: arm.follow([point(["a"] * 6, 1.0)]),  # type: ignore[list-item]
        INVALID_GOAL,
        "positions of a trajectory point must be numbers",
    ),
    "a bad command without an outcome": (
        lambda arm: arm.command_trajectory([point(AWAY[:5], 1.0)]),
        INVALID_GOAL,
        "Point 0 has 5 positions",
    ),
}


@pytest.mark.parametrize(("send", "code", "says"), BAD_GOALS.values(), ids=BAD_GOALS)
def test_a_bad_goal_is_refused_and_the_running_one_is_untouched(
    send: Send, code: int, says: str
) -> None:
    states = []
    for sends in (False, True):
        with tool0.bringup(realtime=False) as robot:
            arm = robot.controller(ARM)
            goal = arm.follow([point(AWAY, 1.0, [0.0] * 6)])
            robot.run(0.5)
            if sends:
                with pytest.raises(GoalRejectedError, match=says) as caught:
                    send(arm)
                assert caught.value.code == code
                assert isinstance(caught.value, tool0.Tool0Error)
            assert goal.wait(5.0).status is GoalStatus.SUCCEEDED
            states.append((robot.time, robot.joint_state.position))
    assert states[0] == states[1]  # to the bit as if nobody had asked


def test_a_goal_without_points_is_no_error_but_a_stop() -> None:
    with tool0.bringup(realtime=False) as robot:
        assert robot.controller(ARM).follow([]).wait(5.0).status is GoalStatus.SUCCEEDED
        assert worst_departure(robot, 2.0) < 0.02


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def test_a_goal_to_a_stopped_controller_says_to_start_it(robot: tool0.Robot) -> None:
    robot.switch(stop=[ARM])
    robot.run(0.5)
    before = positions(robot)
    arm = robot.controller(ARM)
    for send in (
        lambda: arm.follow([point(AWAY, 1.0)]),
        lambda: arm.command_trajectory([point(AWAY, 1.0)]),
        lambda: arm.state,
        lambda: arm.query_state(1.0),
    ):
        with pytest.raises(
            GoalRejectedError, match=f"'{ARM}' is stopped, not running; start it first"
        ):
            send()
    assert worst_departure(robot, 2.0, before) <= 1e-3
    robot.switch(start=[ARM])


def test_two_controllers_on_one_joint_are_refused(robot: tool0.Robot) -> None:
    other = "joint_group_eff_controller"
    goal = robot.controller(ARM).follow([point(AWAY, 1.0)])
    with pytest.raises(ClaimError, match=f"'{ARM}' and '{other}' both claim joint '"):
        robot.switch(start=[other])
    assert goal.wait(5.0).status is GoalStatus.SUCCEEDED
    with pytest.raises(ClaimError, match="both claim joint"):
        tool0.bringup(realtime=False, controllers=[ARM, other])


@pytest.mark.parametrize(
    ("do", "says"),
    [
        (lambda r: r.load("nobody"), "unknown controller 'nobody'"),
        (lambda r: r.load(ARM), "already loaded"),
        (lambda r: r.unload(ARM), "still running; stop it first"),
        (lambda r: r.switch(start=[ARM]), "already running"),
        (lambda r: r.switch(stop=["joint_group_eff_controller"]), "not running"),
        (lambda r: r.switch(start=["gripper_controler"]), f"did you mean '{GRIPPER}'"),
        (lambda r: r.controller(GRIPPER).command([0.1]), "JointTrajectoryController"),
        (lambda r: r.controller(ARM).command_gripper(0.1), "GripperActionController"),
        (
            lambda r: r.reset({"elbow_joint": NAN}),
            "position nan of joint 'elbow_joint'",
        ),
        (lambda r: r.reset({"elbow": 0.0}), "did you mean 'elbow_joint'"),
        (lambda r: r.pose("tol0"), "did you mean 'tool0'"),
    ],
)
def test_a_bad_request_is_refused_and_the_motion_goes_on(
    robot: tool0.Robot, do: Callable[[tool0.Robot], object], says: str
) -> None:
    robot.reset()
    goal = robot.controller(ARM).follow([point(AWAY, 1.0)])
    robot.run(0.3)
    with pytest.raises(tool0.Tool0Error, match=says):
        do(robot)
    assert goal.wait(5.0).status is GoalStatus.SUCCEEDED


# ---- files: refused before anything runs --------------------------------------------


def edited(folder: Path, old: str, new: str) -> Path:
    text = POST.read_text()
    assert old in text
    path = folder / "edited.yaml"
    path.write_text(text.replace(old, new, 1))
    return path


def line_of(path: Path, text: str) -> int:
    lines = path.read_text().splitlines()
    return 1 + next(i for i, line in enumerate(lines) if text in line)


def test_an_unknown_controller_type_names_file_and_line(tmp_path: Path) -> None:
    path = edited(
        tmp_path, "effort_controllers/JointTraj", "effort_controllers/JntTraj"
    )
    line = line_of(path, "JntTraj")
    match = rf"edited\.yaml:{line}: .*effort_controllers/JntTrajectoryController.*"
    with pytest.raises(ConfigError, match=match + "did you mean") as caught:
        tool0.bringup(realtime=False, controllers_file=path)
    assert caught.value.location is not None
    assert caught.value.location.line == line


def test_yaml_that_does_not_parse_names_file_and_line(tmp_path: Path) -> None:
    path = edited(tmp_path, "  constraints:", "  constraints: [")
    with pytest.raises(ConfigError, match=r"edited\.yaml:\d+: "):
        tool0.bringup(realtime=False, controllers_file=path)


def test_missing_gains_name_file_line_and_joint(tmp_path: Path) -> None:
    gains = "    elbow_joint: {p: 2000,  d: 20, i: 1, i_clamp: 1}\n"
    path = edited(tmp_path, gains, "")
    with pytest.raises(ConfigError, match=r"edited\.yaml:\d+: .*elbow_joint"):
        tool0.bringup(realtime=False, controllers_file=path)


def test_a_controller_that_cannot_be_loaded_later_leaves_the_others_alone(
    tmp_path: Path,
) -> None:
    path = edited(
        tmp_path, "effort_controllers/JointGroup", "effort_controllers/JntGroup"
    )
    with tool0.bringup(
        realtime=False,
        controllers_file=path,
        control=tool0.ControlConfig(stopped_controllers=[]),
    ) as robot:
        goal = robot.controller(ARM).follow([point(AWAY, 1.0)])
        robot.run(0.2)
        with pytest.raises(ConfigError, match=r"edited\.yaml:\d+"):
            robot.load("joint_group_eff_controller")
        assert goal.wait(5.0).status is GoalStatus.SUCCEEDED


def test_a_file_that_is_not_there_is_named() -> None:
    for option in ("controllers_file", "robot", "joint_limit_params"):
        with pytest.raises(tool0.Tool0Error, match="nowhere"):
            tool0.bringup(**configured(realtime=False, **{option: "nowhere.yaml"}))


@pytest.mark.parametrize(
    ("options", "kind", "says"),
    [
        ({"arm": "ur55"}, DescriptionError, "unknown arm 'ur55'; did you mean 'ur5'"),
        ({"engine": "mujocoo"}, tool0.Tool0Error, "did you mean 'mujoco'"),
        ({"initial_pose": "hme"}, ConfigError, "did you mean 'home'"),
        ({"initial_pose": {"elbow_joint": 9.0}}, ModelError, "outside"),
        ({"initial_pose": {"left_inner_knuckle_joint": 0.1}}, ModelError, "mimics"),
        ({"controllers": "nobody"}, ConfigError, "no controller 'nobody'"),
        ({"dt": 0.0}, ConfigError, "step must be above 0"),
        ({"dt": NAN}, ConfigError, "step must be above 0"),
        ({"control_period": 0.0015}, ConfigError, "no whole multiple"),
        ({"spawn_z": NAN}, ConfigError, "ground must be finite"),
        ({"realtime": True, "speed": 0.0}, ControlError, "speed must be in"),
        ({"realtime": True, "speed": NAN}, ControlError, "speed must be in"),
        ({"mount_xyz": (NAN, 0.0, 0.0)}, tool0.Tool0Error, "nan"),
    ],
    ids=str,
)
def test_a_bad_option_is_refused_by_name(
    options: dict[str, object], kind: type[Exception], says: str
) -> None:
    with pytest.raises(kind, match=says):
        tool0.bringup(**configured(**{"realtime": False, **options}))


CELL = """<robot name="cell">
  <link name="world"/>
  <joint name="swing" type="revolute">
    <parent link="world"/><child link="arm"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/>
  </joint>
  <link name="arm">
    <inertial><mass value="1"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <collision><geometry><mesh filename="{mesh}"/></geometry></collision>
  </link>
</robot>
"""


@pytest.mark.parametrize("content", [b"", b"solid", b"no mesh at all" * 30])
@pytest.mark.parametrize("suffix", [".stl", ".obj"])
def test_an_unreadable_mesh_is_named(
    tmp_path: Path, suffix: str, content: bytes
) -> None:
    mesh = tmp_path / f"arm{suffix}"
    mesh.write_bytes(content)
    cell = tmp_path / "cell.urdf"
    cell.write_text(CELL.format(mesh=mesh))
    with pytest.raises(ModelError, match=rf"arm\{suffix}"):
        tool0.bringup(realtime=False, robot=cell)


def test_a_missing_mesh_names_file_and_line(tmp_path: Path) -> None:
    cell = tmp_path / "cell.urdf"
    cell.write_text(CELL.format(mesh="nowhere/arm.stl"))
    with pytest.raises(tool0.Tool0Error, match=r"cell\.urdf:10: .*nowhere/arm\.stl"):
        tool0.bringup(realtime=False, robot=cell)


def test_a_name_in_use_is_refused_and_the_first_bringup_goes_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from tool0.api.address import Claim

    use_folder(monkeypatch, tmp_path)
    with ExitStack() as stack:
        robot = stack.enter_context(tool0.bringup(realtime=False))
        claim = Claim("cell")
        stack.callback(claim.close)
        goal = robot.controller(ARM).follow([point(AWAY, 0.5)])
        with pytest.raises(TransportError, match="'cell'"):
            Claim("cell")
        assert goal.wait(5.0).status is GoalStatus.SUCCEEDED


def test_every_error_is_a_tool0_error() -> None:
    from tool0 import errors

    kinds = [
        value
        for value in vars(errors).values()
        if isinstance(value, type) and issubclass(value, Exception)
    ]
    assert len(kinds) > 10
    assert all(issubclass(kind, tool0.Tool0Error) for kind in kinds)


def test_the_robot_holds_after_a_storm_of_nonsense(robot: tool0.Robot) -> None:
    robot.reset()
    robot.run(1.0)
    before = positions(robot)
    arm = robot.controller(ARM)
    rng = np.random.default_rng(5)
    n_refused = 0
    for _ in range(200):
        numbers = rng.choice([NAN, math.inf, -1e9, 1e300], size=rng.integers(0, 9))
        times = rng.choice([0.5, 1.0, NAN, -1.0], size=rng.integers(1, 4))
        try:
            arm.follow([point(numbers.tolist(), float(time)) for time in times])
        except GoalRejectedError:
            n_refused += 1
    assert n_refused == 200
    assert worst_departure(robot, 1.0, before) <= 1e-3


def test_catalogue_options_are_refused_for_a_robot_of_ones_own() -> None:
    cell = Path(__file__).parent.parent / "examples" / "cell" / "two_arms.urdf.xacro"
    with pytest.raises(ConfigError) as error:
        tool0.bringup(robot=cell, arm="ur5", realtime=False)
    assert "arm" in str(error.value)
