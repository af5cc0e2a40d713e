"""Gets a Gazebo 11 ready to run, and removes it.

A private prefix is downloaded, verified, unpacked, checked, and then put in place.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import ConfigError, EngineUnavailableError
from tool0.installation.apt import ProgressCallback
from tool0.installation.child_process import last_lines, run_program
from tool0.installation.gazebo.installation import (
    GazeboInstallation,
    PrefixMarker,
    find_system,
    from_prefix,
    header_version,
    private_prefix,
    write_marker,
)
from tool0.installation.gazebo.packages import (
    FOR_GUI,
    FROM_HOST,
    HEADERS,
    PROGRAMS,
    TRIPLETS,
    make_links_relative,
    size_on_disk,
    unpack,
)
from tool0.installation.gazebo.plugin import (
    bridge_libraries,
    plugin_folder,
    require_compiler,
)
from tool0.installation.gazebo.private_apt import PrivateApt, machine_mirrors
from tool0.user_data import locked

KEYRING: Final = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
_UNPACKED: Final = 3.6
"""Bytes on disk of a byte downloaded, measured: 258 MB become 907 MB."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GazeboOptions:
    """Which Gazebo to install, and from where."""

    has_client: bool = False
    """Whether gzclient and a driver to draw with shall run, too."""
    is_private: bool = False
    """Whether to ignore the system's own Gazebo."""
    mirror: str | None = None
    """Address of a Debian mirror; None for those of the machine's apt."""
    keyring: Path = KEYRING
    """The keys by which Debian 11 must be signed."""

    def __post_init__(self) -> None:
        if self.mirror is not None and (
            "://" not in self.mirror or len(self.mirror.split()) != 1
        ):
            raise ConfigError(
                "a mirror is an address such as http://host/debian, not "
                f"'{self.mirror}'"
            )
        if len(str(self.keyring).split()) != 1:
            raise ConfigError(
                f"apt accepts no keyring with a space in its path: '{self.keyring}'"
            )


def install_gazebo(
    options: GazeboOptions, progress: ProgressCallback
) -> GazeboInstallation:
    """Return a Gazebo that is ready to run, with what we load into it compiled.

    That is the system's, the private one if it exists, or one that is made now.

    Raises:
        EngineUnavailableError: If there can be none, with the reason and the remedy.
    """
    require_compiler()  # before a long download, not after it
    system = None if options.is_private else find_system()
    installation = system or _private(options, progress)
    progress("compiling the bridge to Gazebo", 0.0)
    bridge_libraries(installation)
    progress("compiling the bridge to Gazebo", 1.0)
    return installation


def uninstall_gazebo() -> int:
    """Remove the private prefix, downloads and compiled libraries; return the bytes."""
    freed = 0
    for folder in (private_prefix().parent, plugin_folder()):
        if folder.is_dir():
            with _exclusive(folder):
                freed += size_on_disk(folder)
                shutil.rmtree(folder)
    return freed


@contextmanager
def _exclusive(folder: Path) -> Iterator[None]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder / "lock", wait=False):
            yield
    except BlockingIOError:
        raise EngineUnavailableError(
            f"another process installs or removes Gazebo in '{folder}'; wait for it"
        ) from None
    except OSError as error:
        raise EngineUnavailableError(
            f"cannot write '{error.filename or folder}': {error.strerror}"
        ) from None


def _private(options: GazeboOptions, progress: ProgressCallback) -> GazeboInstallation:
    prefix = private_prefix()
    with _exclusive(prefix.parent):
        present = from_prefix(prefix)
        if present is not None and (present.client or not options.has_client):
            return present
        return _make_prefix(prefix, options, progress)


def _make_prefix(
    prefix: Path, options: GazeboOptions, progress: ProgressCallback
) -> GazeboInstallation:
    """Make the prefix, and replace the one that may exist.

    What an interrupted run downloaded, in ``work`` beside it, is used.
    """
    keyring = options.keyring.expanduser().absolute()
    if not keyring.is_file():
        raise EngineUnavailableError(
            f"the keys that sign Debian are not here ('{keyring}'); install them (apt "
            "install debian-archive-keyring), or name others: --keyring FILE"
        )
    architecture = _architecture()
    work = prefix.with_name("work")
    mirrors = machine_mirrors() if options.mirror is None else [options.mirror]
    progress("reading the list of packages", 0.0)
    apt = _first_usable(mirrors, keyring, architecture, work)
    progress("reading the list of packages", 1.0)
    files = _download(apt, options.has_client, progress)
    staging = work / "prefix"
    shutil.rmtree(staging, ignore_errors=True)
    staging.mkdir()
    _unpack(files, staging, progress)
    _relocate(staging, prefix)
    _mark(staging, TRIPLETS[architecture], options.has_client)
    _check_that_it_runs(staging)
    if prefix.exists():
        prefix.rename(work / "replaced")
    staging.rename(prefix)
    shutil.rmtree(work)
    installation = from_prefix(prefix)
    assert installation is not None  # it has just run
    return installation


def _architecture() -> str:
    """Return what apt calls this machine, if Debian 11 has a Gazebo for it."""
    if shutil.which("apt-get") is None or shutil.which("dpkg-deb") is None:
        raise EngineUnavailableError(
            "a private Gazebo is made of Debian's packages by apt-get and dpkg-deb, "
            "which this machine does not have; install Gazebo 11 by other means, "
            "gzserver on the PATH and its headers beside it"
        )
    architecture = run_program(["dpkg", "--print-architecture"]).stdout.strip()
    if architecture not in TRIPLETS:
        raise EngineUnavailableError(
            f"a private Gazebo is available on {' and '.join(TRIPLETS)}, not on "
            f"{architecture}"
        )
    return architecture


def _first_usable(
    mirrors: list[str], keyring: Path, architecture: str, work: Path
) -> PrivateApt:
    """Return an apt of the first mirror that has the release."""
    failures = []
    for mirror in mirrors:
        try:
            apt = PrivateApt(work, mirror, keyring, architecture)
            apt.update()
        except EngineUnavailableError as error:
            failures.append(error)
        else:
            return apt
    if failures:
        raise failures[0]  # of the likeliest mirror
    raise EngineUnavailableError(
        "this machine's apt names no Debian mirror; name one: --mirror URL"
    )


def _download(
    apt: PrivateApt, has_client: bool, progress: ProgressCallback
) -> list[Path]:
    """Return the files of all packages, complete and verified, the largest first."""
    installed = FROM_HOST if has_client else (*FROM_HOST, *FOR_GUI)
    names = [*apt.closure(PROGRAMS, installed), *HEADERS]
    packages = sorted(apt.files(names), key=lambda package: -package.size)
    total = sum(package.size for package in packages)
    for package in packages:  # apt trusts a file of the right size
        file = apt.downloads / package.file
        is_partial = not file.exists() or file.stat().st_size < package.size
        if not is_partial and not package.is_complete_in(apt.downloads):
            file.unlink()

    def downloaded() -> int:
        return sum(package.size_in(apt.downloads) for package in packages)

    def show() -> None:
        progress(f"downloading {total / 1e6:.0f} MB", downloaded() / total)

    _check_space(apt.downloads, total - downloaded() + _UNPACKED * total)
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


def _unpack(files: list[Path], root: Path, progress: ProgressCallback) -> None:
    total = sum(file.stat().st_size for file in files)
    done = 0

    def unpacked(size: int) -> None:
        nonlocal done
        done += size
        progress(f"unpacking {len(files)} packages", done / total)

    unpack(files, root, unpacked)
    make_links_relative(root)


def _relocate(root: Path, final: Path) -> None:
    """Make what was unpacked in ``root`` find its fonts at the place ``final``."""
    fonts = root / "etc" / "fonts" / "fonts.conf"
    if fonts.is_file():
        text = fonts.read_text(encoding="utf-8")
        system = "<dir>/usr/share/fonts</dir>"
        own = f"<dir>{final}/usr/share/fonts</dir>"
        fonts.write_text(text.replace(system, f"{system}\n\t{own}"), encoding="utf-8")


def _mark(root: Path, triplet: str, has_client: bool) -> None:
    version = header_version(root / "usr")
    if version is None:
        raise EngineUnavailableError(f"'{root}' has no header of Gazebo 11")
    marker = PrefixMarker(
        version=version,
        triplet=triplet,
        has_client=has_client,
        size=size_on_disk(root),
    )
    write_marker(root, marker)


def _check_that_it_runs(prefix: Path) -> None:
    made = from_prefix(prefix)
    assert made is not None  # its marker has just been written
    answer = run_program(
        [str(made.server), "--version"],
        # Gazebo writes into HOME even then.
        environment={**os.environ, **made.environment, "HOME": str(prefix.parent)},
    )
    if made.version not in answer.stdout:
        raise EngineUnavailableError(
            f"Debian 11's Gazebo does not run on this machine (gzserver ended with "
            f"{answer.returncode}):\n{last_lines(answer.stderr or answer.stdout)}"
        )
