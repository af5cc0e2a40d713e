"""Substitutions of ROS 2 launch files in YAML, such as ``$(var NAME)``.

ROS 2 replaces substitutions in files that a launch file passes with ``allow_substs``,
before the text is parsed as YAML.  A bring-up has no launch file, so it replaces
substitutions in every file for ROS 2.  The variables are the arguments of the robot.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from typing import Final

from tool0.control.ros2.layout import PARAMETERS
from tool0.description.packages import find_package
from tool0.errors import ConfigError, DescriptionError, SourceLocation, did_you_mean

_SUBSTITUTION: Final = re.compile(
    r"\$\((var|env|find-pkg-share)\s+([^\s()]+)(?:\s+([^()]*?))?\s*\)"
)
_COMMENT: Final = re.compile(r"(?:^|\s)#.*")


def substituted(text: str, variables: Mapping[str, str], start: SourceLocation) -> str:
    """Return a YAML text for ROS 2 in which ``$(var NAME [DEFAULT])`` is replaced.

    ``$(env NAME [DEFAULT])`` and ``$(find-pkg-share PACKAGE)`` are also replaced.
    Comments, and YAML texts for ROS 1, are not changed.  ``start`` is the location of
    the first line.

    Raises:
        ConfigError: If a substitution has neither a value nor a default.
    """
    if PARAMETERS not in text:
        return text
    lines = text.split("\n")
    for k, line in enumerate(lines):
        comment = _COMMENT.search(line)
        end = len(line) if comment is None else comment.start()
        where = SourceLocation(start.file, (start.line or 1) + k)

        def value(match: re.Match[str], where: SourceLocation = where) -> str:
            return _value(match, variables, where)

        lines[k] = _SUBSTITUTION.sub(value, line[:end]) + line[end:]
    return "\n".join(lines)


def _value(
    match: re.Match[str], variables: Mapping[str, str], where: SourceLocation
) -> str:
    """Return the value of one substitution."""
    kind, name, default = match.groups()
    if kind == "find-pkg-share":
        try:
            return str(find_package(name))
        except DescriptionError as error:
            raise ConfigError(f"{match[0]}: {error.message}", where) from None
    values = variables if kind == "var" else os.environ
    if name in values:
        return values[name]
    if default is not None:
        return str(default).strip("'\"")
    if kind == "env":
        raise ConfigError(
            f"{match[0]}: the environment variable '{name}' is not set", where
        )
    raise ConfigError(
        f"{match[0]}: the robot has no argument '{name}'"
        f"{did_you_mean(name, variables)}; a default is written $(var {name} DEFAULT)",
        where,
    )
