"""The named poses of a robot: built-in ones, and those that a user saved to a file."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, final
from urllib.parse import quote

from tool0.description.catalogue import RobotDescription, named_poses
from tool0.errors import ConfigError, ControlError, SourceLocation, nearest_name
from tool0.user_data import data_folder, locked

if TYPE_CHECKING:
    import yaml

LONGEST_NAME = 60
"""Characters of a pose's name: what fits on a button."""
_HEADER = "# Poses saved with tool0: joint positions [rad | m].\n"

Positions = Mapping[str, float]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class NamedPose:
    name: str
    positions: Mapping[str, float]
    """Joint → [rad | m]; it may leave joints out."""
    saved: bool
    """Whether a person saved it."""


@final
class PoseBook:
    """A robot's poses.  Those that came with it cannot be changed."""

    def __init__(self, description: RobotDescription) -> None:
        self._saved = SavedPoses(poses_file(description.model.name))
        self.own: Mapping[str, NamedPose] = {
            name: NamedPose(name=name, positions=positions, saved=False)
            for name, positions in named_poses(description).items()
        }
        """Those that came with it."""

    def all(self) -> Mapping[str, NamedPose]:
        """Return every pose, those that came with the robot first.

        A saved one that is called like one of those, by an older release, is hidden.

        Raises:
            ConfigError: If the file of saved poses cannot be read.
        """
        saved = {
            name: NamedPose(name=name, positions=positions, saved=True)
            for name, positions in self._saved.read().items()
        }
        return {**self.own, **{k: v for k, v in saved.items() if k not in self.own}}

    def find(self, name: str) -> NamedPose:
        """Return one pose; the saved ones are not read for one of the robot's own.

        Raises:
            ControlError: If there is none of that name.
            ConfigError: If the file of saved poses cannot be read.
        """
        if name in self.own:
            return self.own[name]
        poses = self.all()
        if name not in poses:
            raise ControlError(f"unknown pose '{name}'{nearest_name(name, set(poses))}")
        return poses[name]

    def save(self, name: str, positions: Mapping[str, float]) -> None:
        """Keep a pose, in the place of a saved one that is called so.

        Raises:
            ControlError: If the name is one of the robot's own, or none for a pose.
            ConfigError: If the file of saved poses cannot be read or written.
        """
        self._refuse_own(name, "choose another name")
        is_sound = 1 <= len(name) <= LONGEST_NAME and name.isprintable()
        if not is_sound or name != name.strip():
            raise ControlError(
                f"a pose cannot be called {name!r}; give 1 to {LONGEST_NAME} printable "
                "characters, with no space at either end"
            )
        self._saved.save(name, positions)

    def delete(self, name: str) -> None:
        """Forget a saved pose.

        Raises:
            ControlError: If there is none of that name, or it is the robot's own.
            ConfigError: If the file of saved poses cannot be read or written.
        """
        self._refuse_own(name, "only saved poses can be deleted")
        self.find(name)
        self._saved.delete(name)

    def _refuse_own(self, name: str, remedy: str) -> None:
        if name in self.own:
            raise ControlError(f"pose '{name}' came with the robot; {remedy}")


def poses_file(robot: str) -> Path:
    """Return where the poses of a robot of that name are kept."""
    return data_folder() / "poses" / f"{quote(robot, safe=' ')}.yaml"


@final
class SavedPoses:
    """The poses in one file; several processes may change them at once.

    A change is written to a new file that takes the old one's place, under a lock, so
    that no pose is lost and no reader sees half a file.  A file that cannot be
    understood is never replaced.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self._version: tuple[int, int, int] | None = None
        self._poses: Mapping[str, Positions] = {}

    def read(self) -> Mapping[str, Positions]:
        """Return the positions [rad | m] by joint, by pose, as last saved.

        Raises:
            ConfigError: If the file cannot be read or understood.
        """
        try:
            status = self.file.stat()
            version = (status.st_mtime_ns, status.st_size, status.st_ino)
            if version != self._version:
                self._poses = _parse(self.file.read_bytes(), self.file)
                self._version = version
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise self._failure("read", error) from None
        return self._poses

    def save(self, name: str, positions: Positions) -> None:
        """Add a pose, or put it in the place of the one called so.

        Raises:
            ConfigError: If the file cannot be read, understood or written.
        """
        with self._changing() as poses:
            poses[name] = dict(positions)

    def delete(self, name: str) -> None:
        """Remove a pose; one that is not there is gone already.

        Raises:
            ConfigError: If the file cannot be read, understood or written.
        """
        with self._changing() as poses:
            poses.pop(name, None)

    @contextmanager
    def _changing(self) -> Iterator[dict[str, Positions]]:
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with locked(self.file.with_suffix(".lock")):
                poses = dict(self.read())
                yield poses
                _replace(self.file, poses)
        except OSError as error:
            raise self._failure("write", error) from None

    def _failure(self, verb: str, error: OSError) -> ConfigError:
        return ConfigError(
            f"cannot {verb} the saved poses: {error.strerror}",
            SourceLocation(self.file),
        )


def _replace(file: Path, poses: Mapping[str, Positions]) -> None:
    import yaml

    plain = {name: dict(positions) for name, positions in poses.items()}
    text = _HEADER + yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
    descriptor, name = tempfile.mkstemp(dir=file.parent, prefix=".new-")
    new = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as handle:
            handle.write(text.encode())
            handle.flush()
            os.fsync(handle.fileno())
        new.replace(file)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def _parse(text: bytes, file: Path) -> dict[str, Positions]:
    """Return the poses of a file that a person may have edited, or raise ConfigError.

    Names are taken as written: a pose may be called ``on`` or ``1``.
    """
    import yaml

    try:
        node = yaml.compose(text.decode(), Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        line = None if error.problem_mark is None else error.problem_mark.line + 1
        raise ConfigError(
            f"not YAML: {error.problem or error}", SourceLocation(file, line)
        ) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(f"not YAML: {error}", SourceLocation(file)) from None
    if node is None:
        return {}
    return {
        name: {
            joint: _number(value, f"joint '{joint}' of pose '{name}'", file)
            for joint, value in _pairs(pose, f"pose '{name}'", file)
        }
        for name, pose in _pairs(node, "the file", file)
    }


def _pairs(node: yaml.Node, what: str, file: Path) -> Iterator[tuple[str, yaml.Node]]:
    import yaml

    if not isinstance(node, yaml.MappingNode):
        raise ConfigError(f"{what} must be a mapping", _where(node, file))
    seen: set[str] = set()
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode) or not key.value:
            raise ConfigError(f"{what} has a key that is no name", _where(key, file))
        if key.value in seen:
            raise ConfigError(
                f"{what} has '{key.value}' twice; remove one", _where(key, file)
            )
        seen.add(key.value)
        yield key.value, value


def _number(node: yaml.Node, what: str, file: Path) -> float:
    try:
        number = float(str(node.value))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ConfigError(
            f"{what} must be a finite number, got {node.value!r}", _where(node, file)
        )
    return number


def _where(node: yaml.Node, file: Path) -> SourceLocation:
    return SourceLocation(file, node.start_mark.line + 1)
