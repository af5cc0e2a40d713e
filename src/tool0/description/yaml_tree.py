"""A YAML text as a tree of entries; each entry is a value with full key, file and line.

Controllers, scenes, launch files, the linter and xacro read YAML through this module.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from tool0.description.finding import Finding, Severity, error_at
from tool0.description.units import ANGLE, ANGLE_TAGS, is_ros_angle, read_number
from tool0.errors import ConfigError, SourceLocation

if TYPE_CHECKING:
    import yaml

Scalar = str | float | int | bool | None
Constructor = Callable[[Any, Any], Any]
"""Constructor of a tagged scalar, with PyYAML's loader and node as arguments."""

MOST_ENTRIES = 30_000
"""Largest number of values in one text.  The number is limited, since a few lines with
aliases can represent billions of values."""
MOST_LEVELS = 100
"""Largest nesting depth of lists and mappings."""


@final
@dataclass(slots=True)
class YamlEntry:
    """A YAML value: a scalar, a list or a mapping."""

    key: str
    """Full key, such as ``arm_controller/gains/elbow_joint/p``."""
    location: SourceLocation
    value: Scalar | list[YamlEntry] | dict[str, YamlEntry] = None

    @property
    def is_mapping(self) -> bool:
        return isinstance(self.value, dict)

    @property
    def is_list(self) -> bool:
        return isinstance(self.value, list)

    @property
    def is_null(self) -> bool:
        """Whether the key has no value."""
        return self.value is None

    @property
    def scalar(self) -> Scalar:
        """Value of a number, string or boolean; None for other entries."""
        return None if isinstance(self.value, list | dict) else self.value

    @property
    def items(self) -> list[YamlEntry]:
        """Elements of a list; empty if the entry is not a list."""
        return self.value if isinstance(self.value, list) else []

    @property
    def children(self) -> dict[str, YamlEntry]:
        """Entries of a mapping by key; empty if the entry is not a mapping."""
        return self.value if isinstance(self.value, dict) else {}

    def find(self, path: str) -> YamlEntry | None:
        """Return the entry at a path such as ``a/b`` below this entry, or None."""
        entry: YamlEntry | None = self
        for part in path.split("/"):
            entry = None if entry is None else entry.children.get(part)
        return entry

    def describe(self) -> str:
        """Return a description of the value for messages."""
        if self.is_mapping:
            return "a mapping"
        if self.is_list:
            return "a list" if self.items else "an empty list"
        return f"{self.scalar!r}"

    def plain(self) -> object:
        """Return the value as Python dicts, lists and scalars."""
        if self.is_mapping:
            return {name: child.plain() for name, child in self.children.items()}
        return [item.plain() for item in self.items] if self.is_list else self.scalar

    def finding(
        self, rule: str, message: str, remedy: str = "", severity: Severity = "error"
    ) -> Finding:
        """Return a finding about this entry."""
        return error_at(
            self.location, rule, self.key, message, remedy, severity=severity
        )

    def leaves(self) -> Iterator[YamlEntry]:
        """Yield every value that is not a mapping, in depth-first order."""
        if not self.is_mapping:
            yield self
        for child in self.children.values():
            yield from child.leaves()


@final
@dataclass(slots=True)
class Tree:
    """All parameters of one or more files.

    Parameters of later files override those of earlier files, as in ROS.
    """

    root: YamlEntry = field(
        default_factory=lambda: YamlEntry("", SourceLocation(None), {})
    )
    findings: list[Finding] = field(default_factory=list)
    """Findings about entries that are readable but suspicious."""

    def load(self, text: str, location: SourceLocation) -> None:
        """Merge the parameters of a YAML text into the tree, replacing existing values.

        Raises:
            ConfigError: If the text is not YAML or not a mapping.  ``location`` is the
                location of the text's first line.
        """
        entry = _TreeReader(location, self.findings).read(text)
        if entry is not None and not entry.is_mapping:
            raise ConfigError(
                f"expected a mapping of parameters, got {entry.describe()}",
                entry.location,
            )
        if entry is not None:
            _merge(self.root, entry)

    def require_unique_keys(self) -> None:
        """Raise ConfigError for the first duplicate key."""
        for finding in self.findings:
            raise ConfigError(
                f"'{finding.key}' occurs twice; {finding.remedy}", finding.location
            )


def read_mapping(file: Path) -> YamlEntry:
    """Return the mapping in a YAML file, which is read with ``read_verbatim``.

    Raises:
        ConfigError: If the file cannot be read, is not YAML, is not a mapping, or
            contains a key twice.
    """
    tree = read_verbatim(file)
    tree.require_unique_keys()
    root = tree.root
    if root.is_null:
        root.value = {}
    elif not root.is_mapping:
        raise ConfigError(f"expected a mapping, got {root.describe()}", root.location)
    return root


def read_verbatim(file: Path, units: Mapping[str, Constructor] | None = None) -> Tree:
    """Return the content of a YAML file.

    The root is null if the file is empty.  Keys and strings are not changed: slashes
    and angles do not have rosparam's meaning.  ``!degrees 90`` is returned as the text
    ``90deg``, which ``read_number`` accepts.  If ``units`` is given, it maps tags of
    scalars to their constructors.

    Raises:
        ConfigError: If the file cannot be read, or is not YAML.
    """
    return read_verbatim_text(text_of(file), SourceLocation(file, 1), units)


def read_verbatim_text(
    text: str, start: SourceLocation, units: Mapping[str, Constructor] | None = None
) -> Tree:
    """Return the content of a YAML text, as ``read_verbatim`` does.

    ``start`` is the location of the text's first line.

    Raises:
        ConfigError: If the text is not YAML.
    """
    findings = list[Finding]()
    entry = _TreeReader(start, findings, units or {}).read(text)
    return Tree(entry or YamlEntry("", start), findings)


def text_of(file: Path) -> str:
    """Return the text of a UTF-8 file, or raise ConfigError if it cannot be read."""
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error.reason
        raise ConfigError(
            f"cannot read the file: {reason}", SourceLocation(file)
        ) from None


def require_yaml(text: str, location: SourceLocation) -> None:
    """Raise ConfigError if a text cannot be parsed, or is nested too deeply.

    Parsing is not recursive.  Composing is recursive, and deep nesting would cause a
    stack overflow in the C library.
    """
    import yaml

    depth = 0
    try:
        for event in yaml.parse(text, Loader=_loader()):
            if isinstance(event, yaml.CollectionStartEvent):
                depth += 1
                if depth > MOST_LEVELS:
                    raise _too_deep(_line_of(event.start_mark, location))
            elif isinstance(event, yaml.CollectionEndEvent):
                depth -= 1
    except yaml.YAMLError as error:
        raise _not_yaml(error, location) from None


def _loader() -> Any:
    import yaml

    return getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def _not_yaml(error: yaml.YAMLError, location: SourceLocation) -> ConfigError:
    import yaml

    if not isinstance(error, yaml.MarkedYAMLError):
        return ConfigError(f"not YAML: {error}", location)
    where = _line_of(error.problem_mark, location)
    # The C library limits the nesting of brackets.
    if "nesting depth" in str(error.problem):
        return _too_deep(where)
    context = f" ({error.context})" if error.context else ""
    return ConfigError(f"not YAML: {error.problem or error}{context}", where)


def _too_deep(where: SourceLocation) -> ConfigError:
    return ConfigError(
        f"more than {MOST_LEVELS} lists and mappings are nested here", where
    )


def _line_of(mark: Any, first: SourceLocation) -> SourceLocation:
    """Return the location of a PyYAML mark in a text that starts at ``first``."""
    line = (first.line or 1) + (0 if mark is None else mark.line)
    return SourceLocation(first.file, line)


def merged(*entries: YamlEntry) -> YamlEntry:
    """Return a copy of the first mapping, updated with the other mappings."""
    result = YamlEntry(entries[0].key, entries[0].location, {})
    for entry in entries:
        _merge(result, _copied(entry))
    return result


def _copied(entry: YamlEntry) -> YamlEntry:
    """Return a copy of an entry, including the mappings inside it."""
    if not entry.is_mapping:
        return entry
    children = {name: _copied(child) for name, child in entry.children.items()}
    return YamlEntry(entry.key, entry.location, children)


def _merge(target: YamlEntry, source: YamlEntry) -> None:
    """Merge the mapping ``source`` into the mapping ``target``."""
    for name, child in source.children.items():
        present = target.children.get(name)
        if present is not None and present.is_mapping and child.is_mapping:
            _merge(present, child)
        else:
            target.children[name] = child


@final
class _TreeReader:
    """Converter from the YAML nodes of one text to entries."""

    def __init__(
        self,
        location: SourceLocation,
        findings: list[Finding],
        units: Mapping[str, Constructor] | None = None,
    ) -> None:
        import yaml

        self._location = location
        self._findings = findings
        self._units = units
        self._open: list[yaml.Node] = []
        self._left = MOST_ENTRIES
        self._loader = yaml.SafeLoader("")

    def read(self, text: str) -> YamlEntry | None:
        """Return the root entry of the text; None if it is empty."""
        import yaml

        require_yaml(text, self._location)
        try:
            node: yaml.Node | None = yaml.compose(text, Loader=_loader())
        except yaml.YAMLError as error:
            raise _not_yaml(error, self._location) from None
        return None if node is None else self._entry(node, "")

    def _entry(self, node: yaml.Node, key: str) -> YamlEntry:
        import yaml

        where = self._where(node)
        self._open_node(node, key, where)
        if isinstance(node, yaml.MappingNode):
            entry = self._mapping(node, key)
        elif isinstance(node, yaml.SequenceNode):
            items = [
                self._entry(item, f"{key}[{number}]")
                for number, item in enumerate(node.value)
            ]
            entry = YamlEntry(key, where, items)
        else:
            entry = YamlEntry(key, where, self._scalar(node, key, where))
        self._open.pop()
        return entry

    def _open_node(self, node: yaml.Node, key: str, where: SourceLocation) -> None:
        """Count a node, and raise ConfigError if aliases expand the text too much."""
        self._left -= 1
        if self._left < 0:
            raise ConfigError(
                f"holds more than {MOST_ENTRIES:,} values, its aliases counted; "
                "look for aliases of aliases",
                where,
            )
        if node in self._open:  # nodes are compared by identity
            raise ConfigError(f"'{key}' contains itself by an alias", where)
        if len(self._open) >= MOST_LEVELS:
            raise _too_deep(where)
        self._open.append(node)

    def _mapping(self, node: yaml.Node, key: str) -> YamlEntry:
        result = YamlEntry(key, self._where(node), {})
        seen: set[str] = set()
        for name, name_node, value in self._pairs(node, key):
            where = self._where(name_node)
            path = self._path(name, name_node, key)
            child = self._entry(value, _joined(key, path))
            child.location = where
            if name in seen:
                message = "occurs twice in one mapping; the last one takes effect"
                found = child.finding("duplicate-key", message, "leave one")
                self._findings.append(found)
            seen.add(name)
            for depth in range(len(path) - 1, 0, -1):
                child = YamlEntry(
                    _joined(key, path[:depth]), where, {path[depth]: child}
                )
            _merge(result, YamlEntry(key, where, {path[0]: child}))
        return result

    def _path(self, name: str, name_node: yaml.Node, key: str) -> list[str]:
        """Return the names in a key; in ROS, ``a/b`` means ``b`` in namespace ``a``."""
        where = self._where(name_node)
        if self._units is not None:
            if not name:
                raise ConfigError(f"a key under '{key or '/'}' is empty", where)
            return [name]
        if not name_node.tag.endswith(":str"):
            raise ConfigError(
                f"key {name!r} under '{key or '/'}' must be a string; quote it", where
            )
        path = [part for part in name.split("/") if part]
        if not path:
            raise ConfigError(f"key {name!r} names no parameter", where)
        return path

    def _pairs(
        self, node: yaml.Node, key: str
    ) -> Iterator[tuple[str, yaml.Node, yaml.Node]]:
        """Yield the keys and values of a mapping, including those merged by ``<<``.

        The pairs of ``<<`` come first.  Overridden pairs are left out.
        """
        import yaml

        own = [
            (self._name(name, key), name, value)
            for name, value in node.value
            if not name.tag.endswith(":merge")
        ]
        names = {name for name, *_ in own}
        for merge, value in node.value:
            if not merge.tag.endswith(":merge"):
                continue
            where = self._where(merge)
            sources = value.value if isinstance(value, yaml.SequenceNode) else [value]
            for source in sources:
                if not isinstance(source, yaml.MappingNode):
                    raise ConfigError("'<<' needs a mapping", where)
                self._open_node(source, f"{key}/<<", where)
                merged = list(self._pairs(source, key))
                self._open.pop()
                for pair in merged:
                    if pair[0] not in names:
                        names.add(pair[0])
                        yield pair
        yield from own

    def _name(self, node: yaml.Node, key: str) -> str:
        """Return a key, which must be a scalar."""
        if not isinstance(node.value, str):
            raise ConfigError(
                f"a key under '{key or '/'}' is a list or a mapping; it must be a text",
                self._where(node),
            )
        return node.value

    def _where(self, node: yaml.Node) -> SourceLocation:
        return _line_of(node.start_mark, self._location)

    def _scalar(self, node: yaml.Node, key: str, where: SourceLocation) -> Scalar:
        """Return the value that ROS's parameter server would store."""
        import yaml

        text = str(node.value)
        try:
            if self._units is not None and node.tag in self._units:
                value: Scalar = self._units[node.tag](self._loader, node)
                return value
            if node.tag.endswith((":int", ":float", ":bool", ":null")):
                value = self._loader.construct_object(node)
                return value
        except (ValueError, yaml.YAMLError) as error:
            raise ConfigError(f"'{key}' is {text!r}: {error}", where) from None
        written = text + ANGLE_TAGS.get(node.tag, "")
        if self._units is None:
            is_text = node.tag.endswith(":str")
            if node.tag in ANGLE_TAGS or (is_text and is_ros_angle(text)):
                try:
                    return read_number(written, ANGLE)[0]
                except ConfigError:
                    raise ConfigError(
                        f"'{key}' must be an angle, got {text!r}", where
                    ) from None
        elif not self._units and node.tag in ANGLE_TAGS:
            return written
        if node.tag.startswith("!"):
            known = " and ".join(self._units or ANGLE_TAGS)
            raise ConfigError(
                f"'{key}' has the tag {node.tag}; known are {known}", where
            )
        return text


def _joined(key: str, path: list[str]) -> str:
    return "/".join([key, *path] if key else path)
