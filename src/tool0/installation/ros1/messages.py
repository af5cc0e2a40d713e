"""Makes the message classes importable that the ROS interface uses.

``control_msgs``, ``controller_manager_msgs`` and ``gazebo_msgs`` are taken as they are
installed; a missing package is generated from our definitions once, into the cache.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path

from tool0.errors import RosUnavailableError
from tool0.installation.ros1 import generation
from tool0.installation.ros1.library import SET_UP, import_ros
from tool0.user_data import cache_folder, locked

_CLASSES_OF_SECTIONS = {
    ".msg": ("",),
    ".srv": ("Request", "Response"),
    ".action": ("Goal", "Result", "Feedback"),
}
"""What the names of the classes of a file's sections end in."""
_FIELD = re.compile(r"^\S+ (\w+)$", re.MULTILINE)
"""A line of our definitions that is no constant."""
_SHELL_VARIABLES = ("PYTHONPATH", "ROS_PACKAGE_PATH")


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
            _check_installed(package)
    if not absent:
        return
    try:
        folder = generated_packages(absent)
    except OSError as error:
        folder = _temporary_packages(absent, error)
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
    return Path(entry).parent == _cache()


def _cache() -> Path:
    return cache_folder() / "ros1"


def generated_packages(packages: tuple[str, ...]) -> Path:
    """Return the folder that holds these packages, made if it is not there.

    It is an entry for both PYTHONPATH and ROS_PACKAGE_PATH.

    Raises:
        RosUnavailableError: If genpy cannot make them.
        OSError: If it is not there and the cache cannot be written.
    """
    folder = _cache() / _key(packages)
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


def _temporary_packages(packages: tuple[str, ...], cause: OSError) -> Path:
    """Make the packages in a temporary folder that ends with the process."""
    import atexit

    try:
        folder = Path(tempfile.mkdtemp(prefix="tool0-ros1-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        generation.generate(packages, folder)
    except OSError as error:
        raise RosUnavailableError(
            f"the classes of {', '.join(packages)} can be written neither to the cache "
            f"({cause}) nor to a temporary folder ({error}); XDG_CACHE_HOME and TMPDIR "
            "name others"
        ) from None
    return folder


# --- a package that is installed ---


def _check_installed(package: str) -> None:
    """Raise RosUnavailableError unless it is ROS 1's, with all our types and fields."""
    for file in generation.definition_files(package):
        module = f"{package}.{'srv' if file.suffix == '.srv' else 'msg'}"
        for name, fields in _classes(file):
            found = _slots(module, name)
            if missing := [field for field in fields if field not in found]:
                raise _mismatch(module, f"{name} has no field {missing[0]}")


def _classes(file: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the name and the fields of each class that the file defines."""
    sections = generation.SECTIONS.split(file.read_text(encoding="utf-8"))
    for ending, text in zip(_CLASSES_OF_SECTIONS[file.suffix], sections, strict=True):
        yield f"{file.stem}{ending}", _FIELD.findall(text)


def _slots(module: str, name: str) -> list[str]:
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError):
        raise _mismatch(module, f"{name} is not in it") from None
    if not hasattr(found, "_md5sum"):
        raise _mismatch(module, f"{name} is not of ROS 1")
    slots: list[str] = found.__slots__
    return slots


def _mismatch(module: str, reason: str) -> RosUnavailableError:
    package = module.partition(".")[0]
    where = getattr(import_module(package), "__file__", None)
    return RosUnavailableError(
        f"the installed {package} does not fit, {reason} ({where}); install Noetic's, "
        "or take that folder off PYTHONPATH, and tool0 makes its own"
    )


# --- the shell ---


def shell_exports() -> list[str]:
    """Return lines for a POSIX shell; none where every message is installed.

    They append to the current values of the variables, once.

    Raises:
        RosUnavailableError: If there is no rospy, or the cache cannot be written.
    """
    import_ros()
    absent = absent_packages()
    if not absent:
        return []
    try:
        folder = generated_packages(absent)
    except OSError as error:
        raise RosUnavailableError(
            f"cannot write the cache: {error}; XDG_CACHE_HOME names another folder"
        ) from None
    return [
        f"export {name}={_with_folder(name, str(folder))}" for name in _SHELL_VARIABLES
    ]


def _with_folder(variable: str, folder: str) -> str:
    entries = os.environ.get(variable, "").split(os.pathsep)
    kept = [entry for entry in entries if entry and not is_generated(entry)]
    return shlex.quote(os.pathsep.join([*kept, folder]))
