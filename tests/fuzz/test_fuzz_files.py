"""Files of every kind with something changed in them: read, or an error of tool0."""

from __future__ import annotations

import contextlib
import io
import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from fuzzing import SCALE, Trial, changed

import tool0
from tool0.cli import FAILED, main
from tool0.description.cell_file import load_cell
from tool0.description.config import DescriptionConfig
from tool0.description.loading import assemble, load_description
from tool0.description.scene_file import load_scene
from tool0.lint.check import check
from tool0.programs.export_python import python_text
from tool0.programs.files import read_program
from tool0.recording.episodes import INDEX, read_index

N = 40 * SCALE
"""Files of each kind."""
SEED = 23
DATA = Path(__file__).parents[1] / "data"
EXAMPLES = Path(__file__).parents[2] / "examples"
SOURCE = Path(tool0.__file__).parent
PACKAGE = SOURCE / "ros_packages/tool0_description"
LAUNCH = DATA / "launch/src"
PROGRAM = b"""\
name: pick
tool: {xyz: [0, 0, 0.1418]}
steps:
  - {kind: gripper, opening: open}
  - kind: move_joint
    pose: {xyz: [0.5487, 0.1091, 0.2], rpy: [!degrees 180, 0, 0]}
    blend: 0.03
  - kind: move_linear
    pose: {xyz: [0.5487, 0.1091, 0.0025], rpy: [!degrees 180, 0, 0]}
  - {kind: gripper, opening: closed, force: 40, must_hold: true}
  - kind: loop
    times: 3
    steps:
      - {kind: wait, duration: 0.5}
      - {kind: move_joint, named_pose: home}
"""
EPISODES = b"""\
{"episode":0,"file":"episode_000000.mcap","outcome":"success","task":"lift",\
"duration":0.4,"wall_start":1.0}
{"episode":1,"file":"episode_000001.mcap","outcome":"failure","task":"lift",\
"duration":0.2,"wall_start":2.0}
"""

PARAMETERS = {
    "joint_limits": "--joint-limit-params",
    "default_kinematics": "--kinematics-params",
    "physical_parameters": "--physical-params",
    "visual_parameters": "--visual-params",
}


@dataclass(frozen=True)
class Kind:
    """One kind of file: what is changed, and what is done with it."""

    name: str
    """Of the file that is written."""
    originals: tuple[bytes, ...]
    reads: tuple[Callable[[Path], object], ...]
    """Each is done with a part of the files, in turn."""


def texts(*paths: Path) -> tuple[bytes, ...]:
    return tuple(path.read_bytes() for path in paths)


def command(*words: str) -> Callable[[Path], object]:
    """Return what calls a command, with the file in place of ``{}``."""

    def call(file: Path) -> object:
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            status = main([word.replace("{}", str(file)) for word in words])
        assert "Traceback" not in said.getvalue()
        if status == FAILED:
            raise tool0.ConfigError(said.getvalue())
        return status

    return call


def simulated(**options: Callable[[Path], Any]) -> Callable[[Path], object]:
    """Return what brings up a robot that the file is a part of."""

    def call(file: Path) -> object:
        given = {name: make(file) for name, make in options.items()}
        with tool0.bringup(realtime=False, **given) as robot:
            return robot.run(0.02)

    return call


def described(file: Path) -> object:
    return load_description(DescriptionConfig(robot=file))


def cell(file: Path) -> object:
    return load_description(DescriptionConfig(cell=load_cell(file)))


def kinds() -> dict[str, Kind]:
    """Return every kind of file that is read."""
    xacro = (
        DATA / "description/ros2_arm.urdf.xacro",
        PACKAGE / "urdf/ur_robotiq.urdf.xacro",
    )
    launch = (
        LAUNCH / "quirks/launch/quirks.launch",
        LAUNCH / "arm_gazebo/launch/arm_bringup.launch",
        LAUNCH / "arm_gazebo/launch/inc/load_arm.launch.xml",
        SOURCE / "ros_packages/tool0_gazebo/launch/bringup.launch",
    )
    templates = SOURCE / "installation/colcon/template/launch"
    controllers = (
        DATA / "controllers/ur5_controllers.yaml",
        DATA / "controllers/ros2_variants.yaml",
        PACKAGE / "config/controllers.yaml",
    )
    return {
        "urdf": Kind(
            "robot.urdf",
            (assemble().urdf.encode(), assemble(gripper=None).urdf.encode()),
            (described, check, simulated(robot=lambda file: file)),
        ),
        "xacro": Kind(
            "robot.urdf.xacro",
            texts(*xacro),
            (described, check, command("describe", "table", "--robot", "{}")),
        ),
        "controllers": Kind(
            "controllers.yaml",
            texts(*controllers),
            (check, simulated(controllers_file=lambda file: file)),
        ),
        **{
            name: Kind(
                f"{name}.yaml",
                texts(PACKAGE / f"config/arms/ur5/{name}.yaml"),
                (command("describe", "tree", option, "{}"),),
            )
            for name, option in PARAMETERS.items()
        },
        "launch": Kind(
            "main.launch", texts(*launch), (check, command("explain", "{}"))
        ),
        "python launch": Kind(
            "main.launch.py",
            texts(*sorted(templates.glob("*.launch.py.in"))),
            (check, command("explain", "{}")),
        ),
        "scene": Kind(
            "scene.yaml",
            texts(*sorted((SOURCE / "scenes").glob("*.yaml"))),
            (load_scene, load_scene, load_scene, simulated(scene=lambda file: file)),
        ),
        "cell": Kind(
            "cell.yaml",
            texts(EXAMPLES / "cell/two_robots.yaml"),
            (load_cell, cell),
        ),
        "program": Kind(
            "pick.yaml",
            (PROGRAM,),
            (read_program, lambda file: python_text(read_program(file).program)),
        ),
        "episodes": Kind(INDEX, (EPISODES,), (lambda file: read_index(file.parent),)),
        "package": Kind(
            "package.xml",
            texts(PACKAGE / "package.xml"),
            (check, lambda file: check(file.parent)),
        ),
    }


KINDS = kinds()


@pytest.mark.parametrize("kind", KINDS)
def test_the_files_are_right_before_they_are_changed(kind: str, tmp_path: Path) -> None:
    for original in KINDS[kind].originals:
        (tmp_path / KINDS[kind].name).write_bytes(original)
        for read in KINDS[kind].reads:
            read(tmp_path / KINDS[kind].name)


@pytest.mark.timeout(600 * SCALE)
@pytest.mark.parametrize("kind", KINDS)
def test_files(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = KINDS[kind]
    trial = Trial(f"{kind} files")
    file = tmp_path / found.name
    for number in range(N):
        rng = random.Random(f"{SEED}.{kind}.{number}")
        original = rng.choice(found.originals)
        content = changed(original, rng)
        file.write_bytes(content)
        read = found.reads[number % len(found.reads)]
        trial.carry_out(partial(read, file), f"case {number}")
    trial.check()
