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
from pathlib import Path

from tool0.errors import RosUnavailableError
from tool0.ros1 import generation
from tool0.ros1.library import SET_UP, import_ros
from tool0.user_data import cache_folder, locked


def import_messages() -> None:
    """Make rospy and every message package importable.

    Raises:
        RosUnavailableError: If there is no rospy, or an installed package lacks what
            is needed.
    """
    import_ros()
    absent = absent_packages()
    if not absent:
        return
    try:
        folder = generated_packages(absent)
    except OSError:
        folder = _for_this_process_alone(absent)
    sys.path.append(str(folder))
    importlib.invalidate_caches()


def absent_packages() -> tuple[str, ...]:
    """Return the packages of ours that are not installed.

    What an earlier run generated, and a shell names, does not count as installed.
    """
    sys.path[:] = [entry for entry in sys.path if not is_generated(entry)]
    return tuple(name for name in generation.package_names() if not _is_installed(name))


def _is_installed(package: str) -> bool:
    spec = importlib.util.find_spec(package)
    return spec is not None and spec.origin is not None  # or a mere folder of that name


def is_generated(path: str) -> bool:
    """Return whether the path is a folder that ``generated_packages`` made."""
    return Path(path).parent == _home()


def _home() -> Path:
    return cache_folder() / "ros1"


def generated_packages(packages: tuple[str, ...]) -> Path:
    """Return the folder that holds these packages, made if it is not there.

    Raises:
        OSError: If it is not there and the cache cannot be written.
    """
    folder = _home() / _key(packages)
    if folder.is_dir():
        return folder
    folder.parent.mkdir(parents=True, exist_ok=True)
    with locked(folder.parent / "lock"):
        if not folder.is_dir():
            new = Path(tempfile.mkdtemp(prefix="new-", dir=folder.parent))
            try:
                generation.generate(packages, new)
                new.chmod(0o755)
                new.rename(folder)
            except BaseException:
                shutil.rmtree(new, ignore_errors=True)
                raise
    return folder


def _key(packages: tuple[str, ...]) -> str:
    """Return a name for all that the outcome depends on."""
    generator = importlib.util.find_spec("genpy.generator")
    if generator is None or generator.origin is None:
        raise RosUnavailableError(f"ROS 1 needs genpy, which is not here; {SET_UP}")
    files = [Path(generator.origin), Path(generation.__file__)]
    for package in packages:
        files += generation.definition_files(package)
    digest = hashlib.sha256(f"{sys.version_info[:2]} {packages}".encode())
    for file in files:
        digest.update(f"\0{file.name}\0".encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def _for_this_process_alone(packages: tuple[str, ...]) -> Path:
    """Make the packages in a temporary folder that ends with the process."""
    import atexit

    folder = Path(tempfile.mkdtemp(prefix="tool0-ros1-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    generation.generate(packages, folder)
    return folder
