"""What the commands that install something, or report what is installed, share."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, Protocol

from tool0.cli.text import columns

OK, NOT_READY = 0, 1


class InstallationStatus(Protocol):
    """Whether something could run here, and what is missing."""

    @property
    def can_run(self) -> bool: ...

    def as_json(self) -> dict[str, object]: ...

    def rows(self) -> Sequence[Sequence[str]]: ...


def print_status(status: InstallationStatus, format: Literal["text", "json"]) -> int:
    """Print it, for people or for programs; return the exit status."""
    if format == "json":
        print(json.dumps(status.as_json()))
    else:
        print(columns(status.rows()), end="")
    return OK if status.can_run else NOT_READY


def run_subcommand(
    command: str,
    subcommands: Mapping[str, Callable[..., int]],
    arguments: Sequence[str],
    description: str,
) -> int:
    """Run the subcommand that the arguments name; return the exit status."""
    import tyro

    status: int = tyro.extras.subcommand_cli_from_dict(
        dict(subcommands),
        prog=f"tool0 {command}",
        description=description,
        args=arguments,
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    return status
