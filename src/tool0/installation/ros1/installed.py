"""Whether an installed package has the messages and fields that we use."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from tool0.errors import RosUnavailableError
from tool0.installation.ros1.generation import SECTIONS, definition_files

_PARTS = {
    ".msg": ("",),
    ".srv": ("Request", "Response"),
    ".action": ("Goal", "Result", "Feedback"),
}
"""What the names of the classes end in that a file's sections become."""
_FIELD = re.compile(r"^\S+ (\w+)$", re.MULTILINE)
"""A line of our definitions that is no constant."""


def check_installed(package: str) -> None:
    """Make sure that the package is ROS 1's, and has every type and field of ours.

    Raises:
        RosUnavailableError: If it is not, or has not.
    """
    for file in definition_files(package):
        module = f"{package}.{'srv' if file.suffix == '.srv' else 'msg'}"
        for name, fields in _classes(file):
            found = _slots(module, name)
            if missing := [field for field in fields if field not in found]:
                raise _unfit(module, f"{name} has no field {missing[0]}")


def _classes(file: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the name and the fields of each class that the file defines."""
    sections = SECTIONS.split(file.read_text(encoding="utf-8"))
    for part, text in zip(_PARTS[file.suffix], sections, strict=True):
        yield f"{file.stem}{part}", _FIELD.findall(text)


def _slots(module: str, name: str) -> list[str]:
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError):
        raise _unfit(module, f"{name} is not in it") from None
    if not hasattr(found, "_md5sum"):
        raise _unfit(module, f"{name} is not of ROS 1")
    slots: list[str] = found.__slots__
    return slots


def _unfit(module: str, why: str) -> RosUnavailableError:
    package = module.partition(".")[0]
    where = getattr(import_module(package), "__file__", None)
    return RosUnavailableError(
        f"the installed {package} does not fit, {why} ({where}); install Noetic's, or "
        "take that folder off PYTHONPATH, and tool0 makes its own"
    )
