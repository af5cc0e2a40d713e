"""What a workspace is given is what tool0 itself reads."""

from pathlib import PurePosixPath
from xml.etree import ElementTree

from tool0.description.packages import BUNDLED
from tool0.installation.workspace.layout import PACKAGES, UPSTREAM_PACKAGES, contents

MESHES_ARGUMENT = (
    "tool0_description/launch/view_ur5_robotiq_2f_85.launch",
    "tool0_description/urdf/ur_robotiq.urdf.xacro",
    "tool0_gazebo/launch/inc/load_ur5_robotiq_2f_85.launch.xml",
    "tool0_gazebo/launch/ur5_robotiq_2f_85_bringup.launch",
)


def test_it_is_what_the_program_reads() -> None:
    files = contents()
    assert {path.parts[0] for path in files} == set(PACKAGES)
    assert all((BUNDLED / path).read_bytes() == data for path, data in files.items())
    for needed in ("package.xml", "CMakeLists.txt"):
        assert all(PurePosixPath(name, needed) in files for name in PACKAGES)


def test_what_tools_leave_behind_stays_out() -> None:
    names = [part for path in contents() for part in path.parts]
    assert not [name for name in names if name.startswith((".", "__"))]


def test_upstream_meshes_change_the_default_and_the_dependencies_alone() -> None:
    ours, theirs = contents(), contents(upstream_meshes=True)
    changed = {str(path) for path in ours if ours[path] != theirs[path]}
    assert changed == {*MESHES_ARGUMENT, "tool0_description/package.xml"}
    for name in MESHES_ARGUMENT:
        path = PurePosixPath(name)
        assert theirs[path].count(b'"meshes" default="upstream"') == 1
        assert b'"meshes" default="tool0"' not in theirs[path]


def test_upstream_packages_become_dependencies() -> None:
    path = PurePosixPath("tool0_description/package.xml")

    def dependencies(data: bytes) -> set[str | None]:
        found = ElementTree.fromstring(data.decode()).iterfind("exec_depend")
        return {element.text for element in found}

    added = dependencies(contents(upstream_meshes=True)[path])
    assert added - dependencies(contents()[path]) == set(UPSTREAM_PACKAGES)
