import pytest
from raises_naming import raises_naming
from toy_robot import ARM, ToyRobot

from tool0.control.manager import Strictness
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Interface
from tool0.errors import ClaimError, ConfigError, ControlError, GoalRejectedError
from tool0.protocol.controllers import ControllerStatus, Role
from tool0.protocol.goals import GoalStatus
from tool0.protocol.trajectories import TrajectoryPoint

YAML = (
    ARM
    + """
group: {type: effort_controllers/JointGroupEffortController, joints: [slide, wheel]}
one: {type: effort_controllers/JointEffortController, joint: hip}
js: {type: joint_state_controller/JointStateController, publish_rate: 100}
typo: {type: effort_controllers/JointTrajectoryControler, joints: [hip]}
bare: {joints: [hip]}
"""
)
STRICT, BEST_EFFORT = Strictness.STRICT, Strictness.BEST_EFFORT
EFFORT = "hardware_interface/EffortJointInterface"


@pytest.fixture
def robot() -> ToyRobot:
    robot = ToyRobot(YAML)
    for name in ("arm", "group", "one", "js"):
        robot.manager.load(name)
    return robot


def switch(robot: ToyRobot, start=(), stop=(), strictness=STRICT):
    return robot.manager.switch(start, stop, strictness, robot.state)


def command(robot: ToyRobot, name: str, *values: float) -> None:
    robot.manager.running(name).command_joints(values)
    robot.manager.release_brakes(name, robot.state)


def states(robot: ToyRobot) -> dict[str, str]:
    return {item.name: item.state for item in robot.manager.list()}


def running(robot: ToyRobot) -> set[str]:
    return {name for name, state in states(robot).items() if state == "running"}


def test_list_is_in_load_order_with_types_and_claims(robot: ToyRobot) -> None:
    status = robot.manager.list()
    assert [item.name for item in status] == ["arm", "group", "one", "js"]
    assert status[1] == ControllerStatus(
        name="group",
        type="effort_controllers/JointGroupEffortController",
        role=Role.COMMAND,
        state="initialized",
        is_running=False,
        claimed=((EFFORT, ("slide", "wheel")),),
        command_interfaces=("slide/effort", "wheel/effort"),
    )
    assert status[3].claimed == ()


def test_starting_claims_and_stopping_releases(robot: ToyRobot) -> None:
    switch(robot, ["one", "js"])
    assert (states(robot)["one"], states(robot)["arm"]) == ("running", "initialized")
    assert robot.hardware.claimed == []  # limp by ROS's rules; the brake holds it
    command(robot, "one", 0.0)
    assert robot.hardware.claimed == ["hip"]
    switch(robot, ["arm"], ["one"])
    assert states(robot)["one"] == "stopped"
    assert robot.hardware.claimed == ["hip", "slide", "wheel"]
    robot.manager.stop_all(robot.state)
    assert robot.hardware.claimed == []
    assert running(robot) == set()


def test_after_a_restart_the_brakes_hold_until_the_next_command(
    robot: ToyRobot,
) -> None:
    switch(robot, ["one"])
    command(robot, "one", 3.0)
    robot.manager.restart(robot.state)
    assert robot.hardware.claimed == []
    command(robot, "one", 3.0)
    assert robot.hardware.claimed == ["hip"]


def test_updates_write_the_commands_of_running_controllers_only(
    robot: ToyRobot,
) -> None:
    switch(robot, ["one", "group"])
    robot.manager.running("one").command_joints(5.0)
    robot.manager.running("group").command_joints([6.0, 7.0])
    robot.tick()
    assert robot.hardware.command == [0.0, 5.0, 6.0, 7.0]
    robot.manager.running("one").command_joints(1.0)
    switch(robot, [], ["one"])
    robot.tick()
    assert robot.hardware.command[1] == 5.0


def test_two_controllers_on_one_joint_are_refused_by_name(robot: ToyRobot) -> None:
    switch(robot, ["arm"])
    for strictness in Strictness:
        with raises_naming(ClaimError, "'arm'", "'one'", "'hip'"):
            switch(robot, ["one"], [], strictness)
    assert running(robot) == {"arm"}


def test_strict_changes_nothing_unless_everything_fits(robot: ToyRobot) -> None:
    switch(robot, ["one"])
    command(robot, "one", 0.0)
    for start, stop, culprit in (
        (["nobody", "group"], [], "'nobody'"),
        (["group"], ["nobody"], "'nobody'"),
        (["group"], ["arm"], "'arm'"),
        (["one", "group"], [], "'one'"),
    ):
        with raises_naming(ControlError, culprit):
            switch(robot, start, stop)
        assert running(robot) == {"one"}
        assert robot.hardware.claimed == ["hip"]


def test_best_effort_skips_what_does_not_fit_and_says_so(robot: ToyRobot) -> None:
    switch(robot, ["one"])
    skipped = switch(robot, ["nobody", "group", "one"], ["arm"], BEST_EFFORT)
    assert running(robot) == {"one", "group"}
    assert len(skipped) == 3
    assert "nobody" in skipped[0]


def test_in_both_lists_a_stopped_controller_starts_and_a_running_one_is_refused(
    robot: ToyRobot,
) -> None:
    switch(robot, ["one"], ["one"], BEST_EFFORT)
    assert running(robot) == {"one"}
    for strictness in Strictness:
        with pytest.raises(ControlError):
            switch(robot, ["one"], ["one"], strictness)


def test_loading_twice_and_unloading_while_running_are_refused(robot) -> None:
    with pytest.raises(ControlError):
        robot.manager.load("arm")
    switch(robot, ["arm"])
    with pytest.raises(ControlError):
        robot.manager.unload("arm")
    switch(robot, [], ["arm"])
    robot.manager.unload("arm")
    assert "arm" not in states(robot)
    robot.manager.load("arm")


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("arms", "'arm'"),
        ("typo", "'effort_controllers/JointTrajectoryController'"),
        ("typo", "effort_controllers/GripperActionController"),
        ("bare", "type"),
    ],
)
def test_what_cannot_be_loaded_says_why(robot: ToyRobot, name: str, shown: str) -> None:
    with raises_naming(ConfigError, shown):
        robot.manager.load(name)
    assert name not in states(robot)


@pytest.mark.parametrize(
    ("joint", "interface", "shown"),
    [
        ("hep", Interface.EFFORT, "'hip'"),
        ("idle", Interface.EFFORT, "hip, slide"),
        ("hip", Interface.POSITION, "'hardware_interface/PositionJointInterface'"),
    ],
)
def test_a_joint_that_cannot_be_claimed_fails_the_load(
    joint: str, interface: Interface, shown: str
) -> None:
    yaml = f"c: {{type: effort_controllers/JointEffortController, joint: {joint}}}"
    with pytest.raises(ConfigError) as error:
        ToyRobot(yaml, interface).manager.load("c")
    assert error.value.location.line == 1
    assert shown in str(error.value)


def test_only_a_running_controller_can_be_asked(robot: ToyRobot) -> None:
    with raises_naming(GoalRejectedError, "initialized"):
        robot.manager.running("arm")
    for name in ("typo", "rm"):
        with raises_naming(ControlError, f"'{name}'"):
            robot.manager.running(name)


def test_a_restart_ends_goals_and_holds_where_it_is(robot: ToyRobot) -> None:
    switch(robot, ["arm", "js"])
    point = TrajectoryPoint([1, 1, 1], time_from_start=1.0)
    goal = robot.manager.running("arm").follow(TrajectoryGoal(points=[point]), 0.0)
    assert robot.hardware.claimed == ["hip", "slide", "wheel"]
    robot.run(0.5)
    robot.ticks, robot.position, robot.velocity = 0, [0.0, 0.2, 0.2, 0.2], [0.0] * 4
    robot.manager.restart(robot.state)
    assert goal.status is GoalStatus.PREEMPTED
    robot.run(1.0)
    assert robot.position[1:] == pytest.approx([0.2] * 3, abs=1e-6)
    assert running(robot) == {"arm", "js"}
    assert robot.hardware.claimed == ["hip", "slide", "wheel"]
