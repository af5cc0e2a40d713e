"""``tool0 camera`` and its methods, against a fake robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fake_robot import FakeCamera, FakeRobot
from tool0.interfaces.socket.client import RemoteRobot

from tool0.cli import FAILED, OK, main
from tool0.description.camera import Camera
from tool0.errors import RenderError
from tool0.interfaces.server.unix_socket import MAX_LINE
from tool0.sensing.cameras import encode_depth, encode_png


@pytest.fixture(autouse=True)
def robot(served_robot: FakeRobot) -> FakeRobot:
    return served_robot


def run(*words: str | Path) -> int:
    return main(["camera", *map(str, words)])


def test_it_lists_the_cameras(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--list") == OK
    assert capsys.readouterr().out == (
        "camera  link   pixels  field of view  sees\n"
        "eye     tool0  4 x 3   45°            0.01 … 10 m\n"
    )


def test_it_writes_colors_and_depth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, depth = tmp_path / "a.png", tmp_path / "d.png"
    assert run("eye", "--out", out, "--depth", depth) == OK
    assert capsys.readouterr().out == f"{out}, {depth}: 4 x 3, at t = 1.500 s\n"
    image = FakeCamera().image()
    assert out.read_bytes() == encode_png(image.rgb)
    assert depth.read_bytes() == encode_depth(image.depth)


def test_it_writes_depth_as_numpy_does(tmp_path: Path) -> None:
    path = tmp_path / "d.npy"
    assert run("eye", "--depth", path) == OK
    depth = np.load(path)
    assert depth.dtype == np.float32
    assert np.array_equal(depth, FakeCamera().image().depth)
    assert np.isinf(depth[0, 0])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "name a camera, or list them with --list"),
        (["eye", "--list"], "name a camera, or list them"),
        (["eye"], "--out FILE.png"),
        (["eye", "--out", "a.jpg"], "a.jpg: the name must end in .png"),
        (["eye", "--depth", "a.exr"], "a.exr: the name must end in .png or .npy"),
        (["eye", "--out", "absent/a.png"], "cannot write absent/a.png: No such file"),
        (["eya", "--out", "a.png"], "no camera 'eya'; did you mean 'eye'?"),
    ],
)
def test_what_is_wrong_is_told(
    words: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*words) == FAILED
    assert message in capsys.readouterr().err
    assert not (tmp_path / "a.png").exists()


def test_a_picture_comes_over_as_it_is() -> None:
    expected = FakeCamera().image()
    with RemoteRobot() as robot:
        assert robot.cameras() == {"eye": FakeCamera.camera}
        image = robot.camera("eye").image()
        with pytest.raises(RenderError, match="did you mean 'eye'"):
            robot.camera("ear").image()
    assert image.time == expected.time
    assert np.array_equal(image.rgb, expected.rgb)
    assert np.array_equal(image.depth, expected.depth)
    assert np.array_equal(image.K, expected.K)
    assert image.T_root_camera == expected.T_root_camera


def test_a_picture_may_be_longer_than_a_request(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    noise = np.random.default_rng(3)
    camera = Camera(name="eye", width=800, height=600)
    depth = noise.random((600, 800), np.float32)
    assert depth.nbytes > MAX_LINE
    monkeypatch.setattr(FakeCamera, "camera", camera)
    monkeypatch.setattr(FakeCamera, "depth", depth)
    monkeypatch.setattr(FakeCamera, "rgb", noise.integers(0, 255, (600, 800, 3), "u1"))
    with RemoteRobot() as robot:
        image = robot.camera("eye").image()
    assert np.array_equal(image.depth[1:], depth[1:])
