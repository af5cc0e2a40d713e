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
from tool0.errors import (
    ClaimError,
    ConfigError,
    ControlError,
    DescriptionError,
    GoalRejectedError,
    ModelError,
    TransportError,
)
from tool0.protocol.goals import GoalStatus

NAN = math.nan
INVALID_GOAL = GoalRejectedError.INVALID_GOAL
INVALID_JOINTS = GoalRejectedError.INVALID_JOINTS

# ---- goals: refused, and what runs goes on ------------------------------------------

Send = Callable[[ControllerHandle], object]

BAD_GOALS: dict[str, tuple[Send, int | None, str]] = {
    "unknown joint": (
        lambda arm: arm.follow(
            [point(AWAY, 1.0)],
            joint_names=["elbow", *list(map(str, range(5)))],
        ),
        INVALID_JOINTS,
        "'elbow_joint'",
    ),
    "too few joints": (
        lambda arm: arm.follow([point([0.0], 1.0)], joint_names=["elbow_joint"]),
        INVALID_JOINTS,
        "shoulder_pan_joint",
    ),
    "a joint twice": (
        lambda arm: arm.follow([point(AWAY, 1.0)], joint_names=["elbow_joint"] * 6),
        INVALID_JOINTS,
        "'elbow_joint'",
    ),
    "no joint names": (
        lambda arm: arm.follow([point(AWAY, 1.0)], joint_names=[]),
        INVALID_JOINTS,
        "0 of 6",
    ),
    "five positions": (
        lambda arm: arm.follow([point(AWAY[:5], 1.0)]),
        INVALID_GOAL,
        "5 positions",
    ),
    "seven positions": (
        lambda arm: arm.follow([point((*AWAY, 0.0), 1.0)]),
        INVALID_GOAL,
        "7 positions",
    ),
    "no positions": (
        lambda arm: arm.follow([point((), 1.0)]),
        INVALID_GOAL,
        "0 positions",
    ),
    "five velocities": (
        lambda arm: arm.follow([point(AWAY, 1.0, [0.0] * 5)]),
        INVALID_GOAL,
        "5 velocities",
    ),
    "NaN position": (
        lambda arm: arm.follow([point((*AWAY[:5], NAN), 1.0)]),
        INVALID_GOAL,
        "'wrist_3_joint'",
    ),
    "infinite velocity": (
        lambda arm: arm.follow([point(AWAY, 1.0, [math.inf] * 6)]),
        INVALID_GOAL,
        "'shoulder_pan_joint'",
    ),
    "NaN time": (
        lambda arm: arm.follow([point(AWAY, NAN)]),
        INVALID_GOAL,
        "time_from_start nan",
    ),
    "NaN stamp": (
        lambda arm: arm.follow([point(AWAY, 1.0)], stamp=NAN),
        None,
        "'stamp'",
    ),
    "NaN tolerance": (
        lambda arm: arm.follow([point(AWAY, 1.0)], path_tolerance={"elbow_joint": NAN}),
        INVALID_GOAL,
        "'elbow_joint'",
    ),
    "NaN grace": (
        lambda arm: arm.follow([point(AWAY, 1.0)], goal_time_tolerance=NAN),
        None,
        "'goal_time_tolerance'",
    ),
    "tolerance of an unknown joint": (
        lambda arm: arm.follow([point(AWAY, 1.0)], goal_tolerance={"elbow": 0.1}),
        INVALID_JOINTS,
        "'elbow_joint'",
    ),
    "times that stand still": (
        lambda arm: arm.follow([point(AWAY, 1.0), point(HOME, 1.0)]),
        INVALID_GOAL,
        "1.0 s",
    ),
    "times that run back": (
        lambda arm: arm.follow([point(AWAY, 2.0), point(HOME, 1.0)]),
        INVALID_GOAL,
        "1.0 s",
    ),
    "all points in the past": (
        lambda arm: arm.follow([point(AWAY, 0.1), point(HOME, 0.2)], stamp=0.05),
        INVALID_GOAL,
        "0.250s",
    ),
    "a time of zero": (
        lambda arm: arm.follow([tool0.TrajectoryPoint(AWAY)]),
        INVALID_GOAL,
        "time_from_start is missing or 0",
    ),
    "beyond a limit": (
        lambda arm: arm.follow([point((9.0, *AWAY[1:]), 1.0)]),
        INVALID_GOAL,
        "'shoulder_pan_joint'",
    ),
    "words for numbers": (
        lambda arm: arm.follow([point(["a"] * 6, 1.0)]),  # type: ignore[list-item]
        INVALID_GOAL,
        "positions",
    ),
    "a bad command without an outcome": (
        lambda arm: arm.command_trajectory([point(AWAY[:5], 1.0)]),
        INVALID_GOAL,
        "5 positions",
    ),
}


@pytest.mark.parametrize(("send", "code", "named"), BAD_GOALS.values(), ids=BAD_GOALS)
def test_a_bad_goal_is_refused_and_the_running_one_is_untouched(
    send: Send, code: int | None, named: str
) -> None:
    states = []
    for sends in (False, True):
        with tool0.bringup(realtime=False) as robot:
            arm = robot.controller(ARM)
            goal = arm.follow([point(AWAY, 1.0, [0.0] * 6)])
            robot.run(0.5)
            if sends:
                with pytest.raises(tool0.Tool0Error) as caught:
                    send(arm)
                assert named in str(caught.value)
                assert getattr(caught.value, "code", None) == code
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
        with pytest.raises(GoalRejectedError) as caught:
            send()
        assert f"'{ARM}' is stopped" in str(caught.value)
    assert worst_departure(robot, 2.0, before) <= 1e-3
    robot.switch(start=[ARM])


def test_two_controllers_on_one_joint_are_refused(robot: tool0.Robot) -> None:
    other = "joint_group_eff_controller"
    goal = robot.controller(ARM).follow([point(AWAY, 1.0)])
    with pytest.raises(ClaimError) as caught:
        robot.switch(start=[other])
    assert f"'{ARM}' and '{other}'" in str(caught.value)
    assert goal.wait(5.0).status is GoalStatus.SUCCEEDED
    with pytest.raises(ClaimError):
        tool0.bringup(realtime=False, controllers=[ARM, other])


@pytest.mark.parametrize(
    ("do", "named"),
    [
        (lambda r: r.load("nobody"), "'nobody'"),
        (lambda r: r.load(ARM), f"'{ARM}'"),
        (lambda r: r.unload(ARM), f"'{ARM}'"),
        (lambda r: r.switch(start=[ARM]), f"'{ARM}'"),
        (
            lambda r: r.switch(stop=["joint_group_eff_controller"]),
            "'joint_group_eff_controller'",
        ),
        (lambda r: r.switch(start=["gripper_controler"]), f"'{GRIPPER}'"),
        (lambda r: r.controller(GRIPPER).command([0.1]), "JointTrajectoryController"),
        (lambda r: r.controller(ARM).command_gripper(0.1), "GripperActionController"),
        (
            lambda r: r.reset({"elbow_joint": NAN}),
            "'position'",
        ),
        (lambda r: r.reset({"elbow": 0.0}), "'elbow_joint'"),
        (lambda r: r.pose("tol0"), "'tool0'"),
    ],
)
def test_a_bad_request_is_refused_and_the_motion_goes_on(
    robot: tool0.Robot, do: Callable[[tool0.Robot], object], named: str
) -> None:
    robot.reset()
    goal = robot.controller(ARM).follow([point(AWAY, 1.0)])
    robot.run(0.3)
    with pytest.raises(tool0.Tool0Error) as caught:
        do(robot)
    assert named in str(caught.value)
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
    with pytest.raises(ConfigError) as caught:
        tool0.bringup(realtime=False, controllers_file=path)
    assert caught.value.location is not None
    assert caught.value.location.line == line


def test_yaml_that_does_not_parse_names_file_and_line(tmp_path: Path) -> None:
    path = edited(tmp_path, "  constraints:", "  constraints: [")
    with pytest.raises(ConfigError) as caught:
        tool0.bringup(realtime=False, controllers_file=path)
    assert "edited.yaml:" in str(caught.value)


def test_missing_gains_name_file_line_and_joint(tmp_path: Path) -> None:
    gains = "    elbow_joint: {p: 2000,  d: 20, i: 1, i_clamp: 1}\n"
    path = edited(tmp_path, gains, "")
    with pytest.raises(ConfigError) as caught:
        tool0.bringup(realtime=False, controllers_file=path)
    assert "edited.yaml:" in str(caught.value)
    assert "elbow_joint" in str(caught.value)


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
        with pytest.raises(ConfigError) as caught:
            robot.load("joint_group_eff_controller")
        assert "edited.yaml:" in str(caught.value)
        assert goal.wait(5.0).status is GoalStatus.SUCCEEDED


def test_a_file_that_is_not_there_is_named() -> None:
    for option in ("controllers_file", "robot", "joint_limit_params"):
        with pytest.raises(tool0.Tool0Error) as caught:
            tool0.bringup(**configured(realtime=False, **{option: "nowhere.yaml"}))
        assert "nowhere.yaml" in str(caught.value)


@pytest.mark.parametrize(
    ("options", "kind", "named"),
    [
        ({"arm": "ur55"}, DescriptionError, "'ur5'"),
        ({"engine": "mujocoo"}, tool0.Tool0Error, "'mujoco'"),
        ({"initial_pose": "hme"}, ConfigError, "'home'"),
        ({"initial_pose": {"elbow_joint": 9.0}}, ModelError, "9.0"),
        (
            {"initial_pose": {"left_inner_knuckle_joint": 0.1}},
            ModelError,
            "'left_inner_knuckle_joint'",
        ),
        ({"controllers": "nobody"}, ConfigError, "'nobody'"),
        ({"dt": 0.0}, ConfigError, "0.0"),
        ({"dt": NAN}, ConfigError, "nan"),
        ({"control_period": 0.0015}, ConfigError, "0.0015"),
        ({"spawn_z": NAN}, ConfigError, "nan"),
        ({"realtime": True, "speed": 0.0}, ControlError, "0.0"),
        ({"realtime": True, "speed": NAN}, ControlError, "nan"),
        ({"mount_xyz": (NAN, 0.0, 0.0)}, tool0.Tool0Error, "nan"),
    ],
    ids=str,
)
def test_a_bad_option_is_refused_by_name(
    options: dict[str, object], kind: type[Exception], named: str
) -> None:
    with pytest.raises(kind) as caught:
        tool0.bringup(**configured(**{"realtime": False, **options}))
    assert named in str(caught.value)


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
    with pytest.raises((ModelError, DescriptionError)) as caught:
        tool0.bringup(realtime=False, robot=cell)
    assert mesh.name in str(caught.value)


def test_a_missing_mesh_names_file_and_line(tmp_path: Path) -> None:
    cell = tmp_path / "cell.urdf"
    cell.write_text(CELL.format(mesh="nowhere/arm.stl"))
    with pytest.raises(tool0.Tool0Error) as caught:
        tool0.bringup(realtime=False, robot=cell)
    assert "cell.urdf:10: " in str(caught.value)
    assert "nowhere/arm.stl" in str(caught.value)


def test_a_name_in_use_is_refused_and_the_first_bringup_goes_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from tool0.protocol.address import Claim

    use_folder(monkeypatch, tmp_path)
    with ExitStack() as stack:
        robot = stack.enter_context(tool0.bringup(realtime=False))
        claim = Claim("cell")
        stack.callback(claim.close)
        goal = robot.controller(ARM).follow([point(AWAY, 0.5)])
        with pytest.raises(TransportError) as caught:
            Claim("cell")
        assert "'cell'" in str(caught.value)
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
