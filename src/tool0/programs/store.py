"""The programs that a user has saved for a robot, with one file for each program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, final
from urllib.parse import quote, unquote

from msgspec.structs import replace

from tool0.errors import ConfigError, ControlError, SourceLocation, did_you_mean
from tool0.programs.files import parse_program, program_text, read_program
from tool0.protocol.program import Program, walk
from tool0.protocol.programs import SavedProgram
from tool0.user_data import data_folder, replace_text

LONGEST_NAME: Final = 60
"""Maximum number of characters in a program's name."""
_SUFFIX: Final = ".yaml"
_RESERVED: Final = '%/\\<>:"|?*'
"""Characters that some file systems reject, and the escape character of file names."""
_LONGEST_FILE: Final = 240
"""Maximum number of bytes in a file's name: 255, minus the length of the suffix that is
used during writing."""


@final
class ProgramStore:
    """The saved programs of one robot, identified by the robot's name.

    A change is written to a new file that replaces the old file, so that no process
    reads an incomplete file.
    """

    def __init__(self, robot: str) -> None:
        self._robot = robot

    @property
    def folder(self) -> Path:
        """Folder of the programs' files; the folder may not exist yet."""
        return data_folder() / "programs" / quote(self._robot, safe=" ")

    def all(self) -> tuple[SavedProgram, ...]:
        """Return all saved programs, sorted by name, including unreadable ones.

        Raises:
            ConfigError: If the folder cannot be read.
        """
        with self._explained("read"):
            files = sorted(self.folder.glob(f"*{_SUFFIX}"))
        return tuple(_info(file) for file in files)

    def read(self, name: str) -> Program:
        """Return a saved program.

        Raises:
            ControlError: If there is no program with this name.
            ConfigError: If the program's file cannot be read or is not a program.
        """
        found = read_program(self._existing(name)).program
        return replace(found, name=name)  # a user may have renamed the file

    def save(self, program: Program, *, overwrite: bool) -> None:
        """Save a program under its name.

        Raises:
            ControlError: If the name is not printable, or if a program with this name
                exists and ``overwrite`` is false.
            ConfigError: If the file cannot be written.
        """
        name = program.name
        sound = 1 <= len(name) <= LONGEST_NAME and name.isprintable()
        if not sound or name != name.strip():
            raise ControlError(
                f"a saved program cannot be called {name!r}; give 1 to {LONGEST_NAME} "
                "printable characters, with no space at either end"
            )
        file = self._file(name)
        if not overwrite and file.exists():
            raise ControlError(f"a program '{name}' is saved already")
        text = program_text(program)
        parse_program(text)  # check that the written text can be read
        with self._explained("write"):
            self.folder.mkdir(parents=True, exist_ok=True)
            replace_text(file, text)

    def rename(self, name: str, new_name: str) -> None:
        """Rename a saved program.

        Raises:
            ControlError: If there is no program with the old name, or if there is a
                program with the new name.
            ConfigError: If a file cannot be read or written.
        """
        program = self.read(name)
        if new_name == name:
            return
        self.save(replace(program, name=new_name), overwrite=False)
        self.delete(name)

    def delete(self, name: str) -> None:
        """Delete a saved program.

        Raises:
            ControlError: If there is no program with this name.
            ConfigError: If the program's file cannot be deleted.
        """
        file = self._existing(name)
        with self._explained("delete"):
            file.unlink(missing_ok=True)

    def _file(self, name: str) -> Path:
        file = "".join(map(_quoted, name)) + _SUFFIX
        if len(file.encode()) > _LONGEST_FILE:
            raise ControlError(f"the name '{name}' is too long for a file")
        return self.folder / file

    def _existing(self, name: str) -> Path:
        file = self._file(name)
        if not file.exists():
            names = [item.name for item in self.all()]
            raise ControlError(
                f"no program '{name}' is saved{did_you_mean(name, names)}"
            )
        return file

    @contextmanager
    def _explained(self, verb: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            where = SourceLocation(Path(error.filename or self.folder))
            raise ConfigError(
                f"cannot {verb} the saved programs: {error.strerror}", where
            ) from None


def _info(file: Path) -> SavedProgram:
    name = unquote(file.name.removesuffix(_SUFFIX))
    try:
        program = read_program(file).program
    except ConfigError as error:
        return SavedProgram(name=name, n_steps=0, error=str(error))
    return SavedProgram(name=name, n_steps=len(list(walk(program.steps))))


def _quoted(character: str) -> str:
    """Return a character of a program's name as it is written in the file's name."""
    if character.isprintable() and character not in _RESERVED:
        return character
    return quote(character, safe="", errors="replace")
