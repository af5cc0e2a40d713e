"""Makes the message classes importable that the ROS edge speaks in.

``control_msgs``, ``controller_manager_msgs`` and ``gazebo_msgs`` are those installed;
a package that is not is generated from our definitions, once, and kept in the cache.
"""

from __future__ import annotations

import hashlib
import importlib.util
import shutil
import sys
import tempfile
from importlib.machinery import PathFinder
from pathlib import Path

from tool0.errors import RosUnavailableError
from tool0.installation.ros1 import generation
from tool0.installation.ros1.installed import check_installed
from tool0.installation.ros1.library import SET_UP, import_ros
from tool0.user_data import cache_folder, locked


def import_messages() -> None:
    """Make rospy and every message package importable; a second call changes nothing.

    Raises:
        RosUnavailableError: If there is no rospy, or an installed package lacks what
            is needed.
    """
    import_ros()
    absent = absent_packages()
    for package in generation.package_names():
        if package not in absent:
            check_installed(package)
    if not absent:
        return
    try:
        folder = generated_packages(absent)
    except OSError as error:
        folder = _for_this_process_alone(absent, error)
    sys.path[:] = [*_path(), str(folder)]
    importlib.invalidate_caches()


def absent_packages() -> tuple[str, ...]:
    """Return the packages of ours that are not installed; rospy is importable.

    What an earlier run generated, and PYTHONPATH names, does not count as installed.
    """
    path = _path()
    return tuple(name for name in generation.package_names() if not _is_in(path, name))


def _is_in(path: list[str], package: str) -> bool:
    spec = PathFinder.find_spec(package, path)
    return spec is not None and spec.origin is not None  # or a mere folder of that name


def _path() -> list[str]:
    return [entry for entry in sys.path if not is_generated(entry)]


def is_generated(entry: str) -> bool:
    """Return whether an entry of a search path is what ``generated_packages`` made."""
    return Path(entry).parent == _home()


def _home() -> Path:
    return cache_folder() / "ros1"


def generated_packages(packages: tuple[str, ...]) -> Path:
    """Return the folder that holds these packages, made if it is not there.

    It is an entry for both PYTHONPATH and ROS_PACKAGE_PATH.

    Raises:
        RosUnavailableError: If genpy cannot make them.
        OSError: If it is not there and the cache cannot be written.
    """
    folder = _home() / _key(packages)
    if folder.is_dir():
        return folder
    folder.parent.mkdir(parents=True, exist_ok=True)
    with locked(folder.parent / "lock"):
        if not folder.is_dir():  # another process may have made it meanwhile
            new = Path(tempfile.mkdtemp(prefix="new-", dir=folder.parent))
            try:
                generation.generate(packages, new)
                _compile(new, folder)
                new.rename(folder)
            except BaseException:
                shutil.rmtree(new, ignore_errors=True)
                raise
    return folder


def _compile(folder: Path, place: Path) -> None:
    """Write the bytecode of what is to be at ``place``: importing is 5 times as fast.

    Python would by itself, but not where PYTHONDONTWRITEBYTECODE is set.
    """
    from compileall import compile_dir

    compile_dir(folder, quiet=2, stripdir=str(folder), prependdir=str(place))


def _key(packages: tuple[str, ...]) -> str:
    """Return a name for all that the outcome depends on."""
    generator = importlib.util.find_spec("genpy.generator")
    if generator is None or generator.origin is None:
        raise RosUnavailableError(f"ROS 1 needs genpy, which is not here; {SET_UP}")
    files = [Path(generator.origin), Path(generation.__file__), Path(__file__)]
    for package in packages:
        files += generation.definition_files(package)
    digest = hashlib.sha256(f"{sys.version_info[:2]} {packages}".encode())
    for file in files:
        digest.update(f"\0{file.name}\0".encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def _for_this_process_alone(packages: tuple[str, ...], why: OSError) -> Path:
    """Make the packages in a temporary folder that ends with the process."""
    import atexit

    try:
        folder = Path(tempfile.mkdtemp(prefix="tool0-ros1-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        generation.generate(packages, folder)
    except OSError as error:
        raise RosUnavailableError(
            f"the classes of {', '.join(packages)} can be written neither to the cache "
            f"({why}) nor to a temporary folder ({error}); XDG_CACHE_HOME and TMPDIR "
            "name others"
        ) from None
    return folder
