"""``tool0 gazebo install``: a private Gazebo 11 from Debian 11's packages."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.engines.gazebo.apt import Package, PrivateApt, is_whole
from tool0.engines.gazebo.host_tools import last_lines, run_host
from tool0.engines.gazebo.installation import (
    Installation,
    from_prefix,
    private_prefix,
)
from tool0.engines.gazebo.mirrors import machine_mirrors
from tool0.engines.gazebo.packages import (
    FOR_GUI,
    FROM_HOST,
    HEADERS,
    PROGRAMS,
    TRIPLETS,
)
from tool0.engines.gazebo.prefix import Marker, header_version, write_marker
from tool0.engines.gazebo.unpack import make_links_relative, size_on_disk, unpack
from tool0.errors import ConfigError, EngineUnavailableError
from tool0.user_data import locked

KEYRING: Final = Path("/usr/share/keyrings/debian-archive-keyring.gpg")

Report = Callable[[str, float], None]
"""Told what is going on, and how much of it is done, from 0 to 1."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Wish:
    """What a person wants installed, and from where."""

    has_client: bool = False
    """Whether gzclient and a driver to draw with shall run, too."""
    mirror: str | None = None
    """Address of a Debian mirror; None for those of the machine's apt."""
    keyring: Path = KEYRING
    """The keys by which Debian 11 must be signed."""

    def __post_init__(self) -> None:
        if self.mirror is not None and (
            "://" not in self.mirror or len(self.mirror.split()) != 1
        ):
            raise ConfigError(
                f"a mirror is an address such as http://host/debian, not "
                f"'{self.mirror}'"
            )
        if len(str(self.keyring).split()) != 1:
            raise ConfigError(
                f"apt takes no keyring with a space in its path: '{self.keyring}'"
            )


def install(wish: Wish, report: Report) -> Installation:
    """Make the private prefix, in place of the one that may be there, and return it.

    What an interrupted try had downloaded is used.

    Raises:
        EngineUnavailableError: If it cannot be made, with the reason and the remedy.
    """
    architecture = _architecture()
    keyring = wish.keyring.expanduser().absolute()
    if not keyring.is_file():
        raise EngineUnavailableError(
            f"the keys that sign Debian are not here ('{keyring}'); install them (apt "
            "install debian-archive-keyring), or name others: --keyring FILE"
        )
    prefix = private_prefix()
    with _alone(prefix.parent):
        work = prefix.parent / "work"
        files = _download(wish, keyring, architecture, work, report)
        staging = work / "prefix"
        shutil.rmtree(staging, ignore_errors=True)
        staging.mkdir()
        _unpack(files, staging, report)
        marker = _finish(staging, prefix, TRIPLETS[architecture], wish.has_client)
        _put_in_place(staging, prefix)
        made = from_prefix(prefix)
        assert made is not None  # its marker has just been written
        _check_that_it_runs(made, marker)
        shutil.rmtree(work)
    return made


def uninstall() -> int:
    """Remove the private prefix and what an interrupted try left; return its bytes."""
    folder = private_prefix().parent
    if not folder.is_dir():
        return 0
    with _alone(folder):
        size = size_on_disk(folder)
        shutil.rmtree(folder)
    return size


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder / "lock", wait=False):
            yield
    except BlockingIOError:
        raise EngineUnavailableError(
            f"another process is installing Gazebo in '{folder}'; wait until it ends"
        ) from None
    except OSError as error:
        raise EngineUnavailableError(
            f"cannot write in '{error.filename or folder}': {error.strerror}"
        ) from None


def _architecture() -> str:
    """Return what apt calls this machine, if Debian 11 has a Gazebo for it."""
    if shutil.which("apt-get") is None or shutil.which("dpkg-deb") is None:
        raise EngineUnavailableError(
            "a private Gazebo is made of Debian's packages by apt-get and dpkg-deb, "
            "which this machine does not have; install Gazebo 11 by other means, "
            "gzserver on the PATH and its headers beside it"
        )
    architecture = run_host(["dpkg", "--print-architecture"]).stdout.strip()
    if architecture not in TRIPLETS:
        raise EngineUnavailableError(
            f"a private Gazebo can be had on {' and '.join(TRIPLETS)}, not on "
            f"{architecture}"
        )
    return architecture


def _download(
    wish: Wish, keyring: Path, architecture: str, work: Path, report: Report
) -> list[Path]:
    """Return the files of all packages, whole and genuine, the largest first."""
    mirrors = [wish.mirror] if wish.mirror is not None else machine_mirrors()
    if not mirrors:
        raise EngineUnavailableError(
            "this machine's apt names no mirror; name one: --mirror URL"
        )
    apt = _first_that_has_it(mirrors, keyring, architecture, work, report)
    installed = FROM_HOST if wish.has_client else (*FROM_HOST, *FOR_GUI)
    names = [*apt.closure(PROGRAMS, installed), *HEADERS]
    packages = sorted(apt.files(names), key=lambda package: -package.size)
    total = sum(package.size for package in packages)
    _drop_damaged(apt.downloads, packages)

    def show() -> None:
        there = sum(_size(apt.downloads, package) for package in packages)
        report(f"downloading {total / 1e6:.0f} MB", there / total)

    show()
    apt.download(names, while_running=show)
    show()
    return [apt.downloads / package.file for package in packages]


def _first_that_has_it(
    mirrors: list[str], keyring: Path, architecture: str, work: Path, report: Report
) -> PrivateApt:
    failure: EngineUnavailableError | None = None
    for mirror in mirrors:
        report("reading the list of packages", 0.0)
        try:
            apt = PrivateApt(work, mirror, keyring, architecture)
            apt.update(while_running=lambda: None)
        except EngineUnavailableError as error:
            failure = failure or error  # the likeliest mirror's says most
        else:
            report("reading the list of packages", 1.0)
            return apt
    assert failure is not None  # there is a mirror at least
    raise failure


def _drop_damaged(folder: Path, packages: list[Package]) -> None:
    """Remove what an earlier try left damaged: apt trusts a file of the right size."""
    for package in packages:
        file = folder / package.file
        is_there = file.exists() and file.stat().st_size >= package.size
        if is_there and not is_whole(file, package):
            file.unlink()


def _size(folder: Path, package: Package) -> int:
    for file in (folder / package.file, folder / "partial" / package.file):
        try:
            return min(file.stat().st_size, package.size)
        except FileNotFoundError:
            continue
    return 0


def _unpack(files: list[Path], root: Path, report: Report) -> None:
    total = sum(file.stat().st_size for file in files)
    done = 0

    def unpacked(size: int) -> None:
        nonlocal done
        done += size
        report(f"unpacking {len(files)} packages", done / total)

    unpack(files, root, unpacked)


def _finish(root: Path, final: Path, triplet: str, has_client: bool) -> Marker:
    """Make the unpacked folder one that works at the place ``final``."""
    make_links_relative(root)
    fonts = root / "etc" / "fonts" / "fonts.conf"
    if fonts.is_file():
        text = fonts.read_text(encoding="utf-8")
        host = "<dir>/usr/share/fonts</dir>"
        own = f"<dir>{final}/usr/share/fonts</dir>"
        fonts.write_text(text.replace(host, f"{host}\n\t{own}"), encoding="utf-8")
    version = header_version(root / "usr")
    if version is None:
        raise EngineUnavailableError(
            f"what was unpacked in '{root}' has no header of Gazebo 11 in it"
        )
    marker = Marker(
        version=version,
        triplet=triplet,
        has_client=has_client,
        size=size_on_disk(root),
    )
    write_marker(root, marker)
    return marker


def _put_in_place(staging: Path, prefix: Path) -> None:
    old = staging.with_name("replaced")
    shutil.rmtree(old, ignore_errors=True)
    if prefix.exists():
        prefix.rename(old)
    staging.rename(prefix)
    shutil.rmtree(old, ignore_errors=True)


def _check_that_it_runs(made: Installation, marker: Marker) -> None:
    answer = subprocess.run(
        [str(made.server), "--version"],
        env={**os.environ, **made.environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if marker.version not in answer.stdout:
        raise EngineUnavailableError(
            f"the installed Gazebo does not run here ('{made.server}' ended with "
            f"{answer.returncode}):\n{last_lines(answer.stderr or answer.stdout)}"
        )
