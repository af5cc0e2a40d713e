"""A GripperActionController in ROS: the action gripper_cmd."""

from __future__ import annotations

from typing import final

from tool0.api.controller import ControllerHandle, GoalHandle
from tool0.control.goal import GripperResult, Result
from tool0.control.gripper_action import GripperActionSpec
from tool0.errors import Tool0Error
from tool0.interfaces.ros1.actions import ActionEdge
from tool0.interfaces.ros1.conversions import Message
from tool0.interfaces.ros1.node import RosNode
from tool0.sensing.snapshot import Snapshot


@final
class GripperEdge:
    """The action of one controller, running or not."""

    def __init__(
        self, node: RosNode, spec: GripperActionSpec, controller: ControllerHandle
    ) -> None:
        from control_msgs.msg import (
            GripperCommandAction,
            GripperCommandFeedback,
            GripperCommandResult,
        )

        self._joint = spec.joint.name
        self._controller = controller
        self._position = 0.0
        self._result, self._feedback = GripperCommandResult, GripperCommandFeedback
        self._action = ActionEdge(
            node,
            f"{spec.name}/gripper_cmd",
            GripperCommandAction,
            start=self._start,
            refusal=self._refusal,
            outcome=self._outcome,
            monitor_rate=spec.action_monitor_rate,
        )

    def publish(self, snapshot: Snapshot) -> None:
        """Tell how the goal goes, if there is one and it is time to."""
        index = snapshot.joint_names.index(self._joint)
        self._position = snapshot.position[index]
        self._action.publish(
            snapshot.time,
            lambda: self._feedback(
                position=snapshot.position[index], effort=snapshot.effort[index]
            ),
        )

    def restart(self) -> None:
        """Forget times: simulated time has gone back to zero."""
        self._action.restart()

    def close(self) -> None:
        """Present it no longer."""
        self._action.close()

    def _start(self, goal: Message) -> GoalHandle:
        command = goal.command
        return self._controller.command_gripper(command.position, command.max_effort)

    def _refusal(self, error: Tool0Error) -> Message:
        del error  # its text goes beside the result, which has no place for it
        return self._result(position=self._position)

    def _outcome(self, result: Result) -> Message:
        assert isinstance(result, GripperResult)
        return self._result(
            position=result.position,
            effort=result.effort,
            stalled=result.stalled,
            reached_goal=result.reached_goal,
        )
