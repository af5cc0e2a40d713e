"""Checks of the values in YAML parameter files.  Errors state the file and the line."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

from tool0.description.expansion import read_parameters
from tool0.description.yaml_tree import YamlEntry
from tool0.errors import DescriptionError, ModelError, did_you_mean, nearest_name

_SIZES: Mapping[str, tuple[str, ...]] = {
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
}
_SHAPES = ("mesh", "box", *_SIZES)


def check_files(
    files: Mapping[str, Path], checks: Mapping[str, Callable[[YamlEntry], None]]
) -> None:
    """Apply the check of each file; skip missing files and files without a check."""
    for name, check in checks.items():
        path = files.get(name)
        if path is not None and path.is_file():
            check(read_parameters(path))


def child_at(entry: YamlEntry, key: str, siblings: Collection[str] = ()) -> YamlEntry:
    """Return the entry at ``key``; hints in errors never suggest ``siblings``."""
    child = entry.find(key)
    if child is None:
        near = nearest_name(key, entry.children.keys() - set(siblings))
        hint = f"; did you mean '{near}'?" if near else ""
        name = f"'{_dotted(entry)}' has" if entry.key else "the file has"
        raise DescriptionError(f"{name} no key '{key}'{hint}", entry.location)
    return child


def mapping_at(entry: YamlEntry, key: str) -> YamlEntry:
    """Return the mapping at ``key``."""
    child = child_at(entry, key)
    if not child.is_mapping:
        raise wrong_value(child, "a mapping")
    return child


def allow_only(entry: YamlEntry, *valid: str) -> None:
    """Raise DescriptionError for a key that is not in ``valid``."""
    for key, child in entry.children.items():
        if key not in valid:
            raise DescriptionError(
                f"unknown key '{_dotted(child)}'{did_you_mean(key, valid)}",
                child.location,
            )


def numbers_at(
    entry: YamlEntry, keys: tuple[str, ...], *, others: bool = False
) -> dict[str, float]:
    """Return the numbers at ``keys``.

    Other keys are errors unless ``others`` is set.
    """
    if not others:
        allow_only(entry, *keys)
    return {key: number_of(child_at(entry, key, keys)) for key in keys}


def check_positive(entry: YamlEntry, keys: tuple[str, ...]) -> None:
    """Raise ModelError unless the numbers at ``keys`` are above zero."""
    for key, value in numbers_at(entry, keys, others=True).items():
        if not value > 0.0:
            raise impossible_value(entry.children[key], "above zero")


def vector_of(entry: YamlEntry, count: int) -> list[float]:
    """Return the numbers in a list of length ``count``."""
    if len(entry.items) != count:
        raise wrong_value(entry, f"a list of {count} numbers")
    return [number_of(item) for item in entry.items]


def number_of(entry: YamlEntry) -> float:
    """Return a finite number, even one that is text in YAML 1.1 (such as 2e-05)."""
    value = entry.scalar
    try:
        number = math.nan if value is None or value is True else float(value)
    except ValueError:
        raise wrong_value(entry, "a number") from None
    if value is False or not math.isfinite(number):
        raise wrong_value(entry, "a finite number")
    return number


def _dotted(entry: YamlEntry) -> str:
    return entry.key.replace("/", ".")


def wrong_value(entry: YamlEntry, wanted: str) -> DescriptionError:
    """Return the error for a value of the wrong type."""
    return DescriptionError(
        f"'{_dotted(entry)}' must be {wanted}, got {entry.describe()}", entry.location
    )


def impossible_value(entry: YamlEntry, wanted: str) -> ModelError:
    """Return the error for a physically impossible value."""
    return ModelError(
        f"'{_dotted(entry)}' must be {wanted}, got {entry.plain()}", entry.location
    )


def check_shape(item: YamlEntry, materials: YamlEntry | None) -> None:
    """Raise an error unless the entry is a valid shape.

    If ``materials`` is given, the shape is a visual and must have one of these
    materials.
    """
    kind = next(iter(item.children), "")
    if kind not in _SHAPES:
        raise DescriptionError(
            f"a shape begins with {', '.join(_SHAPES[:-1])} or {_SHAPES[-1]}, "
            f"got {kind or item.describe()!r}{did_you_mean(kind, _SHAPES)}",
            item.location,
        )
    allow_only(item, kind, "xyz", "rpy", "scale", "material")
    shape = item.children[kind]
    if kind == "box":
        size = child_at(shape, "size")
        if min(vector_of(size, 3)) <= 0.0:
            raise impossible_value(size, "sizes above zero")
    elif kind == "mesh":
        if not isinstance(shape.scalar, str):
            raise wrong_value(shape, "the path of a mesh")
    else:
        check_positive(mapping_at(item, kind), _SIZES[kind])
    for key in ("xyz", "rpy"):
        if (pose := item.find(key)) is not None:
            vector_of(pose, 3)
    if materials is not None:
        material = child_at(item, "material")
        if material.scalar not in materials.children:
            hint = did_you_mean(str(material.scalar), materials.children)
            raise DescriptionError(
                f"unknown material '{material.scalar}'{hint}", material.location
            )
