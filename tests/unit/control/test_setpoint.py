import pickle

import pytest
from toy_robot import ARM, ToyRobot

from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Interface
from tool0.protocol.trajectories import TrajectoryPoint

OTHERS = """
js: {type: joint_state_controller/JointStateController, publish_rate: 100}
effort: {type: effort_controllers/JointEffortController, joint: hip}
velocity: {type: velocity_controllers/JointVelocityController, joint: hip}
hand:
  type: effort_controllers/GripperActionController
  joint: hip
  gains: {hip: {p: 400, d: 40}}
servo:
  type: effort_controllers/JointGroupPositionController
  joints: [wheel, hip]
  hip: {pid: {p: 400, d: 40}}
  wheel: {pid: {p: 400, d: 40}}
"""


def to(*positions: float, time: float = 1.0) -> TrajectoryGoal:
    rest = [0.0] * len(positions)
    return TrajectoryGoal(
        points=[TrajectoryPoint(positions, rest, rest, time_from_start=time)]
    )


def test_of_one_joint_it_says_the_same_as_of_all() -> None:
    robot = ToyRobot(ARM)
    robot.start("arm").follow(to(1.0, 0.5, -0.2), robot.time)
    robot.run(0.4)
    assert robot.manager.setpoints()["arm"].target() == pytest.approx((1.0, 0.5, -0.2))
    other = ToyRobot(ARM + OTHERS)
    other.start("servo", "js").command_joints([3.0, 1.0])
    other.manager.load("hand")
    for manager in (robot.manager, other.manager):
        (setpoint,) = manager.setpoints().values()
        now, end = setpoint.state().desired.positions, setpoint.target()
        for k, name in enumerate(setpoint.joint_names):
            assert setpoint.desired_and_target(name) == (now[k], end[k])
        assert setpoint.desired_and_target("nobody") is None


def test_what_it_says_stays_while_the_controller_goes_on() -> None:
    robot = ToyRobot(ARM)
    controller = robot.start("arm")
    controller.follow(to(1.0, 0.5, -0.2), robot.time)
    robot.run(0.4)
    setpoint = controller.setpoint()
    said = pickle.dumps((setpoint.state(), setpoint.target()))
    for go_on in (
        lambda: None,
        lambda: controller.command(to(-1.0, -0.5, 0.2), robot.time),
        lambda: robot.manager.restart(robot.state),
    ):
        go_on()
        for _ in range(50):
            robot.tick()
            now = pickle.dumps((setpoint.state(), setpoint.target()))
            assert now == said


def test_a_gripper_wants_its_command_from_the_start() -> None:
    robot = ToyRobot(OTHERS)
    robot.position[1] = 0.2
    controller = robot.start("hand")
    assert controller.setpoint().target() == (0.2,)
    controller.drive(0.5, None, robot.time)
    robot.tick()
    state = controller.setpoint().state()
    assert state.joint_names == ("hip",)
    assert state.desired.positions == controller.setpoint().target() == (0.5,)
    assert state.error.positions == pytest.approx((0.3,))
    assert state.desired.velocities == (0.0,)


def test_a_position_forwarder_wants_nothing_before_its_first_command() -> None:
    robot = ToyRobot(OTHERS)
    controller = robot.start("servo")
    assert controller.setpoint() is None
    controller.command_joints([3.0, 100.0])
    robot.position = [0.0, 5.0, 0.0, -3.0]
    robot.tick()
    assert controller.setpoint().joint_names == ("wheel", "hip")
    assert controller.setpoint().target() == (3.0, 6.0), "within the limits"
    errors = controller.setpoint().state().error.positions
    assert errors == pytest.approx((6.0 - 6.283185307, 1.0)), "the shortest way round"


@pytest.mark.parametrize("name", ["effort", "velocity"])
def test_raw_efforts_and_velocities_want_no_position(name: str) -> None:
    robot = ToyRobot(OTHERS, Interface[name.upper()])
    robot.start(name).command_joints(1.0)
    robot.tick()
    assert robot.manager.setpoints() == {}
