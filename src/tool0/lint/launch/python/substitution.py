"""Computes values of substitutions, such as LaunchConfiguration."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import final

from tool0.description.packages import source_path
from tool0.errors import DescriptionError, SourceLocation, did_you_mean, is_typo
from tool0.lint.launch.evaluation import (
    EvaluationError,
    NotUnderstoodError,
    evaluate,
)
from tool0.lint.launch.model import Text
from tool0.lint.launch.python.state import LaunchState
from tool0.lint.launch.python.values import Choice, Made, Unknown, Value
from tool0.lint.launch.substitution import MAX_LENGTH

_PATHS = ("PathJoinSubstitution", "PathSubstitution")
_WORDS = {"true": True, "1": True, "false": False, "0": False}

Report = Callable[..., None]


def as_boolean(word: str) -> bool | None:
    """Return the value of a text as a condition; None if launch rejects the text."""
    return _WORDS.get(word.strip().lower())


@final
@dataclass(frozen=True, slots=True)
class Resolver:
    """Resolves the texts of one file in the current state of launch."""

    file: Path
    state: LaunchState
    report: Report
    """Function that reports a finding.  The function's arguments are the location,
    rule, key, message, remedy and severity."""

    def text(self, value: Value, location: SourceLocation) -> Text:
        """Return a text, a list of texts or a substitution as a ``Text``."""
        match value:
            case str() | PurePath():
                return Text(raw=str(value), resolved=str(value), location=location)
            case list() | tuple():
                return self._joined(value, location)
            case Made():
                return self._of_made(value)
            case Choice(values=values):
                texts = [self.text(item, location) for item in values]
                whole = _concatenated(texts, location)
                reason = "it depends on something that is unknown"
                return replace(whole, resolved=None, reason=reason)
            case Unknown(reason=reason):
                return unresolved("…", reason, location)
            case bool() | int() | float():
                self.report(
                    location,
                    "bad-value",
                    repr(value),
                    f"is a {type(value).__name__} where launch takes a text: it stops "
                    "here",
                    f"write '{_as_text(value)}'",
                )
        return unresolved("…", "it is no text", location)

    def _joined(self, items: Iterable[Value], location: SourceLocation) -> Text:
        return _concatenated([self.text(item, location) for item in items], location)

    def _of_made(self, made: Made) -> Text:
        where = made.location
        match made.name:
            case "LaunchConfiguration":
                return self._configuration(made)
            case "TextSubstitution":
                return self.text(made.get("text"), where)
            case "PathJoinSubstitution" | "PathSubstitution":
                return self._path(made)
            case "FindPackageShare" | "FindPackage":
                return self._package(made)
            case "FindExecutable":
                return self.text(made.get("name"), where)
            case "EnvironmentVariable":
                return self._environment(made)
            case "ThisLaunchFileDir" | "ThisLaunchFile":
                path = self.file if made.name == "ThisLaunchFile" else self.file.parent
                return Text(raw="$(dirname)", resolved=str(path), location=where)
            case "PythonExpression":
                return self._expression(made)
            case "IfElseSubstitution" | "StringJoinSubstitution":
                return self._composed(made)
            case "Command":
                command = self.text(made.get("command"), where)
                return replace(
                    command, resolved=None, reason="it is the output of a program"
                )
        if made.name.endswith("Substitution"):
            return self._logic(made)
        return unresolved(f"$({made.name})", f"{made.name} has no value here", where)

    def _configuration(self, made: Made) -> Text:
        where = made.location
        name = self.text(made.get("variable_name"), where)
        if name.resolved is None:
            return name
        raw, key = f"$(arg {name.resolved})", name.resolved
        self.state.uses.setdefault(key, where)
        known = self.state.configurations.get(key)
        if known is not None:
            return replace(known, raw=raw, location=where, uses=(key,))
        if made.get("default") is not None:
            default = self.text(made.get("default"), where)
            return replace(default, raw=raw, uses=(key,))
        if not self.state.unread:
            valid = self.state.configurations
            self.report(
                where,
                "missing-argument",
                key,
                "is used here, and nothing before declares or sets it: launch stops "
                "here unless the command line gives it"
                + (did_you_mean(key, valid) if valid else ""),
                f'put DeclareLaunchArgument("{key}") before it into the '
                "LaunchDescription",
                severity="warning",
            )
        reason = f"argument '{key}' has no value"
        return Text(raw=raw, resolved=None, location=where, uses=(key,), reason=reason)

    def _path(self, made: Made) -> Text:
        where = made.location
        value = made.get("substitutions") or made.get("path")
        items = value if isinstance(value, list | tuple) else [value]
        texts = [self.text(item, where) for item in items]
        whole = _concatenated(texts, where, separator="/")
        if made.name == "PathSubstitution":
            whole = _concatenated(texts, where)
        if whole.resolved is None:
            return whole
        parts = [text.resolved or "" for text in texts]
        path = os.path.join(*parts) if parts else ""  # noqa: PTH118  # as launch does
        if made.name == "PathSubstitution":
            path = whole.resolved
        return replace(whole, resolved=str(source_path(Path(path))))

    def _package(self, made: Made) -> Text:
        name = self.text(made.get("package"), made.location)
        if name.resolved is None:
            return name
        return self.package_folder(name.resolved, made.location)

    def package_folder(self, name: str, where: SourceLocation) -> Text:
        """Return the share folder of a package.  Report a package that is not found."""
        raw, packages = f"$(find {name})", self.state.context.packages
        try:
            folder = packages.find(name)
            return Text(raw=raw, resolved=str(folder), location=where)
        except DescriptionError:
            near = packages.nearest(name)
        near = near if is_typo(name, near) else None
        hint = f"; did you mean '{near}'?" if near else ""
        self.report(
            where,
            "unresolved-find",
            name,
            f"is a package that is not found here{hint}",
            f"install ros-DISTRO-{name.replace('_', '-')}, or put the package into the "
            "workspace",
            severity="error" if near else "warning",
        )
        return unresolved(raw, f"package '{name}' is not found", where)

    def _environment(self, made: Made) -> Text:
        name = self.text(made.get("name"), made.location)
        default = made.get("default_value")
        if name.resolved is not None and name.resolved in os.environ:
            return replace(name, resolved=os.environ[name.resolved])
        if default is not None:
            return self.text(default, made.location)
        reason = f"the environment variable {name.raw} is not set here"
        return unresolved(f"$(env {name.raw})", reason, made.location)

    def _expression(self, made: Made) -> Text:
        text = self.text(made.get("expression"), made.location)
        if text.resolved is None:
            return text
        try:
            return replace(text, resolved=evaluate(text.resolved, {}, _no_argument))
        except NotUnderstoodError as error:
            return replace(text, resolved=None, reason=str(error))
        except EvaluationError as error:
            self.report(
                made.location,
                "bad-eval",
                text.resolved.strip()[:40],
                f"PythonExpression has no value: {error}",
                "put texts into quotation marks",
            )
            return replace(text, resolved=None, reason=str(error))

    def _composed(self, made: Made) -> Text:
        where = made.location
        if made.name == "StringJoinSubstitution":
            items = made.get("substitutions")
            texts = [self.text(item, where) for item in _list(items)]
            delimiter = self.text(made.get("delimiter") or "", where)
            return _concatenated(texts, where, separator=delimiter.resolved or "")
        condition = self.text(made.get("condition"), where)
        word = None if condition.resolved is None else as_boolean(condition.resolved)
        both = [
            self.text(made.get(key) or "", where) for key in ("if_value", "else_value")
        ]
        whole = _concatenated([condition, *both], where)
        if word is None:
            return replace(whole, resolved=None, reason=condition.reason)
        chosen = both[0] if word else both[1]
        return replace(whole, resolved=chosen.resolved, reason=chosen.reason)

    def _logic(self, made: Made) -> Text:
        """Return the value of a logic substitution, such as ``EqualsSubstitution``."""
        where = made.location
        names = ("left", "right") if "left" in made.arguments else ("value",)
        items = _list(made.get("args")) or [made.get(name) for name in names]
        texts = [
            Text(raw=str(v), resolved=str(v), location=where)
            if isinstance(v, bool | int | float)
            else self.text(v, where)
            for v in items
        ]
        whole = _concatenated(texts, where)
        if whole.resolved is None or not texts:
            return whole
        words = [text.resolved or "" for text in texts]
        truths = [as_boolean(word) for word in words]
        result: bool | None
        match made.name.removesuffix("Substitution"):
            case "Equals":
                result = words[0] == words[-1] or (
                    truths[0] is not None and truths[0] == truths[-1]
                )
            case "NotEquals":
                result = words[0] != words[-1]
            case "Not":
                result = None if truths[0] is None else not truths[0]
            case "And" | "All":
                result = None if None in truths else all(truths)
            case "Or" | "Any":
                result = None if None in truths else any(truths)
            case "Boolean":
                result = truths[0]
            case _:
                result = None
        if result is None:
            reason = f"{made.name} has no value here"
            return replace(whole, resolved=None, reason=reason)
        return replace(whole, resolved=str(result).lower())


def unresolved(raw: str, reason: str, location: SourceLocation) -> Text:
    """Return a text that has no value."""
    return Text(raw=raw, resolved=None, location=location, reason=reason)


def _concatenated(
    texts: list[Text], location: SourceLocation, separator: str = ""
) -> Text:
    values = [text.resolved for text in texts]
    known = [value for value in values if value is not None]
    resolved = separator.join(known) if len(known) == len(texts) else None
    reasons = (text.reason for text in texts if text.resolved is None)
    reason = next(reasons, "")
    if resolved is not None and len(resolved) > MAX_LENGTH:
        resolved, reason = None, f"it would be longer than {MAX_LENGTH} characters"
    return Text(
        raw=separator.join(text.raw for text in texts)[:MAX_LENGTH],
        resolved=resolved,
        location=location,
        uses=tuple(dict.fromkeys(name for text in texts for name in text.uses)),
        reason=reason,
    )


def _list(value: Value) -> list[Value]:
    return list(value) if isinstance(value, list | tuple) else []


def _as_text(value: bool | float) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _no_argument(name: str) -> object:
    raise KeyError(name)
