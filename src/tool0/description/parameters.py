"""Parameters in YAML, as expressions in xacro read them: ``limits.elbow.upper``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, final

from tool0.description.yaml_tree import Constructor, YamlEntry, read_with_units
from tool0.errors import ConfigError, DescriptionError, SourceLocation, did_you_mean


@final
class Parameters(dict[str, Any]):
    """A mapping of YAML whose keys are attributes, too.

    A key that is missing is an AttributeError with file, line and the nearest key.
    """

    _place = ""  # in the class, so that no key of YAML is hidden by an attribute

    def __getattr__(self, key: str) -> Any:
        try:
            return dict.__getitem__(self, str(key))
        except KeyError:
            hint = did_you_mean(str(key), self)
            raise AttributeError(f"{self._place} has no key '{key}'{hint}") from None

    __getitem__ = __getattr__


def load_parameters(path: Path, units: Mapping[str, Constructor]) -> Any:
    """Return what the YAML file ``path`` holds, its mappings as ``Parameters``.

    Args:
        path: The file.
        units: Constructors of tagged scalars by tag, such as ``!degrees``.

    Raises:
        DescriptionError: If it cannot be read, is empty, or is not YAML.
    """
    if not path.is_file():
        raise DescriptionError(
            f"cannot read the parameters '{path}': there is no such file"
        )
    try:
        entry = read_with_units(path, units)
    except ConfigError as error:
        raise DescriptionError(error.message, error.location) from None
    if entry is None:
        raise DescriptionError("holds no parameters", SourceLocation(path))
    return _wrapped(entry)


def _wrapped(entry: YamlEntry) -> Any:
    if entry.is_list:
        return [_wrapped(item) for item in entry.items]
    if not entry.is_mapping:
        return entry.scalar
    wrapped = Parameters({key: _wrapped(c) for key, c in entry.children.items()})
    name = entry.key.replace("/", ".")
    wrapped._place = f"'{name}' in {entry.location}" if name else str(entry.location)
    return wrapped
