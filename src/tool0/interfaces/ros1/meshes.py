"""Where programs of ROS find the meshes of a description."""

from __future__ import annotations

from tool0.description.packages import BUNDLED


def with_found_meshes(urdf: str) -> str:
    """Return the URDF with the meshes that tool0 brings named by file.

    ROS does not know the packages inside tool0, so that RViz would show no robot unless
    its terminal had their folder in ``ROS_PACKAGE_PATH``.  Other packages are a
    person's own, which their ROS finds.
    """
    for folder in BUNDLED.iterdir():
        if (folder / "package.xml").is_file():
            urdf = urdf.replace(f"package://{folder.name}/", f"{folder.as_uri()}/")
    return urdf
