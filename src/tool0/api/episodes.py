"""Demonstrations: episodes that are recorded into a folder."""

from __future__ import annotations

from pathlib import Path
from typing import final

from tool0.protocol.channel import Channel
from tool0.protocol.episodes import (
    CloseEpisodes,
    EndEpisode,
    EpisodeEnd,
    EpisodesStatus,
    OpenEpisodes,
    ReadEpisodes,
    StartEpisode,
)
from tool0.protocol.request import checked_path


@final
class EpisodesHandle:
    """Starts and ends episodes, as the panel does (docs/how-to/recordings.md)."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel

    @property
    def status(self) -> EpisodesStatus | None:
        """State of the folder and its episodes; None if no folder is open."""
        return self._channel.call(ReadEpisodes())

    def open(
        self, folder: Path | str, *, task: str = "", reset: bool = True
    ) -> EpisodesStatus:
        """Open a folder on the simulation's machine; it can already contain episodes.

        Args:
            folder: Folder to which the recordings and their index are written.
            task: Description of the task, which is written to each line of the index.
            reset: Whether each episode starts with a reset of the robot and the
                objects.

        Raises:
            RecordingError: If the folder cannot be used.
        """
        path = checked_path("open_episodes", "folder", folder)
        return self._channel.call(
            OpenEpisodes(folder=str(path), task=task, reset=reset)
        )

    def start(self) -> EpisodesStatus:
        """Start recording an episode.

        Raises:
            ControlError: If no folder is open, or if an episode is already being
                recorded.
        """
        return self._channel.call(StartEpisode())

    def end(self, outcome: EpisodeEnd) -> EpisodesStatus:
        """End the episode, and keep it with its outcome or discard it.

        Raises:
            ControlError: If no episode is being recorded.
        """
        return self._channel.call(EndEpisode(outcome=outcome))

    def close(self) -> None:
        """Close the folder; an episode that is being recorded is discarded."""
        self._channel.call(CloseEpisodes())
