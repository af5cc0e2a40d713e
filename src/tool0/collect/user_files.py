"""User files that define policies and tasks: ``file.py:name``.

Workers run the file at its path and compare its SHA-256 with the digest that the driver
sends.
"""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path
from typing import Any

from tool0.errors import ConfigError


def is_file(name: str) -> bool:
    """Return whether a name refers to a function, class or task in a file."""
    return name.rpartition(":")[0].endswith(".py")


def located_file(name: str, what: str) -> tuple[str, str]:
    """Return the name with the absolute path, and the SHA-256 of the file.

    ``what`` is the kind of the object in messages: ``policy`` or ``task``.

    Raises:
        ConfigError: If the file cannot be read.
    """
    place, _, attribute = name.rpartition(":")
    name = f"{Path(place).absolute()}:{attribute}"
    return name, hashlib.sha256(_text(name, what)).hexdigest()


def run_file(name: str, digest: str, what: str) -> dict[str, Any]:
    """Run a file, and return the names that it defines.

    Raises:
        ConfigError: If the file cannot be read, or its digest differs from ``digest``.
        Exception: Any exception that the file raises.
    """
    text, place = _text(name, what), name.rpartition(":")[0]
    if hashlib.sha256(text).hexdigest() != digest:
        raise ConfigError(f"{what} '{name}' has changed, or differs between machines")
    if (folder := str(Path(place).parent)) not in sys.path:
        sys.path.append(folder)  # for modules in the folder of the file
    values = {"__name__": Path(place).stem, "__file__": place}
    exec(compile(text, place, "exec"), values)
    return values


def cannot_load(name: str, what: str, error: Exception) -> ConfigError:
    """Return the error for an exception that the user's code raised."""
    reason = f"{type(error).__name__}: {error}"
    return ConfigError(f"{what} '{name}' cannot be loaded: {reason}")


def _text(name: str, what: str) -> bytes:
    try:
        return Path(name.rpartition(":")[0]).read_bytes()
    except OSError as error:
        raise ConfigError(f"{what} '{name}' cannot be read: {error.strerror}") from None
