"""A recording as a video, read back by the library that wrote it."""

from pathlib import Path

import av
import numpy as np
import pytest
from recorded_session import record_session

from tool0.description.camera import Camera, looking
from tool0.errors import ConfigError, RecordingError, RenderError
from tool0.recording.reading import RecordingFile, open_recording
from tool0.recording.video import write_video
from tool0.sensing.cameras import Cameras

SIZE = {"width": 160, "height": 120}
EYE = Camera(name="eye", pose=looking((1.5, -1.0, 0.8), (0.3, 0.0, 0.3)))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> RecordingFile:
    file: Path = tmp_path_factory.mktemp("recording") / "session.mcap"
    record_session(file)
    return open_recording(file)


def images(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


@pytest.mark.slow
def test_each_image_shows_the_robot_as_it_was(
    recording: RecordingFile, tmp_path: Path
) -> None:
    shares: list[float] = []
    path = tmp_path / "session.mp4"
    n_images = write_video(
        recording, path, EYE, fps=4.0, when_written=shares.append, **SIZE
    )
    found = images(path)
    assert len(found) == n_images == int(recording.duration * 4.0 + 1e-9) + 1
    assert shares[-1] == 1.0
    cameras = Cameras(
        recording.description.model,
        {},
        recording.simulation.ground,
        lambda: recording.snapshots()[0],
    )
    sized = Camera(name="eye", pose=EYE.pose, **SIZE)
    rendered = {
        index: cameras.render(sized, recording.snapshots()[index]).rgb.astype(int)
        for index in (0, len(recording) - 1)
    }
    cameras.close()
    first, last = rendered.values()
    # the codec loses a little; another pose of the robot would differ by far more
    assert abs(found[0] - first).mean() < 0.3 * abs(last - first).mean()
    assert abs(found[-1] - last).mean() < 0.3 * abs(last - first).mean()


def test_speed_and_range_give_the_number_of_images(
    recording: RecordingFile, tmp_path: Path
) -> None:
    path = tmp_path / "part.mp4"
    n_images = write_video(
        recording, path, fps=5.0, speed=2.0, start=0.5, end=1.7, **SIZE
    )
    assert n_images == len(images(path)) == 4


def test_an_empty_range_an_unknown_camera_and_no_speed_are_refused(
    recording: RecordingFile, tmp_path: Path
) -> None:
    path = tmp_path / "none.mp4"
    with pytest.raises(RecordingError, match="it lasts from"):
        write_video(recording, path, start=1000.0)
    with pytest.raises(RenderError, match="no camera"):
        write_video(recording, path, "sceen")
    with pytest.raises(ConfigError, match="speed"):
        write_video(recording, path, speed=0.0)
    assert not path.exists()
