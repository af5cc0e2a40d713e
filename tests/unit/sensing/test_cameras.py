"""The cameras of a robot: who draws, when, and until when."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest
from flat_options import configured
from promised import require_gl
from served import serving, use_folder

import tool0
from tool0.description.camera import Camera, looking
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.errors import ConfigError, RenderError, SourceLocation

pytestmark = pytest.mark.slow

THREAD = "tool0 cameras"


def drawing_threads() -> list[str]:
    names = [thread.name for thread in threading.enumerate()]
    return [name for name in names if name.startswith(THREAD)]


def bring_up(**options: object) -> tool0.Robot:
    return tool0.bringup(**configured(realtime=False, **options))


def test_robots_have_cameras_by_name_and_draw_nothing_until_asked() -> None:
    with bring_up() as robot:
        assert list(robot.cameras) == ["wrist", "scene"]
        assert robot.camera("wrist") is robot.cameras["wrist"]
        with pytest.raises(RenderError) as error:
            robot.camera("wirst")
        assert "'wrist'" in str(error.value)
        assert drawing_threads() == []


def test_own_cameras_join_or_replace_those_of_file_and_robot(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("cameras:\n- {name: side, width: 64}\n- {name: scene, width: 32}\n")
    own = Camera(name="side", width=128)
    with bring_up(scene=path, cameras=(own,)) as robot:
        widths = {name: view.camera.width for name, view in robot.cameras.items()}
    assert widths == {"wrist": 640, "scene": 32, "side": 128}
    path.write_text("cameras:\n- {name: side}\n- {name: a, link: tolo0}\n")
    with pytest.raises(ConfigError) as error:
        bring_up(scene=path)
    assert error.value.location == SourceLocation(path, 3)
    for name in ("'a'", "'tool0'"):
        assert name in str(error.value)


def test_cameras_of_a_file_are_known_in_another_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("cameras:\n- {name: side, link: tool0, width: 64}\n")
    use_folder(monkeypatch, tmp_path)
    with bring_up(scene=path) as robot, serving(robot), tool0.connect() as remote:
        assert list(remote.cameras) == ["wrist", "scene", "side"]
        assert remote.camera("side").camera == robot.camera("side").camera


def test_the_wrist_camera_sees_what_is_between_the_pads() -> None:
    require_gl()
    with bring_up() as robot:
        grasp = robot.pose("left_inner_finger_pad").position
        other = robot.pose("right_inner_finger_pad").position
        x, y, z = ((a + b) / 2.0 for a, b in zip(grasp, other, strict=True))
        robot.scene.add("cube", Box(size=(0.03,) * 3), xyz=(x, y, z), rgba=(0, 1, 0, 1))
        image = robot.camera("wrist").image()
        p_camera = image.T_root_camera.inverse().apply((x, y, z))
        u, v, w = image.K @ p_camera
        column, row = round(u / w), round(v / w)
        red, green, blue = map(int, image.rgb[row, column])
        assert green > 2 * max(red, blue)
        # Its middle is at most half a diagonal behind what is seen of it.
        assert p_camera[2] - 0.03 < image.depth[row, column] < p_camera[2]


def test_a_picture_is_of_the_snapshot_and_bears_its_time() -> None:
    require_gl()
    cube = SceneObject(
        name="cube",
        geometry=Box(size=(0.1,) * 3),
        pose=Pose(xyz=(0.0, 0.4, 0.1)),
        mass=1.0,
        rgba=(0, 1, 0, 1),
    )
    small = Camera(
        name="side", pose=looking((2, 0.01, 0.5), (0, 0, 0)), width=64, height=48
    )
    with bring_up(scene=Scene((cube,)), cameras=(small,)) as robot:
        view = robot.camera("side")
        first, before = robot.snapshot, view.image()
        robot.scene.place("cube", (1.0, 0.0, 0.5))
        robot.run(0.1)
        after = view.image()
        robot.scene.remove("cube")
        robot.run(0.1)
        assert view.image().time == pytest.approx(0.2)
        again = view.image(first)  # the scene of that time, too
    assert (before.time, after.time) == (0.0, pytest.approx(0.1))
    assert (before.rgb != after.rgb).any()
    assert np.array_equal(before.rgb, again.rgb)
    assert np.array_equal(before.depth, again.depth)
    assert (before.rgb.shape, before.rgb.dtype) == ((48, 64, 3), np.uint8)
    assert (before.depth.shape, before.depth.dtype) == ((48, 64), np.float32)


def test_drawing_changes_nothing_in_the_simulation() -> None:
    require_gl()

    def run(*, looking: bool) -> tuple[float, ...]:
        with bring_up() as robot:
            for _ in range(3):
                robot.run(0.05)
                if looking:
                    robot.camera("wrist").image()
            return robot.snapshot.position

    assert run(looking=True) == run(looking=False)


def test_any_thread_may_look_and_one_draws_until_the_robot_closes() -> None:
    require_gl()
    tiny = Camera(name="tiny", width=8, height=8)
    with bring_up(cameras=(tiny,)) as robot:
        view = robot.camera("tiny")
        threads = [threading.Thread(target=view.image) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(drawing_threads()) == 1
        big = Camera(name="big", width=700, height=500)
        assert robot.simulation.cameras.render(big).rgb.shape == (500, 700, 3)
        assert view.image().rgb.shape == (8, 8, 3)
    assert drawing_threads() == []
    with pytest.raises(RenderError):
        view.image()
    robot.close()
