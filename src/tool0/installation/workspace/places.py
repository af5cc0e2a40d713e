"""Where in a person's folder the packages go, as catkin's users lay workspaces out."""

from __future__ import annotations

from pathlib import Path

from tool0.description.packages import crawl, package_name
from tool0.errors import ConfigError
from tool0.installation.workspace.contents import PACKAGES


def source_folder(folder: Path) -> Path:
    """Return the folder of packages that ``folder`` has, is, or will have.

    A workspace has ``src``; so will a folder that is empty, or not there yet.  A folder
    that is called ``src``, that catkin_init_workspace was run in, or that has packages
    in it is one itself.

    Raises:
        ConfigError: If packages cannot be put there.
    """
    folder = folder.expanduser().absolute()
    _refuse_files(folder)
    _refuse_packages(folder)
    below = folder / "src"
    found = below if below.is_dir() or not _holds_packages(folder) else folder
    _refuse_files(found)
    _refuse_namesakes(found)
    return found


def _holds_packages(folder: Path) -> bool:
    if folder.name == "src":
        return True
    try:
        children = sorted(folder.iterdir())
    except OSError:
        return False
    # catkin's own top-level CMakeLists.txt is a link to where catkin is installed
    has_toplevel = (folder / "CMakeLists.txt").is_symlink()
    return has_toplevel or any((child / "package.xml").is_file() for child in children)


def _refuse_files(folder: Path) -> None:
    for path in (folder, *folder.parents):
        if path.exists() and not path.is_dir():
            raise ConfigError(f"'{path}' is not a folder; name a catkin workspace")
        if path.is_symlink() and not path.exists():
            raise ConfigError(f"'{path}' is a link to nothing; remove it, or mend it")


def _refuse_packages(folder: Path) -> None:
    for path in (folder, *folder.parents):
        if (path / "package.xml").is_file():
            raise ConfigError(
                f"'{path}' is a ROS package, and catkin looks for none inside of one; "
                "name the workspace, the folder above its 'src'"
            )


def _refuse_namesakes(source: Path) -> None:
    """Raise ConfigError if a package of ours is there already, elsewhere."""
    ours = {source / name for name in PACKAGES}
    for path in ours:
        if path.is_symlink():
            raise ConfigError(
                f"'{path}' is a link to '{path.resolve()}', which would be written to; "
                "remove it, or name another workspace"
            )
    for path in crawl(source):
        name = package_name(path)
        if name in PACKAGES and path not in ours:
            raise ConfigError(
                f"'{path}' is a package called {name} already, and catkin takes no two "
                "of one name; remove it, or put a CATKIN_IGNORE file into it"
            )
