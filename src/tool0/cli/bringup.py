"""``tool0 bringup``: a robot in simulation, until its time is over or Ctrl-C."""

from __future__ import annotations

import contextlib
import logging
import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from tool0.cli.bringup_text import (
    StatusLine,
    finite,
    greeting,
    panel_line,
    summary_line,
)
from tool0.cli.options import BringupOptions, SimulationOptions, bringup_keywords
from tool0.cli.quick import read_bringup
from tool0.errors import EngineError, EngineUnavailableError

if TYPE_CHECKING:
    from tool0.api.address import Claim
    from tool0.api.robot import Robot
    from tool0.cli.stop_signal import StopSignal
    from tool0.interfaces.panel.address import Door
    from tool0.interfaces.ros1.options import Ros1Options

_GLANCE: Final = 0.1
"""Longest time between looks at the clock and the signals [wall s]."""
_STRETCH: Final = 0.2
"""Simulated time between them without real time [s]: some 10 ms of wall time."""


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    return bring_up(read_bringup(arguments) or _read_slowly(command, arguments))


def _read_slowly(command: str, arguments: list[str]) -> BringupOptions:
    from tool0.cli.parsing import parse

    return parse(BringupOptions, command, arguments, flag_pairs=True)


def bring_up(options: BringupOptions) -> int:
    """Bring the robot up, let it run, and return the exit status."""
    from tool0.cli.stop_signal import StopSignal

    simulation = options.simulation
    # One JSON object is all that may stand on standard output then.
    console = sys.stderr if simulation.summary == "json" else sys.stdout
    with contextlib.ExitStack() as exits:
        exits.enter_context(quiet_overruns())
        # Names first: if one is wrong or taken, it should not take seconds to find out.
        as_node = _ros_options(options)
        claim = _claim(simulation)
        if claim is not None:
            exits.callback(claim.close)
        door = _door(options, exits)
        stop = exits.enter_context(StopSignal())
        robot = exits.enter_context(_robot(options))
        if claim is not None:
            exits.enter_context(_reachable(robot, claim))
        ros = exits.enter_context(_in_ros(robot, as_node, stop))
        if door is not None:
            from tool0.cli.panel import served, show

            exits.enter_context(served(robot, door))
            show(door.url, options.panel, console)
        url = None if door is None else door.url
        if simulation.summary != "json" or console.isatty():
            print(greeting(robot, simulation, url, ros), file=console, flush=True)
        elif url is not None:
            print(panel_line(url), file=console, flush=True)
        status = StatusLine(console)
        try:
            _run(robot, simulation, stop, status)
        finally:
            status.end()
            _summarize(robot, simulation)
    return 0


@contextlib.contextmanager
def quiet_overruns() -> Iterator[None]:
    """Keep the loop from logging them: the status line and the summary tell them."""
    loop = logging.getLogger("tool0.runtime.loop")
    level = loop.level
    loop.setLevel(logging.ERROR)
    try:
        yield
    finally:
        loop.setLevel(level)


def _claim(simulation: SimulationOptions) -> Claim | None:
    import socket

    if not simulation.remote:
        return None
    if not hasattr(socket, "AF_UNIX"):
        print(
            "tool0: warning: this platform has no Unix sockets; "
            "other processes cannot reach this bringup",
            file=sys.stderr,
        )
        return None
    from tool0.api.address import Claim

    return Claim(simulation.name)


def _door(options: BringupOptions, exits: contextlib.ExitStack) -> Door | None:
    """Listen for pages: an address that is taken should be told at once, too."""
    if options.simulation.headless:
        return None
    from tool0.cli.panel import door_of

    door = door_of(options.panel)
    exits.callback(door.listener.close)
    return door


def _robot(options: BringupOptions) -> Robot:
    from tool0.api.bringup import bringup

    robot = bringup(**bringup_keywords(options))  # type: ignore[arg-type]  # many types
    for warning in robot.warnings:
        print(f"tool0: warning: {warning}", file=sys.stderr)
    return robot


@contextlib.contextmanager
def _reachable(robot: Robot, claim: Claim) -> Iterator[None]:
    from tool0.interfaces.socket.server import RemoteServer

    server = RemoteServer(robot, claim)
    try:
        yield
    finally:
        server.close()


def _ros_options(options: BringupOptions) -> Ros1Options | None:
    given = options.ros
    if not given.ros1:
        return None
    from tool0.interfaces.ros1.options import Ros1Options

    ros = Ros1Options(
        ns=given.ns,
        roscore=given.roscore,
        tf_prefix=options.description.tf_prefix or "",
    )
    if given.tf_pub_rate is not None:
        ros = replace(ros, tf_pub_rate=given.tf_pub_rate)
    if given.camera_rate is not None:
        ros = replace(ros, camera_rate=given.camera_rate)
    return ros


@contextlib.contextmanager
def _in_ros(
    robot: Robot, options: Ros1Options | None, stop: StopSignal
) -> Iterator[str | None]:
    """Present the robot in ROS 1, if asked to; yield a line that says where."""
    if options is None:
        yield None
        return
    from tool0.interfaces.ros1.edge import Ros1

    with Ros1(robot, options, when_killed=stop.request) as edge:
        yield f"ROS 1: node {options.node} under {edge.node.master.uri}"


def _run(
    robot: Robot, simulation: SimulationOptions, stop: StopSignal, status: StatusLine
) -> None:
    """Let simulated time pass until it is enough, or somebody says so."""
    end = math.inf if simulation.duration is None else simulation.duration
    told: str | None = None
    while not stop.is_set and (left := end - robot.time) > 0.0:
        status.renew(robot)
        snapshot = robot.snapshot
        if snapshot.fault is not None and (
            simulation.duration is not None or _is_lost(robot)
        ):
            raise EngineError(snapshot.fault)
        if snapshot.fault not in (None, told):
            print(
                f"\ntool0: error: {snapshot.fault}\n"
                "The simulation stands still; `tool0 reset` starts it again.",
                file=sys.stderr,
            )
        told = snapshot.fault
        if simulation.realtime or snapshot.is_paused or snapshot.fault is not None:
            stop.wait(min(_GLANCE, max(left / (simulation.speed or 1.0), 0.001)))
        elif not _advance(robot, min(_STRETCH, left)):
            break


def _is_lost(robot: Robot) -> bool:
    """Return whether the physics is gone, so that no reset brings it back."""
    try:
        robot.run(0.0)
    except EngineUnavailableError:
        return True
    except Exception:
        return False  # it stands still, which the caller tells
    return False


def _advance(robot: Robot, duration: float) -> bool:
    """Run as fast as possible; return whether time is still to be had."""
    before = robot.time
    try:
        robot.run(duration)
    except Exception:
        snapshot = robot.snapshot
        if snapshot.fault is None and not snapshot.is_paused:
            raise
        return True  # somebody paused it, or it stands still: the caller sees to that
    return robot.time != before  # less than half a tick was left


def _summarize(robot: Robot, simulation: SimulationOptions) -> None:
    if simulation.summary == "json":
        import json

        print(json.dumps(finite(robot.summary()), allow_nan=False), flush=True)
    elif simulation.summary == "text":
        print(summary_line(robot.summary()), flush=True)
