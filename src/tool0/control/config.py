"""The ROS 1 or ROS 2 controllers that YAML files describe."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, final

from tool0.control.controller import ControllerSpec
from tool0.control.dialect import Declared, Dialect
from tool0.control.joint_limits import read_joint_limits
from tool0.control.parameters import RobotJoints
from tool0.control.ros1.dialect import ROS1
from tool0.control.ros2.dialect import ROS2
from tool0.control.ros2.layout import is_ros2
from tool0.control.ros2.substitution import substituted
from tool0.description.finding import Finding
from tool0.description.packages import packages_around, preferring
from tool0.description.yaml_tree import Scalar, Tree, YamlEntry, merged, text_of
from tool0.description.yaml_values import Namespace, Value
from tool0.errors import ConfigError, SourceLocation, did_you_mean


class ControllerParameters(NamedTuple):
    """The parameters of a controller, by dotted name."""

    values: Mapping[str, Value]
    adjustable: frozenset[str]
    """Parameters that may change while the controller runs."""


@final
class ControllerConfig:
    """The controllers that YAML files describe.

    Each controller is checked when it is loaded.

    The layout of the files determines the ROS version: the key ``ros__parameters``
    indicates ROS 2.
    """

    def __init__(self, tree: Tree, dialect: Dialect | None = None) -> None:
        """Store the content of files.

        If ``dialect`` is None, the layout of the files determines the dialect.
        """
        self.tree = tree
        self.dialect = dialect or (ROS2 if is_ros2(tree.root) else ROS1)
        self._declared = self.dialect.declared(tree.root)

    @staticmethod
    def from_files(
        files: Path | Iterable[Path], arguments: Mapping[str, str] | None = None
    ) -> ControllerConfig:
        """Return the controllers of one or several files; later files take precedence.

        ``arguments`` are the values of ``$(var NAME)`` in files for ROS 2.

        Raises:
            ConfigError: If a file cannot be read, is not YAML, or contains an unknown
                variable.
        """
        tree = Tree()
        for path in [files] if isinstance(files, Path) else files:
            start = SourceLocation(path, 1)
            with preferring(packages_around(path)):
                text = substituted(text_of(path), arguments or {}, start)
            tree.load(text, start)
        return ControllerConfig(tree)

    @staticmethod
    def from_text(
        text: str, location: SourceLocation | None = None
    ) -> ControllerConfig:
        """Return the controllers of a YAML text that begins at ``location``."""
        tree = Tree()
        tree.load(text, location or SourceLocation(None, 1))
        return ControllerConfig(tree)

    def with_type(self, name: str, type_name: str) -> ControllerConfig:
        """Return a copy in which a new or existing controller has the given type."""
        config = ControllerConfig(self.tree, self.dialect)
        here = SourceLocation(None)
        empty = YamlEntry(name, here, {})
        parameters = self.dialect.parameters(self.tree.root, name) or empty
        config._declared = {
            **self._declared,
            name: Declared(YamlEntry(f"{name}.type", here, type_name), parameters),
        }
        return config

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the controllers, which are the namespaces with a ``type``."""
        return tuple(self._declared)

    @property
    def types(self) -> Mapping[str, str]:
        """The types of the controllers in the files; a type need not exist."""
        return {name: str(item.type.scalar) for name, item in self._declared.items()}

    @property
    def control_period(self) -> float | None:
        """The time between updates that the files specify [s]; None if unspecified.

        Raises:
            ConfigError: If the specified rate is invalid.
        """
        return self.dialect.control_period(self.tree.root)

    def parameters(self) -> Mapping[str, object]:
        """Return the entire content of the files, as plain values by name."""
        return {name: e.plain() for name, e in self.tree.root.children.items()}

    def yaml(self) -> str:
        """Return the entire content of the files as one YAML text, without comments."""
        import yaml

        text: str = yaml.safe_dump(
            dict(self.parameters()), sort_keys=False, allow_unicode=True
        )
        return text

    def type_of(self, name: str) -> str:
        """Return the type of a controller, after checking that the type exists.

        Raises:
            ConfigError: If the controller or its type is missing, or the type is
                unknown.
        """
        entry = self._find(name).type
        if not isinstance(entry.scalar, str):
            raise ConfigError(
                f"'{entry.key}' must be a text, got {entry.describe()}", entry.location
            )
        self.dialect.parser_of(entry.scalar, entry.location)
        return entry.scalar

    def _find(self, name: str) -> Declared:
        found = self._declared.get(name)
        if found is not None:
            return found
        entry = self.tree.root.children.get(name)
        if entry is None:
            raise ConfigError(
                f"unknown controller '{name}'{did_you_mean(name, self.names)}"
            )
        if not entry.is_mapping:
            raise ConfigError(
                f"'{name}' is no controller, but {entry.describe()}", entry.location
            )
        raise ConfigError(
            f"Could not load controller '{name}' because its type was not "
            f"specified; '{name}' needs a 'type'",
            entry.location,
        )

    def spec(self, name: str, robot: RobotJoints) -> ControllerSpec:
        """Return the checked parameters of a controller.

        Raises:
            ConfigError: If the controller is missing, or its parameters are invalid.
        """
        return self._parse(name, robot, Namespace(self._find(name).parameters))

    def _parse(
        self, name: str, robot: RobotJoints, parameters: Namespace
    ) -> ControllerSpec:
        kind = self.type_of(name)
        parse = self.dialect.parser_of(kind, self._find(name).type.location)
        return parse(name, kind, parameters, robot)

    def parameters_of(self, name: str, robot: RobotJoints) -> ControllerParameters:
        """Return the values of a controller's parameters, including defaults.

        If a parameter is invalid, the parameters that are read after it are missing
        from the result.

        Raises:
            ConfigError: If there is no such controller.
        """
        given = Namespace(self._find(name).parameters)
        with suppress(ConfigError):
            self._parse(name, robot, given)
        values: dict[str, Value | None] = {
            given.path_of(leaf.key): _value(leaf) for leaf in given.entry.leaves()
        }
        values |= given.read_values()
        return ControllerParameters(
            {
                _dotted(path): value
                for path, value in values.items()
                if value is not None
            },
            frozenset(
                _dotted(path) for path in given.adjustable_paths() & values.keys()
            ),
        )

    def with_parameters(
        self, name: str, changes: Mapping[str, Value]
    ) -> ControllerConfig:
        """Return a copy with changed parameters of one controller, by dotted name."""
        found = self._find(name)
        overlay = YamlEntry(name, found.parameters.location, {})
        for path, value in changes.items():
            place, here = overlay, SourceLocation(None)
            *outer, last = path.split(".")
            for part in outer:
                place = place.children.setdefault(
                    part, YamlEntry(f"{place.key}/{part}", here, {})
                )
            key = f"{place.key}/{last}"
            place.children[last] = YamlEntry(key, here, _as_entry(key, here, value))
        config = ControllerConfig(self.tree, self.dialect)
        config._declared = {
            **self._declared,
            name: Declared(found.type, merged(found.parameters, overlay)),
        }
        return config

    def lint(self, joints: Collection[str] | None = None) -> tuple[Finding, ...]:
        """Return findings about unused, ineffective and suspicious parameters.

        ``joints`` are the robot's movable joints; None if they are unknown.
        """
        return self.dialect.lint(self.tree, joints)

    def joint_limits(self) -> Mapping[str, Mapping[str, float]]:
        """Return the limits in ``joint_limits``, by joint.

        The limits in ``joint_limits`` override the limits of the URDF.  The keys are
        fields of ``JointLimits``.
        """
        limits = self.dialect.joint_limits(self.tree.root)
        entries = {} if limits is None else limits.entry.children
        return {
            name: read_joint_limits(Namespace(entry)) for name, entry in entries.items()
        }


def _dotted(path: str) -> str:
    return path.replace("/", ".")


def _value(entry: YamlEntry) -> Value | None:
    """Return a parameter as a plain value; None if it is empty or has mixed types."""
    if not entry.is_list:
        return entry.scalar
    items = [item.scalar for item in entry.items]
    if all(isinstance(item, str) for item in items):
        return tuple(map(str, items))
    numbers = [item for item in items if isinstance(item, int | float)]
    return tuple(map(float, numbers)) if len(numbers) == len(items) else None


def _as_entry(key: str, here: SourceLocation, value: Value) -> Scalar | list[YamlEntry]:
    if not isinstance(value, tuple | list):
        return value
    items: Iterable[Scalar] = value
    return [YamlEntry(f"{key}[{k}]", here, item) for k, item in enumerate(items)]
