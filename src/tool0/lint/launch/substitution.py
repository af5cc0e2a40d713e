"""Resolves roslaunch's substitutions, such as ``$(find PACKAGE)``."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

from tool0.description.finding import Finding, Severity, error_at
from tool0.errors import DescriptionError, SourceLocation, did_you_mean
from tool0.lint.launch.evaluation import (
    EvaluationError,
    Function,
    NotUnderstoodError,
    evaluate,
)
from tool0.lint.launch.grammar import converted
from tool0.lint.launch.model import Text
from tool0.lint.packages import PackageIndex

COMMANDS: Final = ("find", "env", "optenv", "dirname", "anon", "arg", "eval")
MAX_LENGTH: Final = 100_000
"""Largest number of characters in a resolved text.  Without a limit, nested arguments
could create texts of any length."""

_WORD = re.compile(r"\$\(([^()]+)\)")
_BROKEN = re.compile(r"\$\([^()]*(\(|$)")
_FIND = re.compile(r"\$\(find ([^()]*)\)([^ $]*)")


class _UnresolvedError(Exception):
    """Raised if a substitution has no value."""


@final
@dataclass(slots=True, kw_only=True)
class Substitution:
    """Resolver of the substitutions in one text, with the values of its scope."""

    file: Path
    location: SourceLocation
    values: Mapping[str, Text]
    """Arguments that have a value or should have a value."""
    declared: Collection[str]
    """Arguments that have been declared before this text."""
    packages: PackageIndex
    anonymous: Callable[[str], str]
    uses: list[str] = field(default_factory=list)
    problems: list[Finding] = field(default_factory=list)
    """Faults of the substitutions, which are available after ``resolve``."""
    reason: str = ""

    def resolve(self, raw: str) -> Text:
        """Return ``raw`` with its substitutions resolved."""
        resolved = self._result(raw) if "$" in raw else raw
        return Text(
            raw=raw,
            resolved=resolved,
            location=self.location,
            uses=tuple(dict.fromkeys(self.uses)),
            reason="" if resolved is not None else self.reason,
        )

    def _result(self, raw: str) -> str | None:
        """Return the text; None if a substitution has no value."""
        try:
            if raw.startswith("$(eval ") and raw.endswith(")"):
                return _limited(self._evaluate(raw[7:-1]))
            if _BROKEN.search(raw):
                self.reason = "it has a $( that nothing closes"
                self._problem(
                    "bad-substitution",
                    raw.strip()[:40],
                    "has a $( that nothing closes, or a parenthesis inside another",
                    "close it; only $(eval …) may hold parentheses, and it must be "
                    "the whole value",
                )
                return None
            return self._replaced(raw)
        except _UnresolvedError as error:
            self.reason = self.reason or str(error)
            return None

    def _replaced(self, raw: str) -> str | None:
        """Replace ``find`` after all other substitutions, as roslaunch does."""
        is_whole = True
        parts: list[str] = []
        length = end = 0
        for match in _WORD.finditer(raw):
            try:
                value = self._word(match.group(0), match.group(1))
            except _UnresolvedError as error:
                self.reason = self.reason or str(error)
                is_whole, value = False, ""
            parts += (raw[end : match.start()], value)
            length += len(parts[-1]) + len(parts[-2])
            end = match.end()
            if length > MAX_LENGTH:
                break
        text = _limited("".join((*parts, raw[end:])))
        text = _limited(_FIND.sub(self._find, text))
        return text if is_whole and not self.reason else None

    def _word(self, whole: str, inside: str) -> str:
        command, *words = inside.split() or [""]
        if command == "find" and len(words) == 1:
            return f"$(find {words[0]})"  # replaced in the second pass
        if command == "dirname":
            return str(self.file.absolute().parent)
        if command == "optenv" and words:
            return os.environ.get(words[0], " ".join(words[1:]))
        functions = {"arg": self._arg, "env": self._env, "anon": self.anonymous}
        if command in functions and len(words) == 1:
            return functions[command](words[0])
        if command in COMMANDS:
            message = (
                "must be the whole value: roslaunch does not read it elsewhere"
                if command == "eval"
                else "takes one name"
            )
        else:
            message = f"nothing reads '{command}'{did_you_mean(command, COMMANDS)}"
        self._problem("bad-substitution", whole, message)
        raise _UnresolvedError(f"{whole} is not understood")

    def _arg(self, name: str) -> str:
        self.uses.append(name)
        text = self.values.get(name)
        if text is not None and text.resolved is not None:
            return text.resolved
        if text is not None:
            raise _UnresolvedError(text.reason or f"argument '{name}' has no value")
        if name not in self.declared:
            self._problem(
                "missing-argument",
                name,
                "is used here, and no <arg> before it declares it"
                + did_you_mean(name, self.declared),
                f'write <arg name="{name}" default="…"/> above',
            )
        raise _UnresolvedError(f"argument '{name}' has no value")

    def _env(self, name: str) -> str:
        if name in os.environ:
            return os.environ[name]
        self._problem(
            "unset-environment",
            name,
            "is an environment variable that is not set here, and $(env …) needs it",
            f"set it, or write $(optenv {name} DEFAULT)",
        )
        raise _UnresolvedError(f"the environment variable {name} is not set")

    def _find(self, match: re.Match[str]) -> str:
        """Return a path that starts with a package's folder."""
        after = match.group(2).replace("\\", "/")
        try:
            folder = self._folder(match.group(1).strip())
        except _UnresolvedError as error:
            self.reason = self.reason or str(error)
            return ""
        return folder + (after and "/" + after.removeprefix("/"))

    def _folder(self, name: str) -> str:
        try:
            return str(self.packages.find(name))
        except DescriptionError:
            self._not_found(name)
        raise _UnresolvedError(f"package '{name}' is not found")

    def _not_found(self, name: str) -> None:
        packages = self.packages
        near = packages.nearest(name)
        self._problem(
            "unresolved-find",
            name,
            "is a package that is not found here"
            + (f"; did you mean '{near}'?" if near else ""),
            f"install ros-noetic-{name.replace('_', '-')}, or put the package "
            "into the workspace and its folder into ROS_PACKAGE_PATH",
            severity="error" if near or packages.has_ros else "warning",
        )

    def _evaluate(self, expression: str) -> str:
        def known(name: str) -> object:
            if name not in self.values and name not in self.declared:
                raise KeyError(name)
            return converted(self._arg(name))

        functions: dict[str, Function] = {
            "arg": lambda name: converted(self._arg(name)),
            "env": self._env,
            "anon": self.anonymous,
            "find": self._folder,
            "dirname": lambda: str(self.file.absolute().parent),
            "optenv": lambda name, default="": os.environ.get(name, default),
        }
        try:
            return evaluate(expression, functions, known)
        except EvaluationError as error:
            is_ours = isinstance(error, NotUnderstoodError)
            message = f"$(eval …) has no value: {error}"
            severity: Severity = "warning" if is_ours else "error"
            key = expression.strip()[:40]
            self._problem("bad-eval", key, message, severity=severity)
            raise _UnresolvedError(message) from None

    def _problem(
        self,
        rule: str,
        key: str,
        message: str,
        remedy: str = "",
        *,
        severity: Severity = "error",
    ) -> None:
        self.problems.append(
            error_at(self.location, rule, key, message, remedy, severity=severity)
        )


def _limited(text: str) -> str:
    if len(text) > MAX_LENGTH:
        raise _UnresolvedError(f"it would be longer than {MAX_LENGTH} characters")
    return text
