"""What holds at a place in a launch file: arguments, namespace, conditions."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, Severity, error_at, warning_at
from tool0.errors import SourceLocation
from tool0.lint.launch import grammar
from tool0.lint.launch.load_context import LoadContext, is_file
from tool0.lint.launch.model import (
    Condition,
    Parameter,
    Place,
    Statement,
    Text,
    all_hold,
)
from tool0.lint.launch.substitution import SubstitutionContext, resolve


@final
@dataclass(slots=True, kw_only=True)
class Scope:
    """One context of roslaunch; a file has one, and each group in it a copy."""

    context: LoadContext
    file: Path
    namespace: str | None
    values: dict[str, Text]
    """The arguments that have, or should have, a value."""
    declared: dict[str, SourceLocation] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    """The arguments that something in the file uses."""
    findings: list[Finding] = field(default_factory=list)
    conditions: tuple[Condition, ...] = ()
    private: list[Parameter] = field(default_factory=list)
    """Set so far for the nodes that follow."""
    remaps: list[Statement] = field(default_factory=list)
    environment: list[Statement] = field(default_factory=list)
    anonymous: dict[str, str] = field(default_factory=dict)

    def at(self, element: Element) -> Scope:
        """Return the scope of one element: this, under the element's conditions."""
        own = self._conditions(element)
        return replace(self, conditions=self.conditions + own) if own else self

    def group(self, namespace: str | None) -> Scope:
        """Return the scope of a group: what it declares ends with it."""
        return replace(
            self,
            namespace=namespace,
            values=dict(self.values),
            declared=dict(self.declared),
            private=list(self.private),
            remaps=list(self.remaps),
            environment=list(self.environment),
            anonymous=dict(self.anonymous),
        )

    def place(self, element: Element) -> Place:
        """Return the place of an element whose conditions this scope has."""
        return Place(
            location=self.locate(element),
            namespace=self.namespace,
            conditions=self.conditions,
        )

    @property
    def holds(self) -> bool | None:
        """Whether roslaunch would act on what stands here; None if unknown."""
        return all_hold(self.conditions)

    def locate(self, element: Element) -> SourceLocation:
        """Return where an element stands."""
        return getattr(element, "location", None) or SourceLocation(self.file)

    def text(self, element: Element, name: str) -> Text | None:
        """Return an attribute with its words replaced; None if there is none."""
        if not element.hasAttribute(name):
            return None
        return self.resolved(element.getAttribute(name), self.locate(element))

    def required(self, element: Element, name: str) -> Text:
        """Return an attribute that must be there; unresolved if it is missing."""
        text = self.text(element, name)
        if text is not None:
            return text
        return Text(
            raw="",
            resolved=None,
            location=self.locate(element),
            reason=f"'{name}' is missing",
        )

    def resolved(self, raw: str, location: SourceLocation) -> Text:
        """Return a text with its words replaced, and report what is wrong with it."""
        around = SubstitutionContext(
            file=self.file,
            values=self.values,
            declared=frozenset(self.declared),
            packages=self.context.packages,
            anonymous=self._anonymous,
        )
        text, problems = resolve(raw, location, around)
        self.used.update(text.uses)
        if self.holds is not False:
            self.findings += problems
        length = len(raw) + len(text.resolved or "")
        if not self.context.spend("characters", length):
            return replace(text, resolved=None, reason="too much text in these files")
        return text

    def boolean(self, element: Element, name: str) -> bool:
        """Return an attribute that is ``true`` or ``false``; False if it is neither."""
        text = self.text(element, name)
        word = None if text is None else text.resolved
        if word is None or word.lower() in ("true", "false"):
            return word is not None and word.lower() == "true"
        self.report(
            self.locate(element),
            "bad-value",
            name,
            f"must be true or false, and is '{word}': roslaunch stops here",
            f'write {name}="true" or {name}="false"',
        )
        return False

    def require_file(self, text: Text, user: str) -> None:
        """Report a file that does not exist."""
        if text.resolved is None or is_file(text.resolved):
            return
        self.report(
            text.location,
            "missing-file",
            text.resolved,
            f"does not exist, and {user} needs it",
            "correct the path; $(find PACKAGE)/… begins in a package, $(dirname)/… in "
            "the launch file's folder",
        )

    def words(self, text: Text) -> tuple[str, ...]:
        """Return the words of a command line."""
        if text.resolved is None:
            return ()
        try:
            return tuple(shlex.split(text.resolved))
        except ValueError as error:
            self.report(
                text.location,
                "bad-command",
                text.resolved.strip()[:40],
                f"is no command line: {error}",
                "close the quotation marks",
            )
            return ()

    def namespace_of(self, element: Element) -> str | None:
        """Return the namespace that an element's ``ns`` opens within this one."""
        text = self.text(element, "ns")
        clears = self.boolean(element, "clear_params")
        is_node = element.tagName in ("node", "test")
        if clears and not is_node and not (text is not None and text.raw):
            self.report(
                self.locate(element),
                "bad-value",
                "clear_params",
                "needs ns beside it, to say which parameters go",
                'write ns="…"',
            )
        if text is None:
            return self.namespace
        if text.resolved == "":
            self.report(
                text.location,
                "bad-value",
                "ns",
                "is empty: roslaunch stops here",
                "remove it, or name a namespace",
            )
            return self.namespace
        if text.resolved is None or self.namespace is None:
            return None
        return grammar.as_namespace(grammar.join(self.namespace, text.resolved))

    def report(
        self,
        location: SourceLocation,
        rule: str,
        key: str,
        message: str,
        remedy: str = "",
        *,
        severity: Severity = "error",
    ) -> None:
        """Add a finding, unless the element is switched off."""
        if self.holds is not False:
            finding_at = error_at if severity == "error" else warning_at
            self.findings.append(finding_at(location, rule, key, message, remedy))

    def _anonymous(self, name: str) -> str:
        if name not in self.anonymous:
            self.anonymous[name] = self.context.anonymous(name)
        return self.anonymous[name]

    def _conditions(self, element: Element) -> tuple[Condition, ...]:
        found = []
        kinds: tuple[Literal["if", "unless"], ...] = ("if", "unless")
        for kind in kinds:
            text = self.text(element, kind)
            if text is None:
                continue
            word = None
            if text.resolved is not None:
                word = grammar.as_boolean(text.resolved)
                if word is None:
                    self.report(
                        text.location,
                        "bad-if",
                        kind,
                        f"must be true, false, 1 or 0, and is '{text.resolved}': "
                        "roslaunch stops here",
                        f"write $(eval …) in {kind}, or give the argument such a value",
                    )
            holds = None if word is None else word is (kind == "if")
            found.append(Condition(kind=kind, text=text, holds=holds))
        if len(found) == 2:
            self.report(
                self.locate(element),
                "bad-if",
                element.tagName,
                "has both if and unless, and roslaunch stops here",
                "join them in one if with $(eval …)",
            )
        return tuple(found)
