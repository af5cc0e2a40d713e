"""The actions of gripper controllers."""

from collections.abc import Sequence
from typing import Any

from control_msgs import action

from tool0_ros2 import requests
from tool0_ros2.actions import ActiveGoal, SimulatedAction
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.messages import rejected
from tool0_ros2.requests import GoalStarted, Outcome, Request


class _Gripper:
    """Base class of both gripper actions; it contains the joint and the request."""

    def __init__(self, context: ControllerContext) -> None:
        self.context = context
        self.joint: str = context.parameters.get("joint", "")

    def command(
        self, position: float, max_effort: float | None, max_velocity: float | None
    ) -> Request[GoalStarted]:
        """Return the request that sends a goal."""
        return requests.command_gripper(
            controller=self.context.name,
            position=position,
            max_effort=max_effort,
            max_velocity=max_velocity,
        )

    def state(self, update: Update) -> tuple[float, float, float]:
        """Return the position, velocity and effort of the joint."""
        k = update.index[self.joint]
        return update.position[k], update.velocity[k], update.effort[k]


class GripperCommandPart:
    """Action ``gripper_cmd`` of type control_msgs/GripperCommand."""

    def __init__(self, context: ControllerContext) -> None:
        self._gripper = _Gripper(context)
        self._action = SimulatedAction(
            context,
            action.GripperCommand,
            "~/gripper_cmd",
            start=lambda goal: self._gripper.command(
                goal.command.position, goal.command.max_effort, None
            ),
            result=_command_result,
            monitor_rate=context.parameters.get("action_monitor_rate", 20.0),
        )

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        self._action.publish(update.time, lambda goal: self._feedback(update))

    def close(self) -> None:
        self._action.close()

    def _feedback(self, update: Update) -> Any:
        position, _, effort = self._gripper.state(update)
        return action.GripperCommand.Feedback(position=position, effort=effort)


class ParallelGripperPart:
    """Action ``gripper_cmd`` of type control_msgs/ParallelGripperCommand."""

    def __init__(self, context: ControllerContext) -> None:
        self._gripper = _Gripper(context)
        self._own_joint = context.names.to_ros(self._gripper.joint)
        self._last = (0.0, 0.0, 0.0)
        self._action = SimulatedAction(
            context,
            action.ParallelGripperCommand,
            "~/gripper_cmd",
            start=self._start,
            result=self._result,
            monitor_rate=context.parameters.get("action_monitor_rate", 20.0),
        )

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        self._last = self._gripper.state(update)
        self._action.publish(update.time, self._feedback)

    def close(self) -> None:
        self._action.close()

    def _start(self, goal: Any) -> Request[GoalStarted]:
        command = goal.command
        if len(command.position) != 1:
            raise rejected(f"need exactly one position, got {len(command.position)}")
        return self._gripper.command(
            command.position[0],
            command.effort[0] if command.effort else None,
            command.velocity[0] if command.velocity else None,
        )

    def _feedback(self, goal: ActiveGoal) -> Any:
        position, velocity, effort = self._last
        message = action.ParallelGripperCommand.Feedback()
        message.state.name = [self._own_joint]
        message.state.position, message.state.velocity = [position], [velocity]
        message.state.effort = [effort]
        return message

    def _result(self, outcome: Outcome) -> Any:
        """Return the state at the goal's end.

        As in ROS, the state has no velocity.
        """
        message = action.ParallelGripperCommand.Result()
        message.state.name = [self._own_joint]
        message.state.position = [outcome.get("position") or 0.0]
        message.state.effort = [outcome.get("effort") or 0.0]
        message.stalled = bool(outcome.get("stalled"))
        message.reached_goal = bool(outcome.get("reached_goal"))
        return message


def _command_result(outcome: Outcome) -> Any:
    return action.GripperCommand.Result(
        position=outcome.get("position") or 0.0,
        effort=outcome.get("effort") or 0.0,
        stalled=bool(outcome.get("stalled")),
        reached_goal=bool(outcome.get("reached_goal")),
    )
