"""``tool0 controllers``: the controller manager of a running bringup."""

from __future__ import annotations

from typing import Annotated

import tyro

from tool0.cli.connection import Bringup
from tool0.cli.text import columns
from tool0.errors import ConfigError

Names = Annotated[tuple[str, ...], tyro.conf.Positional]
_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    tyro.extras.subcommand_cli_from_dict(
        {
            "list": show,
            "load": load,
            "unload": unload,
            "start": start,
            "stop": stop,
            "switch": switch,
        },
        prog=f"tool0 {command}",
        description="List, load, unload, start, stop or switch controllers.",
        args=arguments,
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    return 0


def show(bringup: Bringup = _DEFAULT) -> None:
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


def load(names: Names, bringup: Bringup = _DEFAULT) -> None:
    """Load controllers that the configuration defines.

    Args:
        names: The controllers.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        for name in _some(names):
            robot.load(name)


def unload(names: Names, bringup: Bringup = _DEFAULT) -> None:
    """Unload controllers that do not run.

    Args:
        names: The controllers.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        for name in _some(names):
            robot.unload(name)


def start(names: Names, bringup: Bringup = _DEFAULT) -> None:
    """Start controllers, all at one instant or none.

    Args:
        names: The controllers.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        robot.switch(start=_some(names))


def stop(names: Names, bringup: Bringup = _DEFAULT) -> None:
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
    bringup: Bringup = _DEFAULT,
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
