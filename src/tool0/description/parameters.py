"""Parameters in YAML, as expressions in xacro read them: ``limits.elbow.upper``."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, final

from tool0.errors import DescriptionError, SourceLocation, did_you_mean

Constructor = Callable[[Any, Any], Any]


@final
class Parameters(dict[str, Any]):
    """A mapping of YAML whose keys are attributes, too.

    A key that is missing is an AttributeError with the file and the nearest key.
    """

    _place = ""  # in the class, so that no key of YAML is hidden by an attribute

    def __getattr__(self, key: str) -> Any:
        try:
            return dict.__getitem__(self, key)
        except KeyError:
            hint = did_you_mean(str(key), [str(name) for name in self])
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
    import yaml

    try:
        with path.open(encoding="utf-8") as stream:
            data = yaml.load(stream, _loader(tuple(units.items())))
    except OSError as error:
        raise DescriptionError(
            f"cannot read the parameters '{path}': {error.strerror}; check the path"
        ) from error
    except (yaml.YAMLError, UnicodeError) as error:
        mark = getattr(error, "problem_mark", None)
        line = None if mark is None else mark.line + 1
        problem = getattr(error, "problem", None) or error
        raise DescriptionError(
            f"not valid YAML: {problem}", SourceLocation(path, line)
        ) from error
    if data is None:
        raise DescriptionError("holds no parameters", SourceLocation(path))
    return _wrap(data, str(path), "")


@functools.cache
def _loader(units: tuple[tuple[str, Constructor], ...]) -> Any:  # made at run time
    """Return a safe YAML loader, in C where there is one, that knows ``units``."""
    import yaml

    base = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    loader: Any = type("Loader", (base,), {})
    for tag, constructor in units:
        loader.add_constructor(tag, constructor)
    return loader


def _wrap(data: Any, file: str, keys: str) -> Any:
    if isinstance(data, dict):
        below = f"{keys}." if keys else ""
        wrapped = Parameters(
            {key: _wrap(value, file, f"{below}{key}") for key, value in data.items()}
        )
        wrapped._place = f"'{keys}' in {file}" if keys else file
        return wrapped
    if isinstance(data, list):
        return [_wrap(item, file, f"{keys}[{i}]") for i, item in enumerate(data)]
    return data
