"""Services that a controller offers while it is active."""

from collections.abc import Callable
from typing import Any

from tool0_ros2.bridge import ControllerContext
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.control_box import is_running
from tool0_ros2.messages import fill


def offer(
    context: ControllerContext, kind: Any, name: str, handler: Callable[[Any], str]
) -> Any:
    """Create the service ``~/name``, whose response has the field ``success``.

    ``handler`` takes the request and returns the message that reports success.  The
    reason for a refusal is also logged, because not every response has a field for the
    reason.
    """

    def answer(request: Any, response: Any) -> Any:
        try:
            if not is_running(context):
                raise refused("Can't accept new requests. Controller is not running.")
            message = handler(request)
        except RequestFailedError as error:
            text = context.names.text(error).removeprefix(f"{name}: ")
            context.report.error(f"{name}: {text}")
            return fill(response, success=False, message=text)
        return fill(response, success=True, message=message)

    return context.node.create_service(kind, f"~/{name}", answer)


def refused(reason: str) -> RequestFailedError:
    """Return the error for a request that the node refuses."""
    return RequestFailedError("ControlError", reason)
