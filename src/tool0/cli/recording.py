"""Recordings: ``tool0 record``, ``tool0 log`` and ``tool0 export``."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal, final

from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.parameters import AsJson, Option
from tool0.cli.stop_signal import StopSignal
from tool0.cli.text import counted, print_json
from tool0.errors import ConfigError, RecordingError

if TYPE_CHECKING:
    from tool0.cli.outputs import LogOutput
    from tool0.protocol.recordings import RecordingStatus
    from tool0.recording.reading import RecordingFile

_PERIOD: Final = 0.25
"""Wall time between checks of the recording [s]."""
File = Annotated[Path, Option(is_positional=True, metavar="FILE")]


def record(
    file: Annotated[Path | None, Option(is_positional=True, metavar="FILE")] = None,
    *,
    episodes: Annotated[Path | None, Option(metavar="FOLDER")] = None,
    task: str = "",
    reset: bool = True,
    duration: float | None = None,
    overwrite: bool = False,
    max_size: Annotated[float | None, Option(metavar="MB")] = None,
    max_duration: float | None = None,
    max_files: int | None = None,
    cameras: Annotated[tuple[str, ...], Option(metavar="NAME ...")] = (),
    camera_rate: float = 5.0,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> int:
    """Record a running bringup to an MCAP file, until Ctrl-C.

    The bringup's process writes the file, which you can read while it is being written.
    With --episodes, keys in the terminal or in the panel start and end demonstrations.

    Args:
        file: The file to write, with the suffix .mcap, or a folder.  In a folder, the
            file name consists of the date and the time.
        episodes: Record demonstrations into this folder, with one file for each
            demonstration.
        task: Description of the task.
        reset: Reset the robot and the objects before each demonstration.
        duration: End after this simulated time [s].
        overwrite: Replace an existing file.
        max_size: Start a new file when the current file reaches this size [MB].
        max_duration: Start a new file after this simulated time [s].
        max_files: Number of files to keep; older files are deleted.
        cameras: Cameras whose images are recorded.
        camera_rate: Image rate of each camera in simulated time [Hz].
        as_json: Print one JSON object at the end; not available with --episodes.
    """
    if (file is None) == (episodes is None):
        raise ConfigError("record: give either a FILE.mcap or --episodes FOLDER")
    if episodes is not None:
        if as_json:
            raise ConfigError("--json needs a FILE.mcap")
        from tool0.cli.episodes import record_episodes

        return record_episodes(episodes, task, reset=reset, bringup=bringup)
    assert file is not None  # either a file or --episodes is given
    with bringup.connect() as robot, StopSignal() as stop:
        status = robot.start_recording(
            file.expanduser(),
            overwrite=overwrite,
            max_size=None if max_size is None else round(max_size * 1e6),
            max_duration=max_duration,
            max_files=max_files,
            cameras=cameras,
            camera_rate=camera_rate,
        )
        is_terminal = sys.stdout.isatty() and not as_json
        while status.is_recording and not stop.wait(_PERIOD):
            if duration is not None and status.duration >= duration:
                break
            if is_terminal:
                print(f"\r{_described(status)}  ", end="", flush=True)
            status = robot.recording or status
        status = robot.stop_recording()
    if is_terminal:
        print("\r", end="")
    if as_json:
        print_json(status)
    else:
        print(_described(status))
    if status.error is not None:
        raise RecordingError(f"the recording ended early: {status.error}")
    return 0


def _described(status: RecordingStatus) -> str:
    text = f"{status.file}: {status.duration:.1f} s, {status.size / 1e6:.1f} MB"
    if status.files > 1:
        text += f" in {status.files} files"
    if status.dropped:
        text += f", {counted(status.dropped, 'snapshot')} dropped"
    return text


def log(
    file: File,
    *,
    requests: bool = True,
    severity: Literal["info", "warning", "error"] = "info",
    as_json: AsJson = False,
) -> None:
    """Print the events in a recording: goals, requests, warnings and contacts.

    Args:
        file: A recording (MCAP file).
        requests: Also print the requests that changed the simulation.
        severity: Lowest severity to print.
        as_json: Print one JSON object.
    """
    from tool0.recording.reading import open_recording
    from tool0.recording.tables import log_entries, log_line

    recording = open_recording(file)
    found = log_entries(recording, severity=severity, requests=requests)
    if as_json:
        listed: LogOutput = {
            "duration": recording.duration,
            "is_complete": recording.is_complete,
            "entries": found,
        }
        print_json(listed)
    else:
        text = "\n".join(map(log_line, found))
        print(text or f"nothing to report in {recording.duration:.2f} s")
    if not recording.is_complete:
        print(
            f"tool0: warning: {file} was cut off after {recording.duration:.2f} s",
            file=sys.stderr,
        )


_FORMATS: Final[Mapping[str, Literal["parquet", "mp4"]]] = {
    "parquet": "parquet",
    "mp4": "mp4",
}
"""File suffix → output format; for other suffixes, the format is csv."""


_VIDEO_SIZE: Final = 960, 720
"""Default size of a video [pixels]."""


@final
@dataclass(frozen=True, kw_only=True)
class VideoOptions:
    """Options of a video."""

    camera: str = "scene"
    """Camera of the robot or the scene that records the video."""
    eye: Annotated[tuple[float, float, float] | None, Option(metavar="X Y Z")] = None
    """Viewpoint of the video in the robot's root frame [m], instead of --camera."""
    at: Annotated[tuple[float, float, float], Option(metavar="X Y Z")] = (0.0, 0.0, 0.3)
    """Point at the center of the image, in the robot's root frame [m]; the point is
    used only with --eye."""
    width: int | None = None
    """Width of the images [pixels].  The default is 960 or, for lerobot, the width of
    the camera's images."""
    height: int | None = None
    """Height of the images [pixels].  The default is 720 or, for lerobot, the height of
    the camera's images."""
    fps: float = 30.0
    """Frame rate of the video [Hz]."""
    speed: float = 1.0
    """Speed of the video: recorded seconds per second of the video."""
    start: float | None = None
    """Simulated time at which the video begins [s]."""
    end: float | None = None
    """Simulated time at which the video ends [s]."""

    def write(self, recording: RecordingFile, target: Path) -> None:
        """Write the video, and print the progress."""
        from tool0.description.camera import Camera, looking
        from tool0.recording.video import write_video

        is_terminal = sys.stdout.isatty()

        def show(share: float) -> None:
            if is_terminal:
                print(f"\r{target}: {100 * share:.0f} %", end="", flush=True)

        free = self.eye and Camera(name="eye", pose=looking(self.eye, self.at))
        n_images = write_video(
            recording,
            target,
            free or self.camera,
            width=self.width or _VIDEO_SIZE[0],
            height=self.height or _VIDEO_SIZE[1],
            fps=self.fps,
            speed=self.speed,
            start=self.start,
            end=self.end,
            when_written=show,
        )
        print(f"{chr(13) if is_terminal else ''}{target}: {counted(n_images, 'image')}")


def export(
    file: File,
    *,
    format: Literal["csv", "parquet", "mp4", "lerobot"] | None = None,  # the option
    output: Path | None = None,
    overwrite: bool = False,
    rate: float = 25.0,
    only_successes: bool = False,
    instruction: str | None = None,
    cameras: Annotated[tuple[str, ...], Option(metavar="NAME ...")] = (),
    video: VideoOptions = VideoOptions(),  # a frozen dataclass
) -> None:
    """Write a recording as a table, a video or a data set.

    A table contains the joints, objects, wrenches, grippers, flanges and TCPs, with one
    row for each snapshot, in SI units (docs/how-to/recordings.md).  A video shows the
    recorded motion from a camera.  A folder of demonstrations is converted to a LeRobot
    data set.

    Args:
        file: A recording; for lerobot, a folder of demonstrations.
        format: Format of the output.  By default, the suffix of --output determines the
            format; for an unknown suffix, the format is csv.
        output: File or folder to write; by default, it is in the same folder as the
            recording.
        overwrite: Replace an existing file.
        rate: Frame rate of a LeRobot data set in simulated time [Hz].
        only_successes: Leave out failed demonstrations.
        instruction: Description of the task, for a LeRobot data set; the default is the
            recorded description.
        cameras: Cameras whose images are included in each frame of a LeRobot data set.
    """
    if format == "lerobot":
        from tool0.collect.demonstrations import export_lerobot

        folder = output or file.with_name(f"{file.name}_lerobot")
        found = export_lerobot(
            file,
            folder,
            rate=rate,
            only_successes=only_successes,
            instruction=instruction,
            cameras=cameras,
            width=video.width,
            height=video.height,
        )
        episodes = counted(found.n_episodes, "episode")
        print(f"{folder}: {episodes}, {counted(found.n_frames, 'frame')}")
        return
    from tool0.recording.reading import open_recording
    from tool0.recording.tables import write_csv, write_parquet

    if format is None:
        suffix = "" if output is None else output.suffix.removeprefix(".")
        format = _FORMATS.get(suffix, "csv")
    target = output or file.with_suffix(f".{format}")
    if target.exists() and not overwrite:
        raise ConfigError(f"{target} exists already; choose another, or --overwrite")
    recording = open_recording(file)
    if format == "mp4":
        video.write(recording, target)
        return
    write = write_csv if format == "csv" else write_parquet
    write(recording, target)
    print(f"{target}: {counted(len(recording), 'row')}")
