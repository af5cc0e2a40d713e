"""Which packages of Debian 11 make a private Gazebo, and unpacking them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Final

from tool0.errors import EngineUnavailableError
from tool0.installation.child_process import last_lines, run_program

RELEASE: Final = "bullseye"
"""Debian 11: the last one with Gazebo 11."""

TRIPLETS: Final = {"amd64": "x86_64-linux-gnu", "arm64": "aarch64-linux-gnu"}
"""Architecture as apt calls it → the folder of its libraries."""

PROGRAMS: Final = ("gazebo", "gazebo-plugin-base")
"""Installed with all that they depend on, except what follows."""

FROM_HOST: Final = (
    # The host's own, newer ones must be used: what its g++ compiles needs them.
    "libc6",
    "libgcc-s1",
    "libgcc1",
    "libstdc++6",
    "libcrypt1",
    # Programs and scripts of the base system, which the simulator never calls.
    "coreutils",
    "debconf",
    "dpkg",
    "lsb-base",
    "mariadb-common",
    "mysql-common",
    "perl-base",
    "sensible-utils",
    "shared-mime-info",
    "tar",
    "ucf",
    "x11-common",
)
"""Considered as installed: apt leaves them out, and what only they need."""

FOR_GUI: Final = (
    "libgl1-mesa-dri",
    "libgvc6",
    "libqt5core5a",
    "libqt5dbus5",
    "libqt5gui5",
    "libqt5network5",
    "libqt5opengl5",
    "libqt5svg5",
    "libqt5widgets5",
    "libqtpropertybrowser4",
    "libqwt-qt5-6",
    "libspnav0",
)
"""What gzclient loads and gzserver does not, and the driver that both draw with."""

HEADERS: Final = (
    "libboost1.74-dev",
    "libgazebo-dev",
    "libignition-common-dev",
    "libignition-math-dev",
    "libignition-msgs-dev",
    "libignition-transport-dev",
    "libprotobuf-dev",
    "libsdformat-dev",
    "libtbb-dev",
    "libtinyxml-dev",
    "libtinyxml2-dev",
    "uuid-dev",
)
"""Without dependencies: a plugin is compiled with headers, and links nothing."""

DROPPED: Final = (
    "./usr/share/bug",
    "./usr/share/doc",
    "./usr/share/icons",
    "./usr/share/lintian",
    "./usr/share/locale",
    "./usr/share/man",
    "./usr/lib/*.a",
)
"""Parts of packages that are not unpacked, as patterns for tar."""

_WORKERS: Final = min(os.cpu_count() or 1, 8)
_UNPACK: Final = """\
set -o pipefail
dpkg-deb --fsys-tarfile "$1" | tar --extract --file=- "${@:2}"
"""
_TAR_OPTIONS: Final = (
    *("--no-same-owner", "--no-same-permissions", "--delay-directory-restore"),
    *(f"--exclude={pattern}" for pattern in DROPPED),
)


def unpack(files: Iterable[Path], root: Path, unpacked: Callable[[int], None]) -> None:
    """Unpack packages into ``root``, several at once, without what ``DROPPED`` names.

    Args:
        files: The packages; large ones first are quickest.
        root: An empty folder.
        unpacked: Called with the bytes of each package that is done.

    Raises:
        EngineUnavailableError: If one cannot be unpacked.
    """
    with ThreadPoolExecutor(_WORKERS) as pool:
        running = {pool.submit(_unpack_one, file, root): file for file in files}
        try:
            for done in as_completed(running):
                done.result()
                unpacked(running[done].stat().st_size)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _unpack_one(file: Path, root: Path) -> None:
    options = (f"--directory={root}", *_TAR_OPTIONS)
    answer = run_program(["bash", "-c", _UNPACK, "unpack", str(file), *options])
    if answer.returncode == 0:
        return
    if "No space left" in answer.stderr:
        raise EngineUnavailableError(
            f"the disk of '{root}' is full; a Gazebo with GUI needs 1 GB while it is "
            "installed. Free some space, then run it again"
        )
    file.unlink(missing_ok=True)  # so that the next run downloads it again
    raise EngineUnavailableError(
        f"cannot unpack '{file.name}'; run the same command again to download it once "
        f"more:\n{last_lines(answer.stderr)}"
    )


def make_links_relative(root: Path) -> None:
    """Make absolute links refer to what was unpacked, where that has their target."""
    for folder, subfolders, files in os.walk(root):
        for name in (*subfolders, *files):
            link = Path(folder, name)
            if not link.is_symlink():
                continue
            target = os.readlink(link)  # noqa: PTH115  # a Path would drop "./"
            inside = root / target.lstrip("/")
            if target.startswith("/") and inside.exists():
                link.unlink()
                link.symlink_to(os.path.relpath(inside, link.parent))


def size_on_disk(root: Path) -> int:
    """Return the bytes that a folder takes; a file with several names counts once."""
    sizes: dict[int, int] = {}
    for folder, subfolders, files in os.walk(root):
        for name in (*subfolders, *files):
            status = Path(folder, name).lstat()
            sizes[status.st_ino] = status.st_blocks * 512
    return sum(sizes.values())
