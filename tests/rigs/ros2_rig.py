"""The arm's trajectory controller in ROS 2: its names, goals and states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from ros2_client import Client, Goal, Message, Topic
from ur5_rig import ARM_JOINTS
from waits import until

JTC = "joint_trajectory_controller"
GRIPPER = "robotiq_gripper_controller"
FOLLOW = "control_msgs/action/FollowJointTrajectory"
STATE = "control_msgs/msg/JointTrajectoryControllerState"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
LOG = "rcl_interfaces/msg/Log"
SUCCESSFUL, INVALID_GOAL, PATH_VIOLATED, GOAL_VIOLATED = 0, -1, -4, -5
"""Codes of FollowJointTrajectory."""
REACHED = "Goal successfully reached!"
SPEED = 1.5
"""Of the motions back to where a test starts [rad/s]."""

Points = Sequence[tuple[float, Sequence[float]]]


def trajectory(
    points: Points,
    joints: Sequence[str] = ARM_JOINTS,
    *,
    stamp: float = 0.0,
    at_rest: bool = True,
) -> dict[str, object]:
    """Return a trajectory_msgs/JointTrajectory.

    Args:
        points: When [s] and where [rad].
        joints: Whose.
        stamp: When it starts [s]; at once, if 0.
        at_rest: Whether the points have velocities, of 0.
    """
    return {
        "header": {"stamp": stamp},
        "joint_names": list(joints),
        "points": [
            {
                "positions": list(positions),
                "velocities": [0.0] * len(positions) if at_rest else [],
                "time_from_start": time,
            }
            for time, positions in points
        ],
    }


def follow(
    client: Client,
    trajectory: Mapping[str, object],
    controller: str = JTC,
    **options: object,
) -> Goal:
    """Send a trajectory as a goal."""
    return client.send(
        f"/{controller}/follow_joint_trajectory",
        FOLLOW,
        {"trajectory": trajectory, **options},
    )


def tolerance(joint: str, position: float) -> dict[str, object]:
    """Return a control_msgs/JointTolerance."""
    return {"name": joint, "position": position}


def distance(states: Topic, place: Sequence[float]) -> float:
    """Return how far the farthest joint is from a place now [rad]."""
    (now,) = states.next()
    return float(np.abs(np.subtract(now.feedback.positions, place)).max())


def go(
    client: Client, states: Topic, place: Sequence[float], controller: str = JTC
) -> None:
    """Have the arm at a place, at rest."""
    duration = 0.5 + distance(states, place) / SPEED
    goal = follow(client, trajectory([(duration, place)]), controller)
    status, result = goal.outcome()
    assert (status, result.error_string) == ("succeeded", REACHED)
    arrive(states, place)


def arrive(states: Topic, place: Sequence[float]) -> None:
    """Wait until the arm is there, at rest: goals have tolerances."""

    def is_there() -> bool:
        return distance(states, place) < 0.01

    until(is_there, f"the arm at {place}")
    come_to_rest(states)


def fastest(state: Message) -> float:
    """Return the speed of the fastest joint [rad/s]."""
    return max(map(abs, state.feedback.velocities))


def wait_until_moving(states: Topic, speed: float = 0.2) -> Message:
    """Wait until a joint moves that fast [rad/s]; return that state."""
    return states.wait_for_new(lambda state: fastest(state) > speed)


def come_to_rest(states: Topic) -> Message:
    """Wait until no joint moves; return that state."""
    return states.wait_for_new(
        lambda state: (
            fastest(state) < 0.005
            and max(map(abs, state.reference.velocities), default=0.0) == 0.0
        )
    )
