"""Requests about demonstrations: a folder with one recording for each episode."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

from tool0.protocol.request import Request

Outcome = Literal["success", "failure"]

EpisodeEnd = Literal[Outcome, "discard"]

FolderName = Annotated[str, Meta(min_length=1, max_length=4000)]


class EpisodesStatus(Struct, frozen=True, kw_only=True):
    """State of a folder of episodes, and of the episode that is being recorded."""

    folder: str
    """Path of the folder on the simulation's machine."""
    task: str
    """Description of the task."""
    is_recording: bool
    """Whether an episode is being recorded."""
    duration: float
    """Simulated duration of the episode that is being recorded [s]; 0 if there is no
    such episode."""
    episodes: int
    """Number of episodes in the folder."""
    succeeded: int
    """Number of episodes with the outcome ``success``."""
    error: str | None = None
    """Error that ended an episode early, such as a full disk; null if there is no
    error."""


class OpenEpisodes(Request[EpisodesStatus], frozen=True):
    """Select the folder for episodes; it can already contain some.

    While a folder is open, you can start and end episodes with keys in the panel.
    """

    written_paths = ("folder",)

    folder: FolderName
    task: Annotated[str, Meta(max_length=500)] = ""
    """Description of the task, which is written to each line of the index."""
    reset: bool = True
    """Whether each episode starts with a reset of the robot and the objects."""


class CloseEpisodes(Request[None], frozen=True):
    """Close the folder; an episode that is being recorded is discarded."""


class StartEpisode(Request[EpisodesStatus], frozen=True):
    """Start recording an episode."""


class EndEpisode(Request[EpisodesStatus], frozen=True):
    """End the episode, and keep it with its outcome or discard it."""

    outcome: EpisodeEnd


class ReadEpisodes(Request[EpisodesStatus | None], frozen=True):
    """Read the state of the folder of episodes; null if no folder is open."""
