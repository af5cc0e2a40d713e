"""The scope at a place in a launch file: arguments, namespace and conditions."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, Severity, error_at
from tool0.description.xml_source import children
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
from tool0.lint.launch.substitution import Substitution
from tool0.lint.robot.elements import Tag


@final
@dataclass(slots=True, kw_only=True)
class Scope:
    """One element, and its context in roslaunch.

    A file has one context, which its elements share.  Each group in the file has a copy
    of the file's context.
    """

    context: LoadContext
    file: Path
    element: Element
    namespace: str | None
    values: dict[str, Text] = field(default_factory=dict)
    """Arguments that have a value or should have a value."""
    declared: dict[str, SourceLocation] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    """Arguments that are used in the file."""
    findings: list[Finding] = field(default_factory=list)
    conditions: tuple[Condition, ...] = ()
    private: list[Parameter] = field(default_factory=list)
    """Private parameters that have been set, for the nodes that follow."""
    remaps: list[Statement] = field(default_factory=list)
    environment: list[Statement] = field(default_factory=list)
    anonymous: dict[str, str] = field(default_factory=dict)

    def at(self, element: Element) -> Scope:
        """Return the scope of another element.

        The conditions of the other element are added.
        """
        inner = replace(self, element=element)
        inner.conditions += inner._conditions()
        return inner

    def children(self) -> Iterator[Scope]:
        """Yield the scope of each child element that roslaunch allows here."""
        for child in children(self.element):
            if child.tagName in grammar.CHILDREN[self.tag]:
                inner = self.at(child)
                self.findings += grammar.findings(Tag(child))
                yield inner

    def group(self, namespace: str | None) -> Scope:
        """Return the scope of a group.

        Declarations in the group end with the group.
        """
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

    @property
    def place(self) -> Place:
        """Place of the element."""
        return Place(
            location=self.location,
            namespace=self.namespace,
            conditions=self.conditions,
        )

    @property
    def holds(self) -> bool | None:
        """Whether roslaunch would process the element; None if this is unknown."""
        return all_hold(self.conditions)

    @property
    def tag(self) -> str:
        """Tag name of the element."""
        return self.element.tagName

    @property
    def location(self) -> SourceLocation:
        """Location of the element."""
        return getattr(self.element, "location", None) or SourceLocation(self.file)

    def text(self, name: str) -> Text | None:
        """Return an attribute with its substitutions; None if it is missing."""
        if not self.element.hasAttribute(name):
            return None
        return self.resolved(self.element.getAttribute(name), self.location)

    def required(self, name: str) -> Text:
        """Return a required attribute, or an unresolved text if it is missing."""
        reason = f"'{name}' is missing"
        missing = Text(raw="", resolved=None, location=self.location, reason=reason)
        return self.text(name) or missing

    def resolved(self, raw: str, location: SourceLocation) -> Text:
        """Return a text with its substitutions, and report their faults."""
        work = Substitution(
            file=self.file,
            location=location,
            values=self.values,
            declared=self.declared,
            packages=self.context.packages,
            anonymous=self._anonymous,
        )
        text = work.resolve(raw)
        self.used.update(text.uses)
        if self.holds is not False:
            self.findings += work.problems
        length = len(raw) + len(text.resolved or "")
        if not self.context.spend("characters", length):
            return replace(text, resolved=None, reason="too much text in these files")
        return text

    def boolean(self, name: str) -> bool:
        """Return a ``true`` or ``false`` attribute as a bool.

        Other values give False.
        """
        text = self.text(name)
        word = "false" if text is None or text.resolved is None else text.resolved
        if word.lower() not in ("true", "false"):
            self.report(
                "bad-value",
                name,
                f"must be true or false, and is '{word}': roslaunch stops here",
                f'write {name}="true" or {name}="false"',
            )
        return word.lower() == "true"

    def require_file(self, text: Text, user: str) -> None:
        """Report an error if a file does not exist."""
        if text.resolved is not None and not is_file(text.resolved):
            self.report(
                "missing-file",
                text.resolved,
                f"does not exist, and {user} needs it",
                "correct the path; $(find PACKAGE)/… begins in a package, $(dirname)/… "
                "in the launch file's folder",
            )

    def words(self, text: Text) -> tuple[str, ...]:
        """Return the words of a command line."""
        if text.resolved is None:
            return ()
        try:
            return tuple(shlex.split(text.resolved))
        except ValueError as error:
            self.report(
                "bad-command",
                text.resolved.strip()[:40],
                f"is no command line: {error}",
                "close the quotation marks",
            )
            return ()

    def inner_namespace(self) -> str | None:
        """Return the full namespace inside the element, which ``ns`` may extend."""
        text = self.text("ns")
        clears = self.boolean("clear_params")
        if clears and self.tag not in ("node", "test") and not (text and text.raw):
            self.report(
                "bad-value",
                "clear_params",
                "needs ns as well, to select the parameters to clear",
                'write ns="…"',
            )
        if text is None:
            return self.namespace
        if text.resolved == "":
            self.report(
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
        rule: str,
        key: str,
        message: str,
        remedy: str = "",
        *,
        severity: Severity = "error",
        location: SourceLocation | None = None,
    ) -> None:
        """Add a finding about the element unless the element is inactive."""
        if self.holds is not False:
            where = location or self.location
            self.findings.append(
                error_at(where, rule, key, message, remedy, severity=severity)
            )

    def _anonymous(self, name: str) -> str:
        if name not in self.anonymous:
            self.anonymous[name] = self.context.anonymous(name)
        return self.anonymous[name]

    def _conditions(self) -> tuple[Condition, ...]:
        found = []
        kinds: tuple[Literal["if", "unless"], ...] = ("if", "unless")
        for kind in kinds:
            text = self.text(kind)
            if text is None:
                continue
            word = None if text.resolved is None else grammar.as_boolean(text.resolved)
            if word is None and text.resolved is not None:
                self.report(
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
                "bad-if",
                self.tag,
                "has both if and unless, and roslaunch stops here",
                "join them in one if with $(eval …)",
            )
        return tuple(found)
