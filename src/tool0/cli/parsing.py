"""From the words of a command line to options.

``parse`` uses tyro, which also writes the help and the error messages.  Importing tyro
and reading its types takes 0.1 s of a start-up of 0.3 s, so ``parse_quickly`` reads
the usual command lines without it, from the same dataclasses and the same readers (a
test compares the two).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    Final,
    Literal,
    TypeVar,
    final,
    get_args,
    get_origin,
    get_type_hints,
)

from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tyro.constructors import (
        PrimitiveConstructorSpec,
        PrimitiveTypeInfo,
        UnsupportedTypeAnnotationError,
    )

Parsed = TypeVar("Parsed")

REPEATABLE = ("--controllers-file", "--args", "--initial-pose", "--joints")
"""Options of several values: a repeated one adds to the values."""
_WITH_NEGATIONS = ("bringup", "view", "demo")
"""Commands whose flags ``--x`` also have a ``--no-x``."""


def joint_values(words: Sequence[str], option: str) -> dict[str, float]:
    """Return ``joint=value …`` as a mapping, or raise ConfigError."""
    values: dict[str, float] = {}
    for name, text in assignments(words, "=", option).items():
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            raise ConfigError(f"{option}: '{name}={text}': need a finite number")
    return values


def assignments(words: Sequence[str], sign: str, option: str) -> dict[str, str]:
    """Return ``name<sign>value …`` as a mapping, or raise ConfigError."""
    found: dict[str, str] = {}
    for word in words:
        name, given, value = word.partition(sign)
        if not (given and name):
            raise ConfigError(f"{option}: '{word}': write name{sign}value")
        if name in found:
            raise ConfigError(f"{option}: '{name}' is given twice")
        found[name] = value
    return found


@final
@dataclass(frozen=True, slots=True)
class Reader:
    """How an option of one type is written."""

    n_words: int | Literal["*"]
    metavar: str
    read: Callable[[list[str]], object]


Readers = Mapping[object, Reader | None]
"""Type → how its options are written; None if its fields are no options."""

_PLAIN: Final[dict[object, Callable[[str], object]]] = {
    kind: read for read in (str, float, int, Path) for kind in (read, read | None)
}
"""Types of one word, read as tyro reads them."""


def parse(
    form: Callable[..., Parsed] | Mapping[str, Callable[..., Parsed]],
    command: str,
    arguments: Sequence[str],
    readers: Readers,
    summary: str = "",
) -> Parsed:
    """Return what ``form`` makes of the arguments, or print help and exit.

    Args:
        form: A function or dataclass, whose parameters are the options; or functions
            by the names of subcommands.
        command: The word before the arguments.
        arguments: The words.
        readers: For types that tyro does not know.
        summary: What subcommands are for.

    Raises:
        ConfigError: If a value is refused.
        SystemExit: 0 after ``--help``, 2 after an error message.
    """
    import tyro

    markers = [tyro.conf.OmitArgPrefixes]
    if command not in _WITH_NEGATIONS:
        markers.append(tyro.conf.FlagCreatePairsOff)
    registry = tyro.constructors.ConstructorRegistry()
    registry.primitive_rule(partial(_tyro_rule, readers))
    words, program = gathered(arguments), f"tool0 {command}"
    with registry:
        if callable(form):
            return tyro.cli(form, prog=program, args=words, config=tuple(markers))
        parsed: Parsed = tyro.extras.subcommand_cli_from_dict(
            dict(form),
            prog=program,
            description=f"{summary[:1].upper()}{summary[1:]}.",
            args=words,
            config=tuple(markers),
        )
        return parsed


def _tyro_rule(
    readers: Readers, info: PrimitiveTypeInfo
) -> PrimitiveConstructorSpec[Any] | UnsupportedTypeAnnotationError | None:
    from tyro.constructors import (
        PrimitiveConstructorSpec,
        UnsupportedTypeAnnotationError,
    )

    if info.type not in readers:
        return None
    reader = readers[info.type]
    if reader is None:
        return UnsupportedTypeAnnotationError(())
    return PrimitiveConstructorSpec(
        nargs=reader.n_words,
        metavar=reader.metavar,
        instance_from_str=lambda words: (
            None if words == ["None"] else reader.read(words)
        ),
        is_instance=lambda _: True,
        str_from_instance=lambda value: [str(value)],
    )


def parse_quickly(
    form: type[Parsed], arguments: Sequence[str], readers: Readers
) -> Parsed | None:
    """Return what ``parse`` would, or None if that is needed to be sure.

    Args:
        form: A dataclass of dataclasses; the fields of the latter are the options.
        arguments: The words.
        readers: For types of a notation of their own.

    Raises:
        ConfigError: If a value is refused.
    """
    groups = get_type_hints(form)
    options = {
        f"--{name.replace('_', '-')}": (group, name, kind)
        for group, kinds in groups.items()
        for name, kind in get_type_hints(kinds).items()
        if readers.get(kind, True) is not None
    }
    values: dict[str, dict[str, object]] = {group: {} for group in groups}
    words = gathered(arguments)
    while words:
        option = words.pop(0)
        is_negated = option.startswith("--no-")
        group, name, kind = options.get(
            option.replace("--no-", "--", 1), ("", "", None)
        )
        if not group or name in values[group]:
            return None
        texts: list[str] = []
        while words and not words[0].startswith("-"):
            texts.append(words.pop(0))
        value = _value(kind, texts, readers.get(kind), is_negated=is_negated)
        if value is None:
            return None
        values[group][name] = value
    return form(**{group: kind(**values[group]) for group, kind in groups.items()})


def _value(
    kind: object, texts: list[str], reader: Reader | None, *, is_negated: bool
) -> object:
    """Return the value of one option, or None if in doubt."""
    if kind is bool:
        return None if texts else not is_negated
    if is_negated or not texts or "None" in texts:  # tyro reads None as no value
        return None
    try:
        if reader is not None and reader.n_words in ("*", len(texts)):
            return reader.read(texts)
        if kind in _PLAIN and len(texts) == 1:
            return _PLAIN[kind](texts[0])
    except (ValueError, ConfigError):
        return None
    choices = [
        choice
        for part in (kind, *get_args(kind))
        if get_origin(part) is Literal
        for choice in get_args(part)
    ]
    return texts[0] if len(texts) == 1 and texts[0] in choices else None


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
