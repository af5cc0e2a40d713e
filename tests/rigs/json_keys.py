"""Compares a JSON value with the type that documents its keys."""

from __future__ import annotations

from typing import Any

from tools.cli_json import element_of, entry_of, has_keys, keys_of, options


def wrong_keys(value: Any, kind: Any, path: str = "") -> list[str]:
    """Return the paths of keys that are missing or not documented."""
    found = [_wrong(value, option, path) for option in options(kind)]
    return min(found, key=len)


def _wrong(value: Any, kind: Any, path: str) -> list[str]:
    if kind is Any or value is None:
        return []
    if not isinstance(value, dict | list):
        is_inner = has_keys(kind) or element_of(kind) or entry_of(kind)
        return [path] if is_inner else []
    wrong: list[str] = []
    if isinstance(value, list):
        if (element := element_of(kind)) is None:
            return [path]
        for item in value:
            wrong += wrong_keys(item, element, f"{path}[]")
        return wrong
    if (entry := entry_of(kind)) is not None:
        for item in value.values():
            wrong += wrong_keys(item, entry[1], f"{path}.{entry[0]}")
        return wrong
    if not has_keys(kind):
        return [path]
    keys = keys_of(kind)
    required = {name for name, key in keys.items() if key.is_required}
    wrong += [f"{path}.{name}" for name in value.keys() - keys.keys()]
    wrong += [f"{path}.{name}" for name in required - value.keys()]
    for name in value.keys() & keys.keys():
        wrong += wrong_keys(value[name], keys[name].kind, f"{path}.{name}")
    return wrong
