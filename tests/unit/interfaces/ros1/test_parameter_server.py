import re
from pathlib import Path

from tool0.description.catalogue import assemble
from tool0.interfaces.ros1.parameter_server import with_mesh_files


def test_every_mesh_of_ours_is_named_by_a_file_that_is_there() -> None:
    urdf = with_mesh_files(assemble().urdf)
    names = set(re.findall(r'<mesh filename="([^"]+)"', urdf))
    assert len(names) > 10
    for name in names:
        scheme, path = name.split("://")
        assert scheme == "file"
        assert Path(path).is_file()


def test_a_person_s_own_packages_are_left_to_their_ros() -> None:
    theirs = '<mesh filename="package://my_description/tool0_description/x.stl"/>'
    assert with_mesh_files(theirs) == theirs
