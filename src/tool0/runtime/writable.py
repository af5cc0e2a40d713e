"""Whether a file can be written, before the work that is to go into it."""

from __future__ import annotations

from pathlib import Path

from tool0.errors import ConfigError


def require_writable(path: Path) -> None:
    """Raise ConfigError if there can be no such file; leave what is there."""
    is_new = not path.exists()
    try:
        with path.open("ab"):
            pass
        if is_new:
            path.unlink()
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from error
