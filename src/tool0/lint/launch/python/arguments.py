"""The arguments that a Python launch file declares."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import final

from tool0.errors import SourceLocation, did_you_mean
from tool0.lint.launch.model import Argument, Origin, Text
from tool0.lint.launch.python.substitution import Resolver
from tool0.lint.launch.python.values import Made


@final
class DeclaredArguments:
    """Records the arguments of one file while its actions are executed."""

    def __init__(self, file: Path, given: Mapping[str, Origin]) -> None:
        self.found: list[Argument] = []
        self.missing: list[Argument] = []
        """Arguments without a value."""
        self._file, self._given = file, given

    def declare(self, made: Made, resolver: Resolver) -> None:
        """Process a ``DeclareLaunchArgument`` action."""
        state = resolver.state
        name = resolver.text(made.get("name"), made.location).resolved
        if name is None:
            state.unread.append("an argument whose name is unknown")
            return
        default = made.get("default_value")
        text = None
        if default is not None:
            text = resolver.text(default, made.place("default_value"))
        place = state.place(made.location)
        known = state.configurations.get(name)
        argument = Argument(name=name, place=place, origin="missing", default=text)
        if state.holds is False:
            argument = replace(argument, origin="switched off")
        elif known is not None:
            origin = self._given.get(name, "include")
            argument = replace(argument, value=known, origin=origin)
        elif text is not None:
            argument = replace(argument, value=state.if_active(text), origin="default")
        self._refuse_twice(argument, resolver)
        self.found.append(argument)
        if argument.origin == "switched off":
            return
        value = argument.value
        if value is None:
            self.missing.append(argument)
            reason = f"argument '{name}' has no value"
            value = Text(raw="", resolved=None, location=made.location, reason=reason)
        state.configurations[name] = value
        self._check_choice(made, name, value, resolver)

    def _refuse_twice(self, argument: Argument, resolver: Resolver) -> None:
        first = next((a for a in self.found if a.name == argument.name), None)
        if first is None or None in (first.place.holds, argument.place.holds):
            return
        resolver.report(
            argument.place.location,
            "duplicate-argument",
            argument.name,
            f"is declared at {first.place.location} already: this default has no "
            "effect",
            "remove one of them",
            severity="warning",
        )

    def _check_choice(
        self, made: Made, name: str, value: Text, resolver: Resolver
    ) -> None:
        choices = made.get("choices")
        if not isinstance(choices, list | tuple) or value.resolved is None:
            return
        words = [item for item in choices if isinstance(item, str)]
        if len(words) == len(choices) and value.resolved not in words:
            is_own = value.location.file == self._file
            resolver.report(
                value.location if is_own else made.location,
                "bad-value",
                name,
                f"is '{value.resolved}', which is none of its choices: launch stops "
                "here" + did_you_mean(value.resolved, words),
                "add it to choices, or write one of them",
            )

    def report_unused(self, resolver: Resolver, texts: Sequence[str]) -> None:
        """Report arguments that are used neither in this file nor in an included file.

        Args:
            resolver: The resolver in its state at the end of the file.
            texts: All texts in the file.  A text that equals an argument's name is
                treated as a use of the argument if the text occurs more than once.
        """
        if resolver.state.unread:
            return
        for argument in self.found:
            name = argument.name
            is_named = texts.count(name) > 1
            if not is_named and name not in resolver.state.uses:
                resolver.report(
                    argument.place.location,
                    "unused-argument",
                    name,
                    "is declared, and nothing uses it: its value has no effect",
                    f'use it as LaunchConfiguration("{name}"), or remove it',
                    severity="warning",
                )

    def report_unknown(self, given: Iterable[str], resolver: Resolver) -> None:
        """Report command-line arguments that the file does not declare."""
        declared = {argument.name for argument in self.found}
        for name in given:
            if name not in declared:
                resolver.report(
                    SourceLocation(self._file),
                    "unused-argument",
                    name,
                    "is given on the command line, and the file declares no such "
                    "argument" + did_you_mean(name, declared),
                    severity="warning",
                )
