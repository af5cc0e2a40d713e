"""A joint a little beyond its limit is brought back by every way to move."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

import tool0
from tool0.description.model import RECOVERABLE
from tool0.errors import ControlError
from tool0.motion.moves import Move
from tool0.motion.planner import MovePlanner
from tool0.protocol.arm_motion import (
    ExecutePath,
    ReadArmMotion,
    ServoJoints,
    SpeedJoints,
    StartFreedrive,
    TakeArm,
    path_request,
)
from tool0.protocol.motion import MoveJoints, SteerJoints
from tool0.protocol.trajectories import TrajectoryPoint

PAN = "shoulder_pan_joint"
LIMIT = 6.283185307179586
BEYOND = 0.03
ARM_CONTROLLER = "eff_joint_traj_controller"


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    """Return a robot that rests beyond a limit, as after a stop that came too late."""
    with tool0.bringup(realtime=False, initial_pose={PAN: LIMIT}) as robot:
        robot.emergency_stop()
        engine = robot.simulation.engine
        engine.data.joint(PAN).qpos[0] = LIMIT + BEYOND  # type: ignore[attr-defined]
        robot.run(0.01)
        robot.arm.control_box.set_safety_limits(enabled=True)
        robot.emergency_stop(False)
        assert pan(robot) > LIMIT + 0.02
        yield robot


def pan(robot: tool0.Robot) -> float:
    return robot.joint_state.position[PAN]


def move(robot: tool0.Robot) -> None:
    robot.move_joints({PAN: 6.0})


def move_within(robot: tool0.Robot) -> None:
    robot.channel.call(MoveJoints(positions={PAN: 6.0}, duration=1.0))


def jog(robot: tool0.Robot) -> None:
    robot.channel.call(SteerJoints(controller=ARM_CONTROLLER, positions={PAN: 6.0}))


def goal_from_there(robot: tool0.Robot) -> None:
    here = list(robot.arm.joints.values())
    there = [6.0, *here[1:]]
    points = [TrajectoryPoint(here, [0.0] * 6, None, 0.5)]
    points += [TrajectoryPoint(there, [0.0] * 6, None, 1.5)]
    names = robot.arm.joint_names
    robot.controller(ARM_CONTROLLER).follow(points, joint_names=names)


def setpoint(robot: tool0.Robot) -> tuple[float, ...]:
    robot.channel.call(TakeArm(by="test"))
    found = robot.channel.call(ReadArmMotion()).setpoint.positions
    assert isinstance(found, tuple)
    return found


def path(robot: tool0.Robot, target: Move) -> None:
    plan = MovePlanner(robot.arm.kinematics).plan(setpoint(robot), [target])
    robot.channel.call(path_request(None, plan.path))


def movej(robot: tool0.Robot) -> None:
    path(robot, Move(kind="joint", q=(6.0, *setpoint(robot)[1:]), a=2.0, v=1.0))


def servoj(robot: tool0.Robot) -> None:
    here = setpoint(robot)
    for k in range(100):
        target = (here[0] - 0.002 * k, *here[1:])
        robot.channel.call(ServoJoints(positions=target))  # type: ignore[arg-type]
        robot.run(0.008)


def speedj(robot: tool0.Robot) -> None:
    robot.channel.call(TakeArm(by="test"))
    robot.channel.call(SpeedJoints(velocities=(-0.3, 0.0, 0.0, 0.0, 0.0, 0.0)))


def freedrive(robot: tool0.Robot) -> None:
    robot.channel.call(TakeArm(by="test"))
    robot.channel.call(StartFreedrive())
    robot.apply_wrench("forearm_link", torque=(0.0, 0.0, -20.0), duration=0.3)


WAYS = [move, move_within, jog, goal_from_there, movej, servoj, speedj, freedrive]


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_every_way_to_move_brings_it_back(
    robot: tool0.Robot, way: Callable[[tool0.Robot], None]
) -> None:
    way(robot)
    most = pan(robot)
    for _ in range(40):
        robot.run(0.05)
        most = max(most, pan(robot))
        if pan(robot) < LIMIT - 0.05:
            break
    assert pan(robot) < LIMIT - 0.05
    assert most < LIMIT + BEYOND + 0.005
    assert not robot.arm.control_box.state.protective_stop


@pytest.mark.slow
def test_no_motion_goes_further_out(robot: tool0.Robot) -> None:
    here = list(robot.arm.joints.values())
    out = [LIMIT + 0.045, *here[1:]]
    with pytest.raises(ControlError, match="limits"):
        robot.move_joints({PAN: out[0]})
    controller = robot.controller(ARM_CONTROLLER)
    with pytest.raises(ControlError, match="limits"):
        controller.follow([TrajectoryPoint(out, [0.0] * 6, None, 1.0)])
    start = setpoint(robot)
    with pytest.raises(ControlError, match="limits"):
        robot.channel.call(ServoJoints(positions=tuple(out)))  # type: ignore[arg-type]
    with pytest.raises(ControlError, match="limits"):
        robot.channel.call(
            ExecutePath(
                times=(0.0, 1.0),
                positions=(start, tuple(out)),  # type: ignore[arg-type]
                velocities=((0.0,) * 6,) * 2,
            )
        )


def test_far_beyond_a_limit_nothing_is_planned() -> None:
    limits = tool0.JointLimits(lower=-1.0, upper=1.0)
    assert limits.range_from(0.5) == (-1.0, 1.0)
    assert limits.range_from(1.03) == (-1.0, 1.03)
    assert limits.range_from(-1.03) == (-1.03, 1.0)
    assert limits.range_from(2.0) == (-1.0, 1.0 + RECOVERABLE)
