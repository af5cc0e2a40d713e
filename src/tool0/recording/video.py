"""Output of a recording as a video from any camera, at any size and speed."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tool0.errors import ConfigError, RecordingError
from tool0.recording.video_writer import VideoWriter
from tool0.sensing.cameras import Cameras

if TYPE_CHECKING:
    from tool0.description.camera import Camera
    from tool0.protocol.state import Snapshot
    from tool0.recording.reading import RecordingFile

MAX_SPEED: Final = 1000.0


def cameras_of(
    recording: RecordingFile, newest: Callable[[], Snapshot] | None = None
) -> Cameras:
    """Return the recorded robot's cameras, which render images of the snapshots.

    Args:
        recording: The recording.
        newest: Function that returns the snapshot to show if no snapshot is given
            (default: the last snapshot).
    """
    return Cameras(
        recording.description.model,
        {item.name: item for item in recording.bringup.cameras},
        recording.simulation.ground,
        newest or (lambda: recording.snapshots()[-1]),
    )


def write_video(
    recording: RecordingFile,
    path: Path,
    camera: Camera | str = "scene",
    *,
    width: int = 960,
    height: int = 720,
    fps: float = 30.0,
    speed: float = 1.0,
    start: float | None = None,
    end: float | None = None,
    when_written: Callable[[float], None] = lambda share: None,
) -> int:
    """Write a recording as an MP4 file, and return the number of images.

    Each image is rendered from the latest snapshot at the image's time, so the
    recording does not need to contain images.

    Args:
        recording: The recording.
        path: Path of the video file; an existing file is replaced.
        camera: A camera, or the name of a camera of the robot or the scene.
        width: Width of the video, which must be even [pixels].
        height: Height of the video, which must be even [pixels].
        fps: Number of images per second of the video [Hz].
        speed: Recorded seconds per second of the video.
        start: Simulated time of the first image [s] (default: the time of the first
            snapshot).
        end: Simulated time of the last image [s] (default: the time of the last
            snapshot).
        when_written: Callback that is called after each image with the completed
            fraction, up to 1.

    Raises:
        ConfigError: If a value is out of range, or the file cannot be written.
        RecordingError: If the recording has no snapshots in this range.
        RenderError: If OpenGL or an encoder is not available, or there is no such
            camera.
    """
    if not 0.0 < speed <= MAX_SPEED:
        raise ConfigError(f"speed must be above 0, up to {MAX_SPEED:g}, got {speed:g}")
    if len(recording) == 0:
        raise RecordingError(f"{recording.path} has no snapshots to show")
    times: list[float] = recording.time.tolist()
    first = times[0] if start is None else max(start, times[0])
    last = times[-1] if end is None else min(end, times[-1])
    if not first <= last:
        raise RecordingError(
            f"{recording.path} has nothing from {first:g} to {last:g} s; it lasts from "
            f"{times[0]:g} to {times[-1]:g} s"
        )
    n_images = int((last - first) / speed * fps + 1e-9) + 1
    snapshots, cameras = recording.snapshots(), cameras_of(recording)
    seen = cameras[camera] if isinstance(camera, str) else camera
    sized = replace(seen, width=width, height=height)
    try:
        with VideoWriter(path, width, height, fps) as video:
            for i in range(n_images):
                time = first + i * speed / fps
                index = max(0, bisect_right(times, time + 1e-9) - 1)
                video.write(cameras.render(sized, snapshots[index]).rgb)
                when_written((i + 1) / n_images)
    finally:
        cameras.close()
    return n_images
