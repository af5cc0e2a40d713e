"""What `tool0 workspace` writes is what the program reads, for the chosen robot."""

import shutil
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import pytest
import yaml

from tool0.control.default_controllers import controllers_yaml
from tool0.description.loading import assemble
from tool0.description.packages import BUNDLED
from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError
from tool0.installation.robot_packages import (
    PACKAGES,
    UPSTREAM_PACKAGES,
    Files,
    robot_packages,
)

DEFAULT_CONTROLLERS = "tool0_gazebo/config/ur5_2f85_controllers.yaml"


def packages(
    description: RobotDescription | None = None, *, upstream_meshes: bool = False
) -> Files:
    description = description or assemble()
    return robot_packages(
        description.robots,
        controllers=controllers_yaml(description),
        action_controllers=controllers_yaml(description, gripper_action=True),
        upstream_meshes=upstream_meshes,
    )


@pytest.fixture(scope="module")
def default() -> Files:
    return packages()


def test_it_is_what_the_program_reads(default: Files) -> None:
    assert {path.parts[0] for path in default} == set(PACKAGES)
    written = {path for path in default if not (BUNDLED / path).exists()}
    assert {str(path) for path in written} == {
        DEFAULT_CONTROLLERS,
        DEFAULT_CONTROLLERS.replace(".yaml", "_gripper_action.yaml"),
    }
    same = default.keys() - written
    assert all((BUNDLED / path).read_bytes() == default[path] for path in same)
    texts = [data for path, data in default.items() if path.suffix == ".yaml"]
    assert not [text for text in texts if b"$gains" in text]  # for the program
    names = [part for path in default for part in path.parts]
    assert not [name for name in names if name.startswith((".", "__"))]
    for needed in ("package.xml", "CMakeLists.txt"):
        assert all(PurePosixPath(name, needed) in default for name in PACKAGES)


def test_another_robot_changes_defaults_and_controllers_alone(default: Files) -> None:
    other = packages(assemble("ur10e", "2f140"))
    changed = {str(path) for path in default if default[path] != other.get(path)}
    assert changed == {
        "tool0_description/launch/view.launch",
        "tool0_description/urdf/ur_robotiq.urdf.xacro",
        "tool0_gazebo/launch/bringup.launch",
        "tool0_gazebo/launch/inc/load_robot.launch.xml",
        "tool0_gazebo/urdf/robot_gazebo.urdf.xacro",
        DEFAULT_CONTROLLERS,
        DEFAULT_CONTROLLERS.replace(".yaml", "_gripper_action.yaml"),
    }
    launch = other[PurePosixPath("tool0_gazebo/launch/bringup.launch")].decode()
    assert 'name="arm" default="ur10e"' in launch
    assert 'name="gripper" default="2f140"' in launch
    config = PurePosixPath("tool0_gazebo/config")
    assert config / "ur10e_2f140_controllers.yaml" in other


def test_the_default_robots_controllers_in_gazebo_are_the_measured_ones(
    default: Files,
) -> None:
    """The values of docs/how-to/workspace.md; the arm's are the program's."""
    expected = yaml.safe_load(controllers_yaml(assemble()))
    found = yaml.safe_load(default[PurePosixPath(DEFAULT_CONTROLLERS)])
    gripper = found.pop("gripper_controller")
    assert expected.pop("gripper_controller")["type"] == gripper["type"]
    assert found == expected
    assert gripper["gains"]["finger_joint"] == {"p": 10, "i": 0, "d": 0.1}
    assert gripper["velocity_ff"] == {"finger_joint": 1.0}


def test_a_gripper_without_measurements_keeps_its_own_controller() -> None:
    description = assemble("ur5", "2f140")
    files = packages(description)
    path = PurePosixPath("tool0_gazebo/config/ur5_2f140_controllers.yaml")
    assert files[path].decode() == controllers_yaml(description)


def test_an_arm_without_gripper_has_controllers() -> None:
    files = packages(assemble("ur5", None))
    path = PurePosixPath("tool0_gazebo/config/ur5_none_controllers.yaml")
    assert "gripper_controller" not in yaml.safe_load(files[path])


@pytest.mark.slow
def test_your_own_folder_goes_among_the_built_in_ones(tmp_path: Path) -> None:
    config = BUNDLED / "tool0_description" / "config" / "arms"
    own = tmp_path / "long_arm"
    shutil.copytree(config / "ur5", own)
    files = packages(assemble(str(own)))
    below = PurePosixPath("tool0_description/config/arms/long_arm")
    for name in ("default_kinematics.yaml", "physical_parameters.yaml"):
        assert files[below / name] == (own / name).read_bytes()
    launch = files[PurePosixPath("tool0_gazebo/launch/bringup.launch")]
    assert b'name="arm" default="long_arm"' in launch


@pytest.mark.parametrize(
    ("name", "problem"), [("ur10e", "like a built-in arm"), ("my arm", "letters")]
)
def test_a_folder_that_cannot_go_there_is_an_error(
    tmp_path: Path, name: str, problem: str
) -> None:
    config = BUNDLED / "tool0_description" / "config" / "arms"
    shutil.copytree(config / "ur5", tmp_path / name)
    with pytest.raises(ConfigError, match=problem):
        packages(assemble(str(tmp_path / name)))


def test_upstream_meshes_change_the_default_and_the_dependencies_alone(
    default: Files,
) -> None:
    theirs = packages(upstream_meshes=True)
    changed = {path for path in default if default[path] != theirs[path]}
    manifest = PurePosixPath("tool0_description/package.xml")
    assert manifest in changed
    assert len(changed) == 5
    for path in changed - {manifest}:
        assert theirs[path].count(b'"meshes" default="upstream"') == 1
        assert b'"meshes" default="tool0"' not in theirs[path]


def test_upstream_packages_become_dependencies(default: Files) -> None:
    path = PurePosixPath("tool0_description/package.xml")

    def dependencies(data: bytes) -> set[str | None]:
        found = ElementTree.fromstring(data.decode()).iterfind("exec_depend")
        return {element.text for element in found}

    added = dependencies(packages(upstream_meshes=True)[path])
    assert added - dependencies(default[path]) == set(UPSTREAM_PACKAGES)
