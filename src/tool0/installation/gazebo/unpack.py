"""From downloaded packages to a folder that programs run from."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.host_tools import last_lines, tied
from tool0.installation.gazebo.packages import DROPPED

_WORKERS = min(os.cpu_count() or 1, 8)


def unpack(files: Iterable[Path], root: Path, unpacked: Callable[[int], None]) -> None:
    """Unpack packages into ``root``, some at once, without what a simulator ignores.

    Args:
        files: The packages; the large ones first make it quickest.
        root: An empty folder.
        unpacked: Told the bytes of each package that is done.

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
    tar = [
        *("tar", "--extract", "--file=-", f"--directory={root}"),
        *("--no-same-owner", "--no-same-permissions", "--delay-directory-restore"),
        *(f"--exclude={pattern}" for pattern in DROPPED),
    ]
    with (
        subprocess.Popen(
            tied(["dpkg-deb", "--fsys-tarfile", str(file)]),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        ) as reader,
        subprocess.Popen(
            tied(tar),
            stdin=reader.stdout,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        ) as writer,
    ):
        assert reader.stdout is not None  # asked for above
        assert reader.stderr is not None
        reader.stdout.close()  # the writer has it; it must end if the writer does
        _, wrote = writer.communicate()
        read = reader.stderr.read()
    if reader.returncode != 0 or writer.returncode != 0:
        said = (wrote + read).decode(errors="replace")
        if "No space left" in said:
            raise EngineUnavailableError(
                f"the disk of '{root}' is full; a Gazebo with GUI needs 1 GB while it "
                "is installed. Free some space, then run it again"
            )
        file.unlink(missing_ok=True)  # so that the next try downloads it again
        raise EngineUnavailableError(
            f"cannot unpack '{file.name}'; run it again to download it once more:\n"
            f"{last_lines(said)}"
        )


def make_links_relative(root: Path) -> None:
    """Let absolute links lead to what was unpacked, where that has their target."""
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
    """Return the bytes that a folder takes; a file of several names counts once."""
    sizes: dict[int, int] = {}
    for folder, subfolders, files in os.walk(root):
        for name in (*subfolders, *files):
            status = Path(folder, name).lstat()
            sizes[status.st_ino] = status.st_blocks * 512
    return sum(sizes.values())
