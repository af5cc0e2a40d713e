"""The named poses of a robot: those that came with it, and those a person saved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from tool0.description.catalogue import RobotDescription, named_poses
from tool0.errors import ControlError, did_you_mean
from tool0.runtime.saved_poses import LONGEST_NAME, SavedPoses, poses_file


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
            raise ControlError(f"unknown pose '{name}'{did_you_mean(name, set(poses))}")
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
