"""Installs and removes a private Gazebo 11.

The packages are downloaded, verified, unpacked and checked before the new prefix
replaces an existing prefix.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Final

from tool0.errors import ConfigError, EngineUnavailableError
from tool0.installation.apt import ProgressCallback
from tool0.installation.child_process import last_lines, run_program
from tool0.installation.gazebo.debian import (
    FOR_GUI,
    FROM_HOST,
    HEADERS,
    PROGRAMS,
    TRIPLETS,
    PrivateApt,
    machine_mirrors,
    unpack,
)
from tool0.installation.gazebo.installation import (
    GazeboInstallation,
    find_system,
    from_prefix,
    mark_complete,
    private_prefix,
)
from tool0.installation.gazebo.plugin import (
    bridge_libraries,
    plugin_folder,
    require_compiler,
)
from tool0.installation.own_folder import exclusive, removed, size_on_disk
from tool0.user_data import expanded

KEYRING: Final = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
_UNPACKED: Final = 3.6
"""Measured ratio of bytes on disk to downloaded bytes.  A download of 258 MB becomes
907 MB on disk."""


def install_gazebo(
    progress: ProgressCallback,
    *,
    has_client: bool = False,
    is_private: bool = False,
    mirror: str | None = None,
    keyring: Path = KEYRING,
) -> GazeboInstallation:
    """Return a Gazebo that is ready to run and has a compiled plugin.

    The result is the system's Gazebo or the private Gazebo.  The private Gazebo is
    installed if necessary.

    Args:
        progress: Function that is called during the installation.
        has_client: Whether to install gzclient and a rendering driver.
        is_private: Whether to ignore the system's Gazebo.
        mirror: Address of a Debian mirror; None for the mirrors that the machine's apt
            uses.
        keyring: The keys with which Debian 11 must be signed.

    Raises:
        ConfigError: If an argument is invalid.
        EngineUnavailableError: If Gazebo cannot be installed.  The message contains the
            reason and the remedy.
    """
    if mirror is not None and ("://" not in mirror or len(mirror.split()) != 1):
        raise ConfigError(
            f"a mirror is an address such as http://host/debian, not '{mirror}'"
        )
    if len(str(keyring).split()) != 1:
        raise ConfigError(
            f"apt accepts no keyring with a space in its path: '{keyring}'"
        )
    require_compiler()  # check this before the long download
    installation = None if is_private else find_system()
    if installation is None:
        prefix = private_prefix()
        with exclusive(prefix.parent, "Gazebo", EngineUnavailableError):
            installation = from_prefix(prefix)
            if installation is None or (has_client and not installation.client):
                keyring = expanded(keyring).absolute()
                apt = _usable_apt(prefix.with_name("work"), mirror, keyring, progress)
                installation = _make_prefix(prefix, apt, has_client, progress)
    progress("compiling the bridge to Gazebo", 0.0)
    bridge_libraries(installation)
    progress("compiling the bridge to Gazebo", 1.0)
    return installation


def uninstall_gazebo() -> int:
    """Remove the private prefix, downloads and libraries.

    Returns:
        The freed disk space [bytes].
    """
    folders = (private_prefix().parent, plugin_folder())
    return sum(removed(one, "Gazebo", EngineUnavailableError) for one in folders)


def _usable_apt(
    work: Path, mirror: str | None, keyring: Path, progress: ProgressCallback
) -> PrivateApt:
    """Return an apt in ``work`` for the first mirror that has the release."""
    if not keyring.is_file():
        raise EngineUnavailableError(
            f"Debian's keys are missing ('{keyring}'); install them (apt "
            "install debian-archive-keyring), or pass others: --keyring FILE"
        )
    if shutil.which("apt-get") is None or shutil.which("dpkg-deb") is None:
        raise EngineUnavailableError(
            "installing a private Gazebo needs apt-get and dpkg-deb, "
            "which this machine does not have; install Gazebo 11 another way, with "
            "gzserver on the PATH and its headers"
        )
    architecture = run_program(["dpkg", "--print-architecture"]).stdout.strip()
    if architecture not in TRIPLETS:
        raise EngineUnavailableError(
            f"a private Gazebo is available on {' and '.join(TRIPLETS)}, not on "
            f"{architecture}"
        )
    mirrors = machine_mirrors() if mirror is None else [mirror]
    progress("reading the list of packages", 0.0)
    failures = []
    for address in mirrors:
        try:
            apt = PrivateApt(work, address, keyring, architecture)
        except EngineUnavailableError as error:
            failures.append(error)
        else:
            progress("reading the list of packages", 1.0)
            return apt
    if failures:
        # the failure of the first mirror, which was the most likely to work
        raise failures[0]
    raise EngineUnavailableError(
        "this machine's apt has no Debian mirror; pass one: --mirror URL"
    )


def _make_prefix(
    prefix: Path, apt: PrivateApt, has_client: bool, progress: ProgressCallback
) -> GazeboInstallation:
    """Create the prefix, and replace an existing prefix.

    The downloads of an interrupted run are reused.  These downloads are in the folder
    ``work`` next to the prefix.
    """
    files = _download(apt, has_client, progress)
    work = prefix.with_name("work")
    staging = work / "prefix"
    shutil.rmtree(staging, ignore_errors=True)
    staging.mkdir()
    unpack(files, staging, progress)
    _relocate(staging, prefix)
    mark_complete(
        staging,
        triplet=TRIPLETS[apt.architecture],
        has_client=has_client,
        size=size_on_disk(staging),
    )
    _check_that_it_runs(staging)
    if prefix.exists():
        prefix.rename(work / "replaced")
    staging.rename(prefix)
    shutil.rmtree(work)
    installation = from_prefix(prefix)
    assert installation is not None  # the installation has just been run
    return installation


def _download(
    apt: PrivateApt, has_client: bool, progress: ProgressCallback
) -> list[Path]:
    """Return the complete, verified files of all packages, with the largest first."""
    installed = FROM_HOST if has_client else (*FROM_HOST, *FOR_GUI)
    names = [*apt.closure(PROGRAMS, installed), *HEADERS]
    packages = sorted(apt.files(names), key=lambda package: -package.size)
    total = sum(package.size for package in packages)
    for package in packages:  # apt accepts any file of the right size
        if package.is_damaged_in(apt.downloads):
            (apt.downloads / package.file).unlink()

    def downloaded() -> int:
        return sum(package.size_in(apt.downloads) for package in packages)

    def show() -> None:
        progress(f"downloading {total / 1e6:.0f} MB", downloaded() / total)

    needed = total - downloaded() + _UNPACKED * total
    free = shutil.disk_usage(apt.downloads).free
    if free < needed:
        raise EngineUnavailableError(
            f"the disk of '{apt.downloads}' has {free / 1e9:.1f} GB free, and Gazebo "
            f"needs {needed / 1e9:.1f} GB while it is installed"
        )
    show()
    apt.download(names, while_running=show)
    show()
    return [apt.downloads / package.file for package in packages]


def _relocate(root: Path, final: Path) -> None:
    """Add the fonts in the folder ``final`` to the font paths in ``root``."""
    fonts = root / "etc" / "fonts" / "fonts.conf"
    if fonts.is_file():
        text = fonts.read_text(encoding="utf-8")
        system = "<dir>/usr/share/fonts</dir>"
        own = f"<dir>{final}/usr/share/fonts</dir>"
        fonts.write_text(text.replace(system, f"{system}\n\t{own}"), encoding="utf-8")


def _check_that_it_runs(prefix: Path) -> None:
    made = from_prefix(prefix)
    assert made is not None  # the marker has just been written
    answer = run_program(
        [str(made.server), "--version"],
        # Gazebo writes into HOME even if it only prints its version.
        environment={**os.environ, **made.environment, "HOME": str(prefix.parent)},
    )
    if made.version not in answer.stdout:
        raise EngineUnavailableError(
            f"Debian 11's Gazebo does not run on this machine (gzserver ended with "
            f"{answer.returncode}):\n{last_lines(answer.stderr or answer.stdout)}"
        )
