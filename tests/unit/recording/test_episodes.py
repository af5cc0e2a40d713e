"""Episodes of demonstrations: kept with their outcome, or discarded."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from promised import require_gl

import tool0
from tool0.errors import ControlError, RecordingError
from tool0.protocol.episodes import (
    CloseEpisodes,
    EndEpisode,
    OpenEpisodes,
    ReadEpisodes,
    StartEpisode,
)
from tool0.protocol.recordings import StartRecording, StopRecording
from tool0.recording.episodes import INDEX, read_index
from tool0.recording.png import encode_png
from tool0.recording.reading import open_recording
from tool0.recording.resimulation import resimulate
from tool0.recording.video import cameras_of


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def demonstrate(robot: tool0.Robot, outcome: str, duration: float = 0.2) -> None:
    robot.channel.call(StartEpisode())
    robot.move_joints({"elbow_joint": 1.2}, speed=1.0)
    robot.run(duration)
    robot.channel.call(EndEpisode(outcome=outcome))  # type: ignore[arg-type]


def test_episodes_are_kept_with_their_outcome(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    folder = tmp_path / "lift"
    call = robot.channel.call
    assert call(ReadEpisodes()) is None
    status = call(OpenEpisodes(folder=str(folder), task="lift the cube"))
    assert (status.episodes, status.is_recording) == (0, False)
    robot.run(0.1)
    demonstrate(robot, "success")
    demonstrate(robot, "discard")
    demonstrate(robot, "failure", duration=0.1)
    status = call(ReadEpisodes())
    assert status is not None
    assert (status.episodes, status.succeeded) == (2, 1)
    first, second = read_index(folder)
    assert (first.episode, first.outcome) == (0, "success")
    assert (second.episode, second.outcome) == (1, "failure")
    assert {first.task, second.task} == {"lift the cube"}
    assert first.duration == pytest.approx(0.2)
    files = sorted(path.name for path in folder.iterdir())
    assert files == ["episode_000000.mcap", "episode_000001.mcap", INDEX]
    for row in (first, second):
        recording = open_recording(folder / row.file)
        assert recording.time[0] == 0.0  # after a reset
        assert recording.duration == pytest.approx(row.duration)
        assert resimulate(recording).is_identical


def test_a_folder_is_continued(robot: tool0.Robot, tmp_path: Path) -> None:
    call = robot.channel.call
    opened = OpenEpisodes(folder=str(tmp_path / "lift"), reset=False)
    call(opened)
    demonstrate(robot, "success")
    call(CloseEpisodes())
    with pytest.raises(ControlError, match="no folder"):
        call(StartEpisode())
    assert call(opened).episodes == 1
    robot.run(0.1)
    demonstrate(robot, "success")
    rows = read_index(tmp_path / "lift")
    assert [row.episode for row in rows] == [0, 1]
    assert open_recording(tmp_path / "lift" / rows[1].file).time[0] > 0.2


def test_what_cannot_be_is_refused(robot: tool0.Robot, tmp_path: Path) -> None:
    call = robot.channel.call
    (tmp_path / "photo.png").touch()
    with pytest.raises(RecordingError, match=r"has other files \(photo\.png\)"):
        call(OpenEpisodes(folder=str(tmp_path)))
    call(OpenEpisodes(folder=str(tmp_path / "lift")))
    with pytest.raises(ControlError, match="no episode"):
        call(EndEpisode(outcome="success"))
    call(StartEpisode())
    with pytest.raises(ControlError, match="is being recorded"):
        call(StartEpisode())
    with pytest.raises(ControlError, match="is being recorded"):
        call(OpenEpisodes(folder=str(tmp_path / "other")))
    call(CloseEpisodes())
    assert [path.name for path in (tmp_path / "lift").iterdir()] == [INDEX]
    call(StartRecording(file=str(tmp_path / "other.mcap")))
    call(OpenEpisodes(folder=str(tmp_path / "lift")))
    with pytest.raises(ControlError, match="in progress"):
        call(StartEpisode())
    call(StopRecording())


def test_a_reset_within_an_episode_discards_it(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    call = robot.channel.call
    call(OpenEpisodes(folder=str(tmp_path / "lift")))
    call(StartEpisode())
    robot.run(0.1)
    robot.reset()
    robot.run(0.1)
    with pytest.raises(RecordingError, match="robot was reset"):
        call(EndEpisode(outcome="success"))
    assert [path.name for path in (tmp_path / "lift").iterdir()] == [INDEX]
    demonstrate(robot, "success")
    assert len(read_index(tmp_path / "lift")) == 1


@pytest.mark.parametrize(
    ("text", "problem"),
    [(b"{}\n", "line 1"), (b"{\xb6\n", "line 1"), (None, "no folder of episodes")],
)
def test_a_wrong_index_is_an_error(
    tmp_path: Path, text: bytes | None, problem: str
) -> None:
    if text is not None:
        (tmp_path / INDEX).write_bytes(text)
    with pytest.raises(RecordingError, match=problem):
        read_index(tmp_path)


# ---- as a data set ------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A success and a failure."""
    folder = tmp_path_factory.mktemp("demonstrations") / "lift"
    with tool0.bringup(realtime=False) as robot:
        robot.channel.call(OpenEpisodes(folder=str(folder), task="lift the cube"))
        demonstrate(robot, "success", duration=0.4)
        demonstrate(robot, "failure")
    return folder


def test_they_become_a_lerobot_data_set(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    import json

    from tool0.collect.demonstrations import export_lerobot

    target = tmp_path / "lerobot"
    manifest = export_lerobot(folder, target, rate=25.0)
    assert (manifest.n_episodes, manifest.n_succeeded) == (2, 1)
    info = json.loads((target / "meta/info.json").read_text())
    assert (info["codebase_version"], info["fps"]) == ("v3.0", 25)
    assert (info["total_episodes"], info["total_frames"]) == (2, 10 + 5)
    tasks = parquet.read_table(target / "meta/tasks.parquet")
    assert tasks["task"].to_pylist() == ["lift the cube"]
    table = parquet.read_table(target / "data/chunk-000/file-000.parquet")
    recording = open_recording(folder / "episode_000000.mcap")
    elbow = recording.joint_names.index("elbow_joint")
    state, action = table["observation.state"].to_pylist(), table["action"].to_pylist()
    assert len(action[0]) == 7  # six joints and the gripper's
    features = info["features"]
    now, then = (
        features[name]["names"].index("elbow_joint.position")
        for name in ("observation.state", "action")
    )
    velocity = features["observation.state"]["names"].index("elbow_joint.velocity")
    for k in range(10):
        frame = 5 * k  # of 125 Hz
        goal = recording.desired_position[frame + 5, elbow]
        assert action[k][then] == pytest.approx(goal)
        assert state[k][now] == pytest.approx(recording.position[frame, elbow])
        measured = recording.velocity[frame, elbow]
        assert state[k][velocity] == pytest.approx(measured)
    assert table["next.success"].to_pylist() == [False] * 9 + [True]
    assert "observation.environment_state" not in features  # no objects


@pytest.mark.parametrize("rate", [10, 20, 30, 50, 125])
def test_any_rate_is_interpolated(rate: int, folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    import json

    from tool0.collect.demonstrations import export_lerobot

    target = tmp_path / "lerobot"
    export_lerobot(folder, target, rate=rate, instruction="Bend the elbow.")
    info = json.loads((target / "meta/info.json").read_text())
    assert info["fps"] == rate
    tasks = parquet.read_table(target / "meta/tasks.parquet")
    assert tasks["task"].to_pylist() == ["Bend the elbow."]
    recording = open_recording(folder / "episode_000000.mcap")
    table = parquet.read_table(target / "data/chunk-000/file-000.parquet")
    n = table.num_rows
    assert n == int(recording.duration * rate + 1e-9)
    column = info["features"]["observation.state"]["names"].index(
        "elbow_joint.position"
    )
    elbow = recording.position[:, recording.joint_names.index("elbow_joint")]
    times = np.arange(n) / rate
    expected = np.interp(times, recording.time - recording.time[0], elbow)
    found = [row[column] for row in table["observation.state"].to_pylist()]
    np.testing.assert_allclose(found, expected, atol=1e-6)
    np.testing.assert_allclose(table["timestamp"].to_numpy(), times, atol=1e-6)


def test_objects_that_are_always_there_are_the_state_of_the_environment(
    tmp_path: Path,
) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    import json

    from tool0.collect.demonstrations import export_lerobot

    with tool0.bringup(scene="table_and_cubes", realtime=False) as robot:
        robot.channel.call(OpenEpisodes(folder=str(tmp_path / "seen"), reset=False))
        demonstrate(robot, "success", duration=0.4)
        names = [item.name for item in robot.scene.objects if item.mass]
        robot.scene.remove(names[0])
        demonstrate(robot, "success", duration=0.4)
    export_lerobot(tmp_path / "seen", tmp_path / "set", rate=20.0)
    info = json.loads((tmp_path / "set/meta/info.json").read_text())
    found = info["features"]["observation.environment_state"]["names"]
    parts = ("x", "y", "z", "qw", "qx", "qy", "qz")
    assert {*found} >= {f"{names[1]}.{part}" for part in parts}
    assert not [name for name in found if name.startswith(f"{names[0]}.")]
    table = parquet.read_table(tmp_path / "set/data/chunk-000/file-000.parquet")
    pose = open_recording(tmp_path / "seen/episode_000000.mcap").objects[names[1]][0]
    row = table["observation.environment_state"].to_pylist()[0]
    start = found.index(f"{names[1]}.x")
    np.testing.assert_allclose(row[start : start + 7], pose, atol=1e-6)


@pytest.mark.slow
def test_frames_can_have_images(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    require_gl()
    import json

    from tool0.collect.demonstrations import export_lerobot

    size = {"width": 64, "height": 48}
    export_lerobot(folder, tmp_path / "seen", cameras=["wrist", "scene"], **size)
    info = json.loads((tmp_path / "seen/meta/info.json").read_text())
    feature = info["features"]["observation.images.wrist"]
    assert (feature["dtype"], feature["shape"]) == ("image", [48, 64, 3])
    table = parquet.read_table(tmp_path / "seen/data/chunk-000/file-000.parquet")
    cells = table["observation.images.scene"].to_pylist()
    recording = open_recording(folder / "episode_000000.mcap")
    cameras = cameras_of(recording)
    camera, snapshots = replace(cameras["scene"], **size), recording.snapshots()
    images = [cameras.render(camera, snapshots[5 * k]).rgb for k in range(10)]
    cameras.close()
    assert [cell["bytes"] for cell in cells] == [encode_png(image) for image in images]
    assert (images[0] != images[-1]).any()  # the arm has moved
    rows = parquet.read_table(
        tmp_path / "seen/meta/episodes/chunk-000/file-000.parquet"
    )
    first = rows.slice(0, 1).to_pylist()[0]
    colours = np.array(images) / 255.0
    for name in ("min", "max", "mean", "std"):
        expected = getattr(colours, name)((0, 1, 2))
        found = first[f"stats/observation.images.scene/{name}"]
        assert np.ravel(found) == pytest.approx(expected)


def test_an_episode_that_starts_between_snapshots_is_exported(tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    pytest.importorskip("pyarrow")
    from tool0.collect.demonstrations import episode_of

    with tool0.bringup(realtime=False) as robot:
        call = robot.channel.call
        call(OpenEpisodes(folder=str(tmp_path), reset=False))
        robot.run(0.013)
        demonstrate(robot, "success", duration=0.4)
    (row,) = read_index(tmp_path)
    recording = open_recording(tmp_path / row.file)
    assert recording.tick[0] == 13
    assert episode_of(recording, row, 25.0).n_frames == 9  # from 0.04 to 0.36 s


def test_an_export_names_the_extra_that_is_missing(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tool0.collect.demonstrations import export_lerobot
    from tool0.errors import ConfigError

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ConfigError, match=r"pip install '\.\[collect\]'"):
        export_lerobot(folder, tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_failures_can_be_left_out(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    pytest.importorskip("pyarrow")
    from tool0.collect.demonstrations import export_lerobot
    from tool0.errors import CollectError, ConfigError

    manifest = export_lerobot(folder, tmp_path / "good", only_successes=True)
    assert manifest.n_episodes == manifest.n_succeeded == 1
    with pytest.raises(ConfigError, match="choose another"):
        export_lerobot(folder, tmp_path / "good", only_successes=True)
    for rate, shown in (
        (12.5, "rate 12.5 Hz: a LeRobot data set has a whole number"),
        (0.0, "rate 0 Hz"),
        (250.0, "rate 250 Hz: .* has 125 snapshots per second"),
    ):
        with pytest.raises(ConfigError, match=shown):
            export_lerobot(folder, tmp_path / "odd", rate=rate)
    empty = tmp_path / "empty"
    shutil.copytree(folder, empty)
    (empty / INDEX).write_text("")
    with pytest.raises(CollectError, match="no episodes"):
        export_lerobot(empty, tmp_path / "none")
