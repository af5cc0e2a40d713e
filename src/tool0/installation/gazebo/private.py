"""Making a private prefix: download, verify, unpack, check, put in place."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Final

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.apt import Package, PrivateApt, is_whole
from tool0.installation.gazebo.host_tools import last_lines, run_host, tied
from tool0.installation.gazebo.installation import Installation, from_prefix
from tool0.installation.gazebo.mirrors import machine_mirrors
from tool0.installation.gazebo.packages import (
    FOR_GUI,
    FROM_HOST,
    HEADERS,
    PROGRAMS,
    TRIPLETS,
)
from tool0.installation.gazebo.prefix import Marker, header_version, write_marker
from tool0.installation.gazebo.unpack import make_links_relative, size_on_disk, unpack

Report = Callable[[str, float], None]
"""Told what is going on, and how much of it is done, from 0 to 1."""

_UNPACKED: Final = 3.6
"""Bytes on disk of a byte downloaded, measured: 258 MB become 907 MB."""


def make_prefix(
    prefix: Path,
    *,
    has_client: bool,
    mirror: str | None,
    keyring: Path,
    report: Report,
) -> Installation:
    """Make the prefix, in place of the one that may be there.

    What an interrupted try had downloaded, in ``work`` beside it, is used.

    Args:
        prefix: The folder to make.
        has_client: Whether gzclient shall run.
        mirror: Address of a Debian mirror; None for those of the machine's apt.
        keyring: The keys by which Debian 11 must be signed.
        report: Told how far it is.

    Raises:
        EngineUnavailableError: If it cannot be made, with the reason and the remedy.
    """
    if not keyring.is_file():
        raise EngineUnavailableError(
            f"the keys that sign Debian are not here ('{keyring}'); install them (apt "
            "install debian-archive-keyring), or name others: --keyring FILE"
        )
    architecture = _architecture()
    work = prefix.with_name("work")
    mirrors = [mirror] if mirror is not None else machine_mirrors()
    apt = _first_that_has_it(mirrors, keyring, architecture, work, report)
    files = _download(apt, has_client, report)
    staging = work / "prefix"
    shutil.rmtree(staging, ignore_errors=True)
    staging.mkdir()
    _unpack(files, staging, report)
    _finish(staging, prefix, TRIPLETS[architecture], has_client)
    _check_that_it_runs(staging)
    if prefix.exists():
        prefix.rename(work / "replaced")
    staging.rename(prefix)
    shutil.rmtree(work)
    made = from_prefix(prefix)
    assert made is not None  # it has just run
    return made


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


def _download(apt: PrivateApt, has_client: bool, report: Report) -> list[Path]:
    """Return the files of all packages, whole and genuine, the largest first."""
    installed = FROM_HOST if has_client else (*FROM_HOST, *FOR_GUI)
    names = [*apt.closure(PROGRAMS, installed), *HEADERS]
    packages = sorted(apt.files(names), key=lambda package: -package.size)
    total = sum(package.size for package in packages)
    _drop_damaged(apt.downloads, packages)

    def there() -> int:
        return sum(_size(apt.downloads, package) for package in packages)

    def show() -> None:
        report(f"downloading {total / 1e6:.0f} MB", there() / total)

    _check_space(apt.downloads, total - there() + _UNPACKED * total)
    show()
    apt.download(names, while_running=show)
    show()
    return [apt.downloads / package.file for package in packages]


def _check_space(folder: Path, needed: float) -> None:
    free = shutil.disk_usage(folder).free
    if free < needed:
        raise EngineUnavailableError(
            f"the disk of '{folder}' has {free / 1e9:.1f} GB free, and Gazebo needs "
            f"{needed / 1e9:.1f} GB while it is installed"
        )


def _first_that_has_it(
    mirrors: list[str], keyring: Path, architecture: str, work: Path, report: Report
) -> PrivateApt:
    failure = EngineUnavailableError(
        "this machine's apt names no Debian mirror; name one: --mirror URL"
    )
    is_first = True
    for mirror in mirrors:
        report("reading the list of packages", 0.0)
        try:
            apt = PrivateApt(work, mirror, keyring, architecture)
            apt.update(while_running=lambda: None)
        except EngineUnavailableError as error:
            failure = error if is_first else failure  # the likeliest mirror's error
            is_first = False
        else:
            report("reading the list of packages", 1.0)
            return apt
    raise failure


def _drop_damaged(folder: Path, packages: list[Package]) -> None:
    """Remove what an earlier try left damaged: apt trusts a file of the right size."""
    for package in packages:
        file = folder / package.file
        is_there = file.exists() and file.stat().st_size >= package.size
        if is_there and not is_whole(file, package):
            file.unlink()


def _size(folder: Path, package: Package) -> int:
    try:
        return min((folder / package.file).stat().st_size, package.size)
    except FileNotFoundError:
        return 0


def _unpack(files: list[Path], root: Path, report: Report) -> None:
    total = sum(file.stat().st_size for file in files)
    done = 0

    def unpacked(size: int) -> None:
        nonlocal done
        done += size
        report(f"unpacking {len(files)} packages", done / total)

    unpack(files, root, unpacked)


def _finish(root: Path, final: Path, triplet: str, has_client: bool) -> None:
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


def _check_that_it_runs(prefix: Path) -> None:
    made = from_prefix(prefix)
    assert made is not None  # its marker has just been written
    answer = subprocess.run(
        tied([str(made.server), "--version"]),
        # Gazebo writes into HOME even then.
        env={**os.environ, **made.environment, "HOME": str(prefix.parent)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if made.version not in answer.stdout:
        raise EngineUnavailableError(
            f"Debian 11's Gazebo does not run on this machine (gzserver ended with "
            f"{answer.returncode}):\n{last_lines(answer.stderr or answer.stdout)}"
        )
