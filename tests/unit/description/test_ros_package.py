"""The ROS package serves ROS as it serves us: plain xacro reads the same robot."""

import sys
from pathlib import Path
from types import ModuleType

import pytest
import xacro

from tool0.description.loading import assemble
from tool0.description.packages import find_package
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text

DATA = Path(__file__).parents[2] / "data"


@pytest.fixture
def ament(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in for the index of packages that ROS gives to xacro."""
    index, packages = ModuleType("ament_index_python"), ModuleType("packages")
    packages.get_package_share_directory = lambda name: str(find_package(name))  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "ament_index_python", index)
    monkeypatch.setitem(sys.modules, "ament_index_python.packages", packages)


@pytest.mark.slow
@pytest.mark.usefixtures("ament")
@pytest.mark.parametrize(
    "args",
    [
        {},
        {"gripper": "none", "safety_limits": "true"},
        {"gripper_model": "linkage"},
        {
            "prefix": "left_",
            "physical_params": str(
                DATA / "description" / "ur5_noetic_physical_parameters.yaml"
            ),
            "gripper_params": str(DATA / "golden" / "2f85_physical_parameters.yaml"),
        },
    ],
)
def test_plain_xacro_reads_the_same_robot(
    args: dict[str, str], capfd: pytest.CaptureFixture[str]
) -> None:
    path = find_package("tool0_description") / "urdf" / "ur_robotiq.urdf.xacro"
    document = xacro.process_file(str(path), mappings=dict(args))
    assert read_model(parse_text(document.toxml())) == assemble(**args).model  # type: ignore[arg-type]
    assert capfd.readouterr().err == ""


def test_the_package_says_what_it_installs() -> None:
    package = find_package("tool0_description")
    rules = (package / "CMakeLists.txt").read_text()
    (line,) = (line for line in rules.splitlines() if line.startswith("install("))
    installed = set(line.partition("DIRECTORY ")[2].split(" DESTINATION")[0].split())
    folders = {path.name for path in package.iterdir() if path.is_dir()}
    assert installed == folders
