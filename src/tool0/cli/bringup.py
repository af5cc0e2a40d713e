"""``tool0 bringup``: run a robot for a given duration, or until Ctrl-C."""

from __future__ import annotations

import contextlib
import logging
import math
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from tool0.cli import options
from tool0.cli.options import BringupOptions, RunOptions
from tool0.cli.text import (
    StatusLine,
    greeting,
    panel_line,
    print_json,
    summary_line,
    ur_lines,
)
from tool0.errors import ConfigError, EngineError, EngineUnavailableError
from tool0.installation import garbage
from tool0.protocol.channel import backend_of

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from pathlib import Path

    from tool0.api.robot import Robot
    from tool0.cli.stop_signal import StopSignal
    from tool0.panel.address import Endpoint
    from tool0.protocol.address import Claim
    from tool0.ros2.node import Ros2Node
    from tool0.server.hub import Service
    from tool0.server.server import Server
    from tool0.ur.process import UrController

READERS = options.READERS

_POLL_PERIOD: Final = 0.1
"""Longest time between checks of the clock and the signals [wall s]."""
_RUN_PERIOD: Final = 0.2
"""Simulated time between checks without real-time pacing [s].  The simulation of this
period takes about 10 ms of wall time."""


def bringup(options: BringupOptions) -> int:
    """Bring up a robot in simulation with its controllers running.

    The robot holds its pose until you command it: from the panel (a web page; its URL
    is printed), from another terminal (`tool0 move`, `tool0 grip`) or from Python.
    """
    from tool0.cli.stop_signal import StopSignal

    # With --json, standard output contains only one JSON object.
    is_json = options.run.as_json
    console = sys.stderr if is_json else sys.stdout
    with contextlib.ExitStack() as exits:
        exits.enter_context(quiet_overruns())
        exits.enter_context(garbage.starting())
        stop = exits.enter_context(StopSignal())
        # Check the name first, to report an invalid or used name before building the
        # robot.
        claim = _claim(options.run)
        if claim is not None:
            exits.callback(claim.close)
        endpoint = None
        if not options.run.headless:
            from tool0.cli.panel import listening

            endpoint = exits.enter_context(listening(options.panel))
        # The engine's process starts while the robot is built.
        node = _ros2_node(options)
        if node is not None:
            exits.callback(node.close)
        ur = _ur_controller(options)
        if ur is not None:
            exits.callback(ur.close)
        robot = exits.enter_context(_robot(options))
        if claim is not None or endpoint is not None:
            folder = options.run.panel_folder
            exits.enter_context(_server(robot, claim, endpoint, folder))
        ros = exits.enter_context(_in_ros(robot, options, stop))
        interfaces = [] if ros is None else [ros]
        if node is not None:
            exits.callback(node.close)  # close the node before the robot
            interfaces.append(
                f"ROS 2: node {node.wait()} in domain {node.domain}, {node.ros2.distro}"
            )
        if ur is not None:
            exits.callback(ur.close)
            interfaces += ur_lines(ur.wait())
        if endpoint is not None:
            from tool0.cli.panel import show

            show(endpoint.url, options.panel, console)
        garbage.started()
        url = None if endpoint is None else endpoint.url
        if not is_json or console.isatty():
            print(greeting(robot, options, url, interfaces), file=console, flush=True)
        elif url is not None:
            print(panel_line(url), file=console, flush=True)
        status = StatusLine(console)
        try:
            _run(robot, options, stop, status)
        finally:
            status.end()
            _summarize(robot, options.run)
    return 0


def quiet_overruns() -> AbstractContextManager[None]:
    """Suppress log entries about overruns.

    The status line and the summary count the overruns.
    """
    return _without_warnings("tool0.simulation.publisher")


@contextlib.contextmanager
def _without_warnings(name: str) -> Iterator[None]:
    """Suppress a logger's warnings about problems that are already printed."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def _claim(run: RunOptions) -> Claim | None:
    import socket

    if not run.remote:
        return None
    if not hasattr(socket, "AF_UNIX"):
        print(
            "tool0: warning: this platform has no Unix sockets; "
            "other processes cannot reach this bringup",
            file=sys.stderr,
        )
        return None
    from tool0.protocol.address import Claim

    return Claim(run.name)


def _robot(options: BringupOptions) -> Robot:
    from tool0.api.bringup import bringup

    with _without_warnings("tool0.api.bringup"):
        robot = bringup(
            # by default, a real robot has the controllers of ROS 2
            ros2_control=False if options.run.ros1 else None,
            description=options.full_description(),
            control=options.control,
            simulation=options.full_simulation(),
        )
    dialect = robot.simulation.core.manager.dialect
    if options.run.ros2 and dialect.name != "ros2":
        robot.close()
        raise ConfigError(
            f"--ros2 needs controllers of ROS 2, and these are of {dialect.title}: "
            "give a YAML with 'ros__parameters', and joints in <ros2_control>"
        )
    for warning in robot.warnings:
        print(f"tool0: warning: {warning}", file=sys.stderr)
    return robot


def _server(
    robot: Robot, claim: Claim | None, endpoint: Endpoint | None, folder: Path | None
) -> Server:
    """Serve the robot to processes and panels; panels may write to ``folder``."""
    from tool0.server.server import Server

    services: list[Service] = []
    if claim is not None:
        from tool0.server.server import UnixSocketService

        services.append(UnixSocketService(claim))
    if endpoint is not None:
        from tool0.panel.server import panel_service

        services.append(panel_service(robot, endpoint, folder)[1])
    name = "" if claim is None else claim.name
    return Server(backend_of(robot.channel), services, name)


@contextlib.contextmanager
def _in_ros(
    robot: Robot, options: BringupOptions, stop: StopSignal
) -> Iterator[str | None]:
    """Start the node of ROS 1 if requested; yield a line of text about the node."""
    if not options.run.ros1:
        yield None
        return
    from tool0.ros1.bridge import Ros1Bridge

    with Ros1Bridge(robot, options.ros, on_shutdown=stop.request) as bridge:
        yield f"ROS 1: node {options.ros.node} under {bridge.node.master.uri}"


def _ros2_node(options: BringupOptions) -> Ros2Node | None:
    """Start the node of ROS 2 if requested."""
    if not options.run.ros2:
        return None
    from tool0.ros2.node import Ros2Node

    return Ros2Node(options.run.name, options.ros2.options())


def _ur_controller(options: BringupOptions) -> UrController | None:
    """Start the UR interface if requested."""
    if not options.run.ur:
        return None
    from tool0.ur.process import UrController

    given = options.ur.options()
    if given.is_public:
        print(
            f"tool0: warning: whoever reaches {given.host} can move the robot: UR's "
            "protocols have no passwords",
            file=sys.stderr,
        )
    return UrController(options.run.name, given)


def _run(
    robot: Robot, options: BringupOptions, stop: StopSignal, status: StatusLine
) -> None:
    """Run the simulation for the given duration, or until a signal is received.

    The duration is measured from the call to this function, because simulated time may
    have passed while the interfaces were starting.
    """
    simulation, duration = options.simulation, options.run.duration
    length = math.inf if duration is None else duration
    begin = robot.time
    reported: str | None = None
    while not stop.is_set:
        begin = min(begin, robot.time)  # a reset sets the time to zero
        if (left := begin + length - robot.time) <= 0.0:
            break
        status.refresh(robot)
        snapshot = robot.snapshot
        if snapshot.fault is not None and (duration is not None or _is_lost(robot)):
            raise EngineError(snapshot.fault)
        if snapshot.fault not in (None, reported):
            print(
                f"\ntool0: error: {snapshot.fault}\n"
                "The simulation has stopped; `tool0 reset` starts it again.",
                file=sys.stderr,
            )
        reported = snapshot.fault
        if simulation.realtime or snapshot.is_paused or snapshot.fault is not None:
            stop.wait(min(_POLL_PERIOD, max(left / simulation.speed, 0.001)))
        elif not _advance(robot, min(max(_RUN_PERIOD, robot.control_period), left)):
            break


def _is_lost(robot: Robot) -> bool:
    """Return whether the engine's process has ended; a reset cannot restart it."""
    try:
        robot.run(0.0)
    except EngineUnavailableError:
        return True
    except Exception:
        return False  # a fault has stopped the simulation; the caller reports the fault
    return False


def _advance(robot: Robot, duration: float) -> bool:
    """Run as fast as possible; return whether at least one tick was executed."""
    before = robot.time
    try:
        robot.run(duration)
    except Exception:
        snapshot = robot.snapshot
        if snapshot.fault is None and not snapshot.is_paused:
            raise
        return True  # the caller handles a pause and a fault
    return robot.time != before


def _summarize(robot: Robot, run: RunOptions) -> None:
    if run.as_json:
        print_json(robot.summary())
    elif run.summary:
        print(summary_line(robot.summary()), flush=True)
