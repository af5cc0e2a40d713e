"""MP4 files, read back by the library that wrote them."""

from __future__ import annotations

import resource
import signal
import sys
from pathlib import Path

import av
import numpy as np
import pytest

from tool0.errors import ConfigError, RenderError
from tool0.recording.video_writer import VideoWriter, require_encoder

WIDTH, HEIGHT, FPS = 64, 48, 25.0
COLORS = ((200, 30, 30), (30, 160, 60), (40, 60, 190))


def plain(color: tuple[int, int, int]) -> np.ndarray:
    return np.full((HEIGHT, WIDTH, 3), color, np.uint8)


def read(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert float(stream.average_rate) == pytest.approx(FPS)
        frames = [
            frame.to_ndarray(format="rgb24") for frame in container.decode(stream)
        ]
        assert container.duration / av.time_base == pytest.approx(
            len(frames) / FPS, abs=0.5 / FPS
        )
    return frames


def test_what_is_read_back_is_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    with VideoWriter(path, WIDTH, HEIGHT, FPS) as video:
        for color in COLORS:
            for _ in range(10):
                video.write(plain(color))
    frames = read(path)
    assert len(frames) == 30
    assert frames[0].shape == (HEIGHT, WIDTH, 3)
    for number, color in enumerate(COLORS):
        middle = frames[10 * number + 5].mean(axis=(0, 1))
        assert middle == pytest.approx(color, abs=12.0)


def test_its_index_comes_first_so_that_a_browser_can_begin(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    with VideoWriter(path, WIDTH, HEIGHT, FPS) as video:
        video.write(plain(COLORS[0]))
    content = path.read_bytes()
    assert 0 < content.index(b"moov") < content.index(b"mdat")


def test_what_was_written_before_an_error_is_a_whole_video(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    video = VideoWriter(path, WIDTH, HEIGHT, FPS)

    def fail_halfway() -> None:
        with video:
            for _ in range(5):
                video.write(plain(COLORS[1]))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_halfway()
    assert len(read(path)) == 5
    with pytest.raises(RenderError):
        video.write(plain(COLORS[0]))
    video.close()


def test_a_video_without_pictures_is_closed_quietly(tmp_path: Path) -> None:
    VideoWriter(tmp_path / "a.mp4", WIDTH, HEIGHT, FPS).close()


@pytest.mark.parametrize("size", [(63, 48), (64, 47), (0, 48)])
def test_sizes_that_no_player_shows_are_refused(
    size: tuple[int, int], tmp_path: Path
) -> None:
    with pytest.raises(ConfigError) as caught:
        VideoWriter(tmp_path / "a.mp4", *size)
    assert f"{size[0]} x {size[1]}" in str(caught.value)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), 2000.0])
def test_impossible_rates_are_refused(fps: float, tmp_path: Path) -> None:
    with pytest.raises(ConfigError):
        VideoWriter(tmp_path / "a.mp4", WIDTH, HEIGHT, fps)


def test_pictures_of_another_shape_are_refused(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", WIDTH, HEIGHT, FPS) as video:
        with pytest.raises(ConfigError):
            video.write(plain(COLORS[0])[:-2])
        with pytest.raises(ConfigError):
            video.write(plain(COLORS[0]).astype(float))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["absent/a.mp4", "."])
def test_a_place_that_cannot_be_written_is_told_at_once(
    name: str, tmp_path: Path
) -> None:
    path = tmp_path / name
    with pytest.raises(ConfigError):
        require_encoder(path)
    with pytest.raises(ConfigError):
        VideoWriter(path, WIDTH, HEIGHT)


def test_to_ask_beforehand_leaves_no_file(tmp_path: Path) -> None:
    require_encoder(tmp_path / "a.mp4")
    assert not any(tmp_path.iterdir())


def test_without_pyav_it_is_told_what_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av.codec", None)
    with pytest.raises(RenderError) as caught:
        require_encoder(tmp_path / "a.mp4")
    assert "'.[video]'" in str(caught.value)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("n_pictures", [2, 100])  # the end does not fit, or the middle
def test_a_full_disk_is_told_whenever_it_is_full(
    n_pictures: int, tmp_path: Path
) -> None:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        with pytest.raises(RenderError):
            write_noise(tmp_path / "a.mp4", n_pictures)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)


def write_noise(path: Path, n_pictures: int) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (240, 320, 3), dtype=np.uint8)
    with VideoWriter(path, 320, 240) as video:
        for _ in range(n_pictures):
            video.write(noise)
