"""Parser that reads the words of a command line, and calls the command's function."""

from __future__ import annotations

import argparse
import itertools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import is_dataclass
from typing import Any, Final, NoReturn, TypeVar, final, get_type_hints

from tool0.cli.parameters import (
    Parameter,
    Readers,
    description_of,
    parameters_of,
    summary_of,
)
from tool0.cli.text import columns
from tool0.errors import ConfigError, did_you_mean, nearest_name

Parsed = TypeVar("Parsed")

HELP: Final = ("-h", "--help")
UNITS: Final = (
    "Numbers without a unit are in meters and radians.  You can write units: 40mm, "
    "0.04m, 90deg, 1.57rad."
)
_HAS_UNITS: Final = re.compile(r"\b(LENGTH|ANGLE|JOINT|X Y Z|ROLL)\b")
_NEGATIVE: Final = re.compile(r"-\.?\d")
"""Pattern of the beginning of a value with a minus sign, such as -90deg."""


def parse(
    form: Callable[..., Parsed] | Mapping[str, Callable[..., Parsed]],
    command: str,
    arguments: Sequence[str],
    readers: Readers,
    summary: str = "",
) -> Parsed:
    """Call ``form`` with the arguments and return its result, or print help and exit.

    Args:
        form: A function or dataclass with the options as parameters, or a mapping from
            subcommands to functions.
        command: The words before the arguments, which select the command.
        arguments: The words to parse.
        readers: Readers for types with a special notation.
        summary: The summary of a command with subcommands.

    Raises:
        ConfigError: If a word or a value is not valid.
        SystemExit: With status 0, after ``--help``.
    """
    if isinstance(form, Mapping):
        name = arguments[0] if arguments else HELP[0]
        if name in HELP:
            print(_overview(form, command, summary))
            raise SystemExit(0)
        if name not in form:
            hint = did_you_mean(name, list(form))
            raise ConfigError(f"tool0 {command}: no subcommand '{name}'{hint}")
        return parse(form[name], f"{command} {name}", arguments[1:], readers)
    parameters = list(parameters_of(form, readers))
    with_help = any(word in HELP for word in arguments)
    parser = _parser(form, command, parameters, with_help=with_help)
    found, rest = parser.parse_known_intermixed_args(list(arguments))
    if rest:
        parser.refuse(rest[0], [item.flag for item in parameters])
    values = {}
    for item in parameters:
        words = getattr(found, _destination(item), None)
        if words is not None and words != []:
            values[item.path] = _value(item, words)
        elif item.is_required and item.reader is not None and words is None:
            parser.error(f"{item.usage} is missing")
    return _made(form, values)


def _value(item: Parameter, words: Any) -> object:
    if item.reader is None:
        return words
    try:
        return item.reader.read([words] if isinstance(words, str) else words)
    except ConfigError as error:
        name = item.metavar if item.option.is_positional else item.flag
        raise ConfigError(f"{name}: {error}") from None


def _made(
    form: Callable[..., Parsed],
    values: Mapping[tuple[str, ...], object],
    path: tuple[str, ...] = (),
) -> Parsed:
    """Create the groups of options, and call ``form`` with the values."""
    keywords: dict[str, Any] = {
        name: _made(kind, values, (*path, name))
        for name, kind in get_type_hints(form).items()
        if is_dataclass(kind) and isinstance(kind, type)
    }
    keywords |= {where[-1]: v for where, v in values.items() if where[:-1] == path}
    return form(**keywords)


# ---- argparse ------------------------------------------------------------------------


@final
class _Formatter(argparse.HelpFormatter):
    """Shows metavars unchanged, and wraps each paragraph separately."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=28)

    def _format_args(self, action: argparse.Action, _: object) -> str:
        return str(action.metavar)

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        wrap = super()._fill_text
        return "\n\n".join(wrap(part, width, indent) for part in text.split("\n\n"))


@final
class _Parser(argparse.ArgumentParser):
    """Assigns words to options, and raises ConfigError for words that it refuses."""

    def error(self, message: str) -> NoReturn:
        message = message.removeprefix("argument ")
        raise ConfigError(f"{message}; see `{self.prog} --help`")

    def refuse(self, word: str, flags: Sequence[str]) -> NoReturn:
        """Raise an error about an unexpected word."""
        if not word.startswith("-"):
            self.error(f"'{word}' is one argument too many")
        near = nearest_name(word, flags)
        self.error(f"no option {word}" + (f"; did you mean {near}?" if near else ""))


def _parser(
    form: Callable[..., Any],
    command: str,
    parameters: Sequence[Parameter],
    *,
    with_help: bool,
) -> _Parser:
    parser = _Parser(
        prog=f"tool0 {command}",
        usage=usage_of(command, parameters),
        description=description_of(form),
        epilog=UNITS if any(_HAS_UNITS.search(p.metavar) for p in parameters) else "",
        formatter_class=_Formatter,
        allow_abbrev=False,
        add_help=False,
    )
    parser._negative_number_matcher = _NEGATIVE
    order = sorted(parameters, key=lambda item: not item.option.is_positional)
    for heading, items in itertools.groupby(order, lambda item: item.heading):
        section = parser.add_argument_group(heading)
        for item in items:
            _add(section, item, item.help.replace("%", "%%") if with_help else "")
    parser.add_argument_group("Help").add_argument(
        *HELP, action="help", help="Show this text."
    )
    return parser


def usage_of(command: str, parameters: Sequence[Parameter]) -> str:
    """Return the usage line of a command: its arguments and required options."""
    shown = [
        item.usage
        for item in parameters
        if item.option.is_positional or item.is_required
    ]
    return " ".join([f"tool0 {command}", *shown, "[OPTIONS]"])


def _destination(item: Parameter) -> str:
    return "-".join(item.path)


def _add(section: argparse._ArgumentGroup, item: Parameter, text: str) -> None:
    """Add an option whose value is a list of words or, for a flag, true or false."""
    keywords: dict[str, Any] = {"default": argparse.SUPPRESS, "help": text}
    if item.reader is None:
        paired = argparse.BooleanOptionalAction
        keywords["action"] = paired if item.default is True else "store_true"
        section.add_argument(item.flag, dest=_destination(item), **keywords)
        return
    keywords |= {"nargs": item.reader.n_words, "metavar": item.metavar}
    if item.option.is_positional:
        keywords["nargs"] = "*" if item.reader.n_words == "*" else "?"
        section.add_argument(_destination(item), **keywords)
        return
    if item.reader.n_words == "*":
        keywords["action"] = "extend"
    section.add_argument(item.flag, dest=_destination(item), **keywords)


def _overview(
    forms: Mapping[str, Callable[..., Any]], command: str, summary: str
) -> str:
    """Return the help of a command that has subcommands."""
    rows = [(f"  {name}", summary_of(form)) for name, form in forms.items()]
    return "\n".join(
        [
            f"usage: tool0 {command} {'|'.join(forms)} [OPTIONS]",
            "",
            f"{summary[:1].upper()}{summary[1:]}.",
            "",
            columns(rows),
            f"`tool0 {command} SUBCOMMAND --help` explains a subcommand.",
        ]
    )
