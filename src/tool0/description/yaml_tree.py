"""YAML as rosparam reads it, with the line of every key."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, final

from tool0.description.finding import Finding
from tool0.errors import ConfigError, SourceLocation

if TYPE_CHECKING:
    import yaml

Scalar = str | float | int | bool | None

MOST_ENTRIES = 30_000
"""Of one text: a few lines of aliases can stand for billions."""
_ANGLE = re.compile(r"(deg|rad)\(([^)]*)\)")
"""rosparam's ``deg(90)`` and ``rad(pi/2)``, of which numbers are understood here."""


@final
@dataclass(slots=True)
class Entry:
    """A value of the parameter tree: a number, a text, a list or a namespace."""

    key: str
    """The full name: ``arm_controller/gains/elbow_joint/p``."""
    location: SourceLocation
    scalar: Scalar = None
    items: list[Entry] | None = None
    """The elements, if it is a list."""
    children: dict[str, Entry] | None = None
    """The keys below, if it is a namespace."""

    @property
    def is_null(self) -> bool:
        """Whether nothing stands after the key."""
        return (self.scalar, self.items, self.children) == (None, None, None)

    def describe(self) -> str:
        """Return what a message calls the value."""
        if self.children is not None:
            return "a mapping"
        return "a list" if self.items is not None else f"{self.scalar!r}"

    def plain(self) -> object:
        """Return the value as YAML's own: mappings, lists, scalars."""
        if self.children is not None:
            return {name: child.plain() for name, child in self.children.items()}
        if self.items is not None:
            return [item.plain() for item in self.items]
        return self.scalar

    def leaves(self) -> Iterator[Entry]:
        """Yield every value that is no namespace, depth first."""
        if self.children is None:
            yield self
        for child in (self.children or {}).values():
            yield from child.leaves()


@final
@dataclass(slots=True)
class Tree:
    """All parameters of one or several files; later ones override, as in ROS."""

    root: Entry = field(
        default_factory=lambda: Entry("", SourceLocation(None), children={})
    )
    findings: list[Finding] = field(default_factory=list)
    """What is suspicious, yet can be read."""

    def load(self, text: str, location: SourceLocation) -> None:
        """Put the parameters of a YAML text over those that are there.

        Args:
            text: The YAML.
            location: Where its first line stands.

        Raises:
            ConfigError: If it is not YAML, or not a mapping.
        """
        node = _compose(text, location)
        if node is None:
            return
        entry = _Reader(location, self.findings).entry(node, "")
        if entry.children is None:
            raise ConfigError(
                f"expected a mapping of parameters, got {entry.describe()}",
                entry.location,
            )
        _merge(self.root, entry)


def _compose(text: str, location: SourceLocation) -> yaml.Node | None:
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        node: yaml.Node | None = yaml.compose(text, Loader=loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        line = (location.line or 1) + (mark.line if mark is not None else 0)
        raise ConfigError(
            f"not YAML: {error.problem or error}"
            + (f" ({error.context})" if error.context else ""),
            SourceLocation(location.file, line),
        ) from None
    except yaml.YAMLError as error:
        raise ConfigError(f"not YAML: {error}", location) from None
    return node


def _merge(target: Entry, source: Entry) -> None:
    """Put ``source`` over ``target``; both are namespaces."""
    if target.children is None:
        target.children = {}
    for name, child in (source.children or {}).items():
        present = target.children.get(name)
        if present is None or present.children is None or child.children is None:
            target.children[name] = child
        else:
            _merge(present, child)


@final
class _Reader:
    """Turns the nodes of one text into entries."""

    def __init__(self, location: SourceLocation, findings: list[Finding]) -> None:
        self._file = location.file
        self._first_line = location.line or 1
        self._findings = findings
        self._open: list[yaml.Node] = []
        self._left = MOST_ENTRIES

    def entry(self, node: yaml.Node, key: str) -> Entry:
        import yaml

        where = self._where(node)
        self._left -= 1
        if self._left < 0:
            raise ConfigError(
                f"holds more than {MOST_ENTRIES:,} values, its aliases counted; "
                "look for aliases of aliases",
                where,
            )
        if any(node is outer for outer in self._open):
            raise ConfigError(f"'{key}' contains itself by an alias", where)
        self._open.append(node)
        try:
            if isinstance(node, yaml.MappingNode):
                return self._namespace(node, key)
            if isinstance(node, yaml.SequenceNode):
                items = [
                    self.entry(item, f"{key}[{number}]")
                    for number, item in enumerate(node.value)
                ]
                return Entry(key, where, items=items)
            return Entry(key, where, scalar=_scalar(node, key, where))
        finally:
            self._open.pop()

    def _namespace(self, node: yaml.MappingNode, key: str) -> Entry:
        result = Entry(key, self._where(node), children={})
        seen: set[str] = set()
        for name_node, value in self._pairs(node):
            name = str(name_node.value)
            where = self._where(name_node)
            if not name_node.tag.endswith(":str"):
                raise ConfigError(
                    f"key {name!r} under '{key or '/'}' must be a text; quote it", where
                )
            path = [part for part in name.split("/") if part]
            if not path:
                raise ConfigError(f"key {name!r} names no parameter", where)
            child = self.entry(value, "/".join([*([key] if key else []), *path]))
            child.location = where
            if name in seen:
                self._findings.append(
                    Finding(
                        location=where,
                        rule="duplicate-key",
                        key=child.key,
                        message="stands twice in one mapping; the last one wins",
                        remedy="leave one",
                    )
                )
            seen.add(name)
            for depth in range(len(path) - 1, 0, -1):
                outer = "/".join([*([key] if key else []), *path[:depth]])
                child = Entry(outer, where, children={path[depth]: child})
            _merge(result, Entry(key, where, children={path[0]: child}))
        return result

    def _pairs(self, node: yaml.MappingNode) -> Iterator[tuple[yaml.Node, yaml.Node]]:
        """Yield keys and values, those of ``<<`` first unless they are overridden."""
        import yaml

        own = [pair for pair in node.value if not pair[0].tag.endswith(":merge")]
        names = {name.value for name, _ in own}
        for name, value in node.value:
            if not name.tag.endswith(":merge"):
                continue
            sources = value.value if isinstance(value, yaml.SequenceNode) else [value]
            for source in sources:
                if not isinstance(source, yaml.MappingNode):
                    raise ConfigError("'<<' needs a mapping", self._where(name))
                for merged_name, merged in self._pairs(source):
                    if merged_name.value not in names:
                        names.add(merged_name.value)
                        yield merged_name, merged
        yield from own

    def _where(self, node: yaml.Node) -> SourceLocation:
        return SourceLocation(self._file, self._first_line + node.start_mark.line)


def _scalar(node: yaml.Node, key: str, where: SourceLocation) -> Scalar:
    """Return the value that ROS's parameter server would hold."""
    import yaml

    text = str(node.value)
    if node.tag in ("!degrees", "!radians"):
        return _angle(node.tag == "!degrees", text, key, where)
    match = _ANGLE.fullmatch(text)
    if match is not None and node.tag.endswith(":str"):
        return _angle(match[1] == "deg", match[2], key, where)
    if node.tag.endswith((":int", ":float", ":bool", ":null")):
        try:
            value: Scalar = yaml.SafeLoader("").construct_object(node)
        except (ValueError, yaml.YAMLError) as error:
            raise ConfigError(f"'{key}' is {text!r}: {error}", where) from None
        return value
    if node.tag.startswith("!"):
        raise ConfigError(
            f"'{key}' has the tag {node.tag}; known are !degrees and !radians", where
        )
    return text


def _angle(is_degrees: bool, text: str, key: str, where: SourceLocation) -> float:
    try:
        value = float(text)
    except ValueError:
        raise ConfigError(f"'{key}' must be an angle, got {text!r}", where) from None
    return math.radians(value) if is_degrees else value


def read_files(files: list[Path]) -> Tree:
    """Return the parameters of all files, of which later ones override."""
    tree = Tree()
    for file in files:
        try:
            text = file.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else error.reason
            raise ConfigError(
                f"cannot read the file: {reason}", SourceLocation(file)
            ) from None
        tree.load(text, SourceLocation(file, 1))
    return tree
