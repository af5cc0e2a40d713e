import re
from pathlib import Path

from tool0.description.catalogue import assemble
from tool0.interfaces.ros1.bridge import with_mesh_files


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
