"""The service of Robotiq's activation controller."""

from collections.abc import Sequence
from typing import Any

from std_srvs.srv import Trigger

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.connection import RequestFailedError


class ActivationPart:
    """Service ``~/reactivate_gripper``, which always opens the gripper."""

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        self._service = context.node.create_service(
            Trigger, "~/reactivate_gripper", self._answer
        )

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Publish nothing, because this part has only a service."""

    def close(self) -> None:
        self._context.node.destroy_service(self._service)

    def _answer(self, request: Any, response: Any) -> Any:
        try:
            self._context.connection.call(
                requests.reactivate_gripper(controller=self._context.name)
            )
        except RequestFailedError as error:
            response.success, response.message = False, str(error)
        else:
            response.success, response.message = True, "the gripper is active again"
        return response
