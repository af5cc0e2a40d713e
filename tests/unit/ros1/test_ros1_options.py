import re
from pathlib import Path

import pytest

from tool0.cli.options import BringupOptions, RunOptions
from tool0.description.loading import assemble
from tool0.errors import ConfigError
from tool0.ros1.bridge import with_mesh_files
from tool0.ros1.options import Ros1Options


@pytest.mark.parametrize(
    ("ns", "node"),
    [
        ("", "/gazebo"),
        ("/", "/gazebo"),
        ("left", "/left/gazebo"),
        ("/left/arm_2/", "/left/arm_2/gazebo"),
    ],
)
def test_a_namespace_begins_every_name(ns: str, node: str) -> None:
    assert Ros1Options(ns=ns).node == node


@pytest.mark.parametrize("ns", ["2nd", "left arm", "a//b", "~", "left-arm", "a/2"])
def test_what_is_no_namespace_of_ros_is_refused(ns: str) -> None:
    with pytest.raises(ConfigError) as error:
        Ros1Options(ns=ns)
    assert repr(ns) in str(error.value)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf"), 1001.0])
def test_a_rate_of_transforms_that_cannot_be_is_refused(rate: float) -> None:
    with pytest.raises(ConfigError):
        Ros1Options(tf_pub_rate=rate)


@pytest.mark.parametrize(
    "options", [{"roscore": True}, {"ns": "left"}, {"tf_pub_rate": 50.0}]
)
def test_options_of_ros_need_ros(options: dict[str, object]) -> None:
    ros = Ros1Options(**options)  # type: ignore[arg-type]
    BringupOptions(run=RunOptions(ros1=True), ros=ros)
    with pytest.raises(ConfigError) as error:
        BringupOptions(ros=ros)
    assert "--ros1" in str(error.value)


def test_bundled_meshes_become_existing_files() -> None:
    urdf = with_mesh_files(assemble().urdf)
    names = set(re.findall(r'<mesh filename="([^"]+)"', urdf))
    assert len(names) > 10
    for name in names:
        scheme, path = name.split("://")
        assert scheme == "file"
        assert Path(path).is_file()


def test_other_packages_stay_as_they_are() -> None:
    theirs = '<mesh filename="package://my_description/tool0_description/x.stl"/>'
    assert with_mesh_files(theirs) == theirs
