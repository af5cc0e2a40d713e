"""``python -m tool0_ros2`` runs the node for a running bring-up."""

import argparse
import gc
import json
import os
import signal
import sys
from typing import Any

MAX_RATE = 500.0
UNABLE = 78  # The bring-up does not restart a program that lacks something it needs.


class _Stop(BaseException):
    """Raised when a signal asks the program to end."""


def main() -> None:
    """Present a bring-up in ROS 2 until it ends or Ctrl-C is pressed."""
    options, rest = _options()
    is_stopping = False

    def stop(*_: object) -> None:
        nonlocal is_stopping
        if not is_stopping:
            is_stopping = True
            raise _Stop

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    try:
        status = _run(options, rest)
    except _Stop:
        status = 0
    sys.stdout.flush()
    sys.stderr.flush()
    # Threads of the middleware may still run, and the interpreter must not wait for
    # them.
    os._exit(status)


def _run(options: argparse.Namespace, rest: list[str]) -> int:
    try:
        import rclpy
        from rclpy.context import Context
        from rclpy.signals import SignalHandlerOptions

        from tool0_ros2.connection import (
            Connection,
            RequestFailedError,
        )
        from tool0_ros2.errors import TransportError
        from tool0_ros2.node import RobotNode
    except ImportError as error:
        print(f"tool0_ros2: {_explained(error)}", file=sys.stderr)
        return UNABLE
    ros = Context()
    rclpy.init(
        args=rest,
        context=ros,
        domain_id=options.domain,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    robot = RobotNode(ros, options.ns)
    try:
        connection = Connection(options.name, wait=options.wait)
        robot.start(connection, options)
        gc.collect()
        gc.freeze()  # do not examine existing objects 500 times a second
        _report(ready=True, node=robot.node.get_fully_qualified_name())
        robot.has_ended.wait()
    except (TransportError, RequestFailedError) as error:
        print(f"tool0_ros2: {error}", file=sys.stderr)
        return 1
    finally:
        robot.close()
        rclpy.shutdown(context=ros)
    return 0


def _report(**values: Any) -> None:
    """Report values as a line of JSON to the program that started this one."""
    print(json.dumps(values), flush=True)


def _explained(error: ImportError) -> str:
    return (
        f"{error}. Run this program in a sourced ROS 2 with the packages rclpy, "
        "control_msgs, controller_manager_msgs and tf2_msgs; `tool0 ros2 status` shows "
        "what is missing"
    )


def _options() -> tuple[argparse.Namespace, list[str]]:
    parser = argparse.ArgumentParser(
        prog="tool0_ros2",
        description="Present a robot that tool0 simulates in ROS 2.",
    )
    add = parser.add_argument
    add("--name", default="tool0", help="the --name of the bring-up")
    add("--ns", default="", help="namespace of all names, such as robot1")
    add("--domain", type=int, help="ROS_DOMAIN_ID, if not that of the environment")
    add("--tf-rate", type=_rate, default=50.0, help="frames a second [Hz]")
    add("--camera-rate", type=_rate, default=10.0, help="images a second [Hz], at most")
    add("--wait", action="store_true", help="wait until the bring-up has started")
    return parser.parse_known_args()


def _rate(text: str) -> float:
    rate = float(text)
    if not 0.0 < rate <= MAX_RATE:
        raise argparse.ArgumentTypeError(f"need a rate in (0, {MAX_RATE:g}] Hz")
    return rate


if __name__ == "__main__":
    main()
