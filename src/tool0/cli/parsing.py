"""From words to options: the slow and friendly way, through tyro."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

Parsed = TypeVar("Parsed")

REPEATABLE = ("--controllers-file", "--args", "--initial-pose", "--joints")
"""Options of several values: writing one twice adds to it."""


def parse(
    form: Callable[..., Parsed],
    command: str,
    arguments: Sequence[str],
    *,
    flag_pairs: bool = False,
) -> Parsed:
    """Return what ``form`` makes of the arguments, or print help and exit.

    Args:
        form: A function or dataclass; its parameters are the options.
        command: The words before the arguments.
        arguments: The words.
        flag_pairs: Whether every flag ``--x`` also has a ``--no-x``.

    Raises:
        SystemExit: 0 after ``--help``, 2 after a mistake, which is then explained.
    """
    import tyro

    markers = [tyro.conf.OmitArgPrefixes]
    if not flag_pairs:
        markers.append(tyro.conf.FlagCreatePairsOff)
    return tyro.cli(
        form,
        prog=f"tool0 {command}",
        args=gathered(arguments),
        config=tuple(markers),
    )


def gathered(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with the values of a repeated option in one place."""
    groups: list[list[str]] = [[]]
    for word in arguments:
        if word.startswith("--"):
            option, given, value = word.partition("=")
            if given and option in REPEATABLE:
                groups.append([option, value])
                continue
            groups.append([word])
        else:
            groups[-1].append(word)
    first: dict[str, list[str]] = {}
    for group in groups:
        if group and group[0] in first:
            first[group[0]].extend(group[1:])
            group.clear()
        elif group and group[0] in REPEATABLE:
            first[group[0]] = group
    return [word for group in groups for word in group]
