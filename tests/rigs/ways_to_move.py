"""Every way to move the arm of a simulation, behind one form: start, feed, outcome.

An outcome is "active", "none" (the way reports no result), or how the motion ended.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import tool0
from tool0 import (
    ControlError,
    GoalHandle,
    MoveJointStep,
    MoveLinearStep,
    Program,
    ToolPose,
    TrajectoryPoint,
)
from tool0.description.transform import Pose
from tool0.protocol.goals import GoalResult

DEFAULT = "eff_joint_traj_controller"
BARE = "arm"
REST = (0.0,) * 6
_JOINTS = (
    "[shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, "
    "wrist_2_joint, wrist_3_joint]"
)
WITHOUT_TOLERANCES = f"""
{BARE}:
  type: position_controllers/JointTrajectoryController
  joints: {_JOINTS}
"""
WITHOUT_TOLERANCES_2 = f"""
controller_manager:
  ros__parameters:
    {BARE}: {{type: joint_trajectory_controller/JointTrajectoryController}}
{BARE}:
  ros__parameters:
    joints: {_JOINTS}
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints: {{goal_time: 1.0}}
"""


class Aim(NamedTuple):
    """Where an arm is sent."""

    joints: tuple[float, ...]
    """[rad]"""
    pose: Pose
    """Of tool0."""
    duration: float
    """[s]; ways that choose their own do not use it."""


@dataclass
class Attempt:
    """A motion that was accepted."""

    robot: tool0.Robot
    outcome: Callable[[], str]
    told: Callable[[], str]
    """Why it ended."""
    cancel: Callable[[], object]
    send: Callable[[], object] = lambda: None
    """Sends the next one of a stream."""
    refused: list[str] = field(default_factory=list)
    """Why the stream was refused."""
    stalls: set[str] = field(default_factory=set)

    def feed(self) -> None:
        """Go on as a client does that has not noticed anything."""
        self.stalls.update(map(str, self.robot.snapshot.stalls))
        try:
            self.send()
        except ControlError as error:
            self.refused.append(str(error))

    @property
    def reason(self) -> str:
        """All that a client was told."""
        return "; ".join([self.told(), *self.refused, *sorted(self.stalls)])


Start = Callable[[tool0.Robot, Aim], Attempt]


class Way(NamedTuple):
    """A way to move, and the controllers that it needs."""

    start: Start
    controllers: str = ""
    """YAML of the bring-up; empty for the built-in ones."""
    is_planned: bool = False
    """Whether its speed and its line are the simulator's, not the client's."""


# ---- goals and topics ----------------------------------------------------------------


def _point(aim: Aim) -> list[TrajectoryPoint]:
    return [TrajectoryPoint(aim.joints, REST, time_from_start=aim.duration)]


def _of_goal(robot: tool0.Robot, goal: GoalHandle) -> Attempt:
    def told() -> str:
        result = goal.result
        return result.error_string if isinstance(result, GoalResult) else ""

    def outcome() -> str:
        return goal.status.value.lower()

    return Attempt(robot, outcome, told, goal.cancel)


def goal_of(controller: str) -> Start:
    """Return a trajectory goal of a controller."""

    def start(robot: tool0.Robot, aim: Aim) -> Attempt:
        names = robot.arm.joint_names
        goal = robot.controller(controller).follow(_point(aim), joint_names=names)
        return _of_goal(robot, goal)

    return start


def topic_of(controller: str) -> Start:
    """Return a trajectory without a goal."""

    def start(robot: tool0.Robot, aim: Aim) -> Attempt:
        handle, names = robot.controller(controller), robot.arm.joint_names
        handle.command_trajectory(_point(aim), joint_names=names)

        def cancel() -> None:
            now = [robot.snapshot.positions[name] for name in names]
            here = [TrajectoryPoint(now, REST, time_from_start=0.3)]
            handle.command_trajectory(here, joint_names=names)

        return Attempt(robot, lambda: "none", str, cancel)

    return start


def steer(robot: tool0.Robot, aim: Aim) -> Attempt:
    handle = robot.controller(DEFAULT)
    handle.steer(_named(robot, aim))

    def cancel() -> None:
        handle.steer(robot.arm.joints)

    return Attempt(robot, lambda: "none", str, cancel)


def _named(robot: tool0.Robot, aim: Aim) -> dict[str, float]:
    return dict(zip(robot.arm.joint_names, aim.joints, strict=True))


def move_joints(robot: tool0.Robot, aim: Aim) -> Attempt:
    return _of_goal(robot, robot.move_joints(_named(robot, aim), collision="ignore")[0])


def move_joints_within(robot: tool0.Robot, aim: Aim) -> Attempt:
    goals = robot.move_joints(
        _named(robot, aim), duration=aim.duration, collision="ignore"
    )
    return _of_goal(robot, goals[0])


def move_to(robot: tool0.Robot, aim: Aim) -> Attempt:
    return _of_goal(robot, robot.arm.move_to(aim.pose, collision="ignore"))


def move_linear(robot: tool0.Robot, aim: Aim) -> Attempt:
    return _of_goal(robot, robot.arm.move_linear(aim.pose, collision="ignore"))


# ---- taken arms ----------------------------------------------------------------------


def _of_motion(
    robot: tool0.Robot,
    send: Callable[[], object] = lambda: None,
    duration: float | None = None,
) -> Attempt:
    """Return what a taken arm does; a path has a ``duration``, a stream has not."""
    motion = robot.arm.motion
    told = ""

    def outcome() -> str:
        nonlocal told
        state = motion.state
        told = told or state.failure
        if state.mode == "free" or state.failure:
            return "failed"
        if duration is None:
            return "none"
        if not state.is_done:
            return "active"
        return "succeeded" if state.path_time >= duration - 1e-9 else "stopped"

    return Attempt(robot, outcome, lambda: told, lambda: motion.stop(4.0), send)


def path(robot: tool0.Robot, aim: Aim) -> Attempt:
    robot.arm.motion.take()
    robot.arm.motion.execute_path([aim.duration], [aim.joints], [REST])
    return _of_motion(robot, duration=aim.duration)


def servo(robot: tool0.Robot, aim: Aim) -> Attempt:
    motion, begin = robot.arm.motion, robot.time
    motion.take()
    start = motion.state.setpoint.positions

    def send() -> None:
        share = min((robot.time - begin) / aim.duration, 1.0)
        motion.servo_joints(
            [a + share * (b - a) for a, b in zip(start, aim.joints, strict=True)]
        )

    motion.servo_joints(aim.joints if aim.duration < 0.1 else start)
    return _of_motion(robot, send)


def speed_joints(robot: tool0.Robot, aim: Aim) -> Attempt:
    motion = robot.arm.motion
    motion.take()
    start = motion.state.setpoint.positions
    velocities = [
        (b - a) / aim.duration for a, b in zip(start, aim.joints, strict=True)
    ]
    motion.speed_joints(velocities)
    return _of_motion(robot, lambda: motion.speed_joints(velocities))


def jog(robot: tool0.Robot, aim: Aim) -> Attempt:
    """Move the tool with a velocity, as the panel does while a button is pressed."""
    motion = robot.arm.motion
    motion.take()
    here = robot.arm.pose().position
    way = [b - a for a, b in zip(here, aim.pose.xyz, strict=True)]
    twist = [*(x / aim.duration for x in way), 0.0, 0.0, 0.0]
    # The base of the arm is turned by half a turn in the root.
    twist[:2] = [-twist[0], -twist[1]]
    motion.speed_tool(twist)
    return _of_motion(robot, lambda: motion.speed_tool(twist))


def hand_guiding(robot: tool0.Robot, aim: Aim) -> Attempt:
    """Let a hand push the tool towards the aim with 60 N."""
    motion = robot.arm.motion
    motion.take()
    motion.start_freedrive()
    here = robot.arm.pose().position
    way = [b - a for a, b in zip(here, aim.pose.xyz, strict=True)]
    size = sum(x * x for x in way) ** 0.5
    robot.apply_wrench("wrist_3_link", force=tuple(60.0 * x / size for x in way))
    attempt = _of_motion(robot)
    attempt.cancel = motion.end_freedrive
    return attempt


# ---- programs ------------------------------------------------------------------------


def _program(robot: tool0.Robot, step: Any) -> Attempt:
    handle = robot.run_program(Program(name="test", steps=(step,)))

    def outcome() -> str:
        state = handle.status.state
        return "active" if state in {"running", "paused"} else state

    return Attempt(robot, outcome, lambda: handle.status.error, handle.stop)


def joint_program(robot: tool0.Robot, aim: Aim) -> Attempt:
    return _program(robot, MoveJointStep(joints=_named(robot, aim)))


def linear_program(robot: tool0.Robot, aim: Aim) -> Attempt:
    pose = ToolPose(xyz=aim.pose.xyz, rpy=aim.pose.rpy)
    return _program(robot, MoveLinearStep(pose=pose))


WAYS: Mapping[str, Way] = {
    "goal of ROS 1": Way(goal_of(DEFAULT)),
    "goal of ROS 1 without tolerances": Way(goal_of(BARE), WITHOUT_TOLERANCES),
    "goal of ROS 2 without tolerances": Way(goal_of(BARE), WITHOUT_TOLERANCES_2),
    "topic of ROS 1": Way(topic_of(DEFAULT)),
    "topic of ROS 1, positions": Way(topic_of(BARE), WITHOUT_TOLERANCES),
    "topic of ROS 2": Way(topic_of(BARE), WITHOUT_TOLERANCES_2),
    "steer": Way(steer, is_planned=True),
    "move_joints": Way(move_joints, is_planned=True),
    "move_joints within a time": Way(move_joints_within),
    "move_to": Way(move_to, is_planned=True),
    "move_linear": Way(move_linear, is_planned=True),
    "path": Way(path),
    "program, joints": Way(joint_program, is_planned=True),
    "program, line": Way(linear_program, is_planned=True),
    "servo": Way(servo),
    "speed": Way(speed_joints),
    "jog": Way(jog),
    "hand guiding": Way(hand_guiding, is_planned=True),
}
