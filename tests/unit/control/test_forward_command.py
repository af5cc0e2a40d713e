import math

import pytest
from raises_naming import raises_naming
from toy_robot import ToyRobot

from tool0.description.model import Interface
from tool0.errors import ControlError

GROUP = "c: {{type: {0}_controllers/JointGroup{1}Controller, joints: [wheel, hip]}}"
SINGLE = "c: {{type: {0}_controllers/Joint{1}Controller, joint: slide}}"


@pytest.mark.parametrize("interface", list(Interface))
def test_a_group_forwards_in_the_order_of_its_joints_and_a_single_a_number(
    interface: Interface,
) -> None:
    kind = interface.name
    robot = ToyRobot(GROUP.format(kind.lower(), kind.title()), interface)
    robot.position = [0.1, 0.2, 0.3, 0.4]
    controller = robot.start("c")
    robot.tick()
    first = [0.0, 0.2, 0.0, 0.4] if kind == "POSITION" else [0.0] * 4
    assert robot.hardware.command == first
    controller.command_joints([1.0, 2.0])
    robot.tick()
    assert robot.hardware.command == [0.0, 2.0, 0.0, 1.0]
    single = ToyRobot(SINGLE.format(kind.lower(), kind.title()), interface)
    single.start("c").command_joints(1.5)
    single.tick()
    assert single.hardware.command == [0.0, 0.0, 1.5, 0.0]


@pytest.mark.parametrize(
    ("values", "shown"),
    [([1.0], "(1)"), ([1.0, 2.0, 3.0], "(3)"), ([1.0, math.nan], "'hip'")],
)
def test_a_bad_command_changes_nothing(values: list[float], shown: str) -> None:
    robot = ToyRobot(GROUP.format("effort", "Effort"))
    controller = robot.start("c")
    controller.command_joints([3.0, 4.0])
    with raises_naming(ControlError, shown):
        controller.command_joints(values)
    robot.tick()
    assert robot.hardware.command == [0.0, 4.0, 0.0, 3.0]


def test_a_position_is_followed_by_effort_within_the_limits() -> None:
    robot = ToyRobot(
        "c: {type: effort_controllers/JointPositionController, joint: hip,"
        " pid: {p: 400, d: 40}}"
    )
    controller = robot.start("c")
    robot.run(0.1)
    assert robot.position[1] == 0.0
    controller.command_joints(99.0)
    robot.run(3.0)
    assert robot.position[1] == pytest.approx(6.0, abs=1e-3)


def test_a_continuous_joint_goes_the_shortest_way_to_a_position() -> None:
    robot = ToyRobot(
        "c: {type: effort_controllers/JointGroupPositionController,"
        " joints: [wheel, hip],"
        " wheel: {pid: {p: 400, d: 40}}, hip: {pid: {p: 400, d: 40}}}"
    )
    controller = robot.start("c")
    controller.command_joints([5.0, 5.0])
    robot.run(3.0)
    assert robot.position[1] == pytest.approx(5.0, abs=1e-3)
    assert robot.position[3] == pytest.approx(5.0 - math.tau, abs=1e-3)


@pytest.mark.parametrize(
    ("interface", "kind"),
    [(Interface.EFFORT, "Velocity"), (Interface.VELOCITY, "Position")],
)
def test_other_quantities_are_followed_by_a_pid(
    interface: Interface, kind: str
) -> None:
    package = interface.name.lower()
    robot = ToyRobot(
        f"c: {{type: {package}_controllers/Joint{kind}Controller, joint: hip,"
        " pid: {p: 9}}",
        interface,
    )
    controller = robot.start("c")
    controller.command_joints(0.7)
    robot.run(3.0)
    followed = robot.velocity if kind == "Velocity" else robot.position
    assert followed[1] == pytest.approx(0.7)
