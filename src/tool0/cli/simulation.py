"""Controllers and time of a running bringup: ``tool0 controllers | pause | …``."""

from __future__ import annotations

from typing import Annotated

import tyro

from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.text import columns
from tool0.errors import ConfigError
from tool0.requests.time import EmergencyStop

Names = Annotated[tuple[str, ...], tyro.conf.Positional]


def show(bringup: Bringup = DEFAULT) -> None:
    """List the loaded controllers with type, state and claimed joints."""
    with bringup.connect() as robot:
        rows = [
            (
                status.name,
                status.type,
                status.state,
                " ".join(joint for _, joints in status.claimed for joint in joints),
            )
            for status in robot.controllers()
        ]
    print(columns([("name", "type", "state", "claimed joints"), *rows]), end="")


def load(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Load controllers that the configuration defines.

    Args:
        names: The controllers.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        for name in _some(names):
            robot.load(name)


def unload(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Unload controllers that do not run.

    Args:
        names: The controllers.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        for name in _some(names):
            robot.unload(name)


def start(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Start controllers, all at one instant or none.

    Args:
        names: The controllers.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        robot.switch(start=_some(names))


def stop(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Stop controllers; their joints hold still.

    Args:
        names: The controllers.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        robot.switch(stop=_some(names))


def switch(
    start: tuple[str, ...] = (),
    stop: tuple[str, ...] = (),
    best_effort: bool = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Stop some controllers and start others at one instant.

    Args:
        start: Those to start.
        stop: Those to stop.
        best_effort: Skip what is impossible, instead of refusing the whole.
        bringup: Which bringup.
    """
    _some((*start, *stop))
    with bringup.connect() as robot:
        robot.switch(start=start, stop=stop, strict=not best_effort)


def _some(names: tuple[str, ...]) -> tuple[str, ...]:
    if not names:
        raise ConfigError("name at least one controller; see `tool0 controllers list`")
    return names


controllers = {
    "list": show,
    "load": load,
    "unload": unload,
    "start": start,
    "stop": stop,
    "switch": switch,
}


def pause(bringup: Bringup = DEFAULT) -> None:
    """Hold simulated time."""
    with bringup.connect() as robot:
        robot.pause()


def resume(bringup: Bringup = DEFAULT) -> None:
    """Let simulated time run on."""
    with bringup.connect() as robot:
        robot.resume()


def step(
    ticks: Annotated[int, tyro.conf.Positional] = 1, bringup: Bringup = DEFAULT
) -> None:
    """Advance a paused simulation, and print the time it has then.

    Args:
        ticks: How many control periods.
        bringup: Which bringup.
    """
    if ticks < 1:
        raise ConfigError(f"step: need 1 or more ticks, got {ticks}")
    with bringup.connect() as robot:
        robot.step(ticks)
        print(f"t = {robot.time:.3f} s")


def reset(bringup: Bringup = DEFAULT) -> None:
    """Go back to time zero and the initial pose; goals in progress are PREEMPTED."""
    with bringup.connect() as robot:
        robot.reset()


def estop(release: bool = False, bringup: Bringup = DEFAULT) -> None:
    """Brake every joint at once, until the emergency stop is released.

    Args:
        release: Release it; the controllers hold where the robot is.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        robot.channel.call(EmergencyStop(engaged=not release))
