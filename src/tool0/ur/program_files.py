"""The files of the dashboard server in one folder: the programs and the saved log."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final, final

from tool0.ur.client_interface.scripts import MAX_PROGRAM
from tool0.ur.external_control import is_external

LOG: Final = "log_history.txt"
SUFFIX: Final = ".script"
"""Suffix of URScript programs; PolyScope's ``.urp`` files are not read."""
ROOTS: Final = ("/programs", "/ursim/programs")
"""Program folders of a UR and of UR's simulator. In tool0, both program folders refer
to the dashboard server's folder."""


@final
@dataclass(frozen=True, slots=True)
class ProgramFile:
    """A program that the dashboard server has loaded."""

    name: str
    """Name that the client specified, without folders."""
    text: str | None
    """Text of the program; None for External Control, which requests the text from UR's
    driver."""


@final
class ProgramFiles:
    """Reads programs and saves the log in one folder; accesses no other folders."""

    def __init__(self, folder: Path | None) -> None:
        """Use ``folder``; if it is None, there are no programs."""
        self._folder = None if folder is None else folder.resolve()

    def read(self, name: str) -> ProgramFile | None:
        """Return a program, or None if there is no program with this name.

        ``pick.urp`` refers to the file ``pick.script``, because PolyScope keeps the
        name of a program when it exports the program. ``external_control.urp`` needs no
        file.
        """
        path = self._find(name)
        if path is None and is_external(name):
            return ProgramFile(PurePosixPath(name).name, None)
        if path is None:
            return None
        try:
            with path.open(encoding="utf-8") as file:
                text = file.read(MAX_PROGRAM + 1)
        except (OSError, ValueError):
            return None
        if len(text) > MAX_PROGRAM:
            return None
        return ProgramFile(PurePosixPath(name).name, text)

    def save_log(self, lines: Iterable[str]) -> None:
        """Write the log and replace the previous log.

        Raises:
            OSError: If the log cannot be written.
        """
        if self._folder is None:
            raise FileNotFoundError("there is no folder for it")
        self._folder.mkdir(parents=True, exist_ok=True)
        text = "".join(f"{line}\n" for line in lines)
        (self._folder / LOG).write_bytes(text.encode(errors="replace"))

    def _find(self, name: str) -> Path | None:
        if self._folder is None or not name or "\0" in name:
            return None
        relative = PurePosixPath(name)
        for root in ROOTS:
            if relative.is_relative_to(root):
                relative = relative.relative_to(root)
        if relative.is_absolute() or relative.suffix not in {SUFFIX, ".urp", ""}:
            return None
        try:
            path = (self._folder / relative).with_suffix(SUFFIX).resolve()
            is_ours = path.is_relative_to(self._folder) and path.is_file()
        except (OSError, ValueError):  # the name is too long or empty
            return None
        return path if is_ours else None
