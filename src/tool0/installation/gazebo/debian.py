"""Downloads and unpacks packages of Debian 11 for a private Gazebo.

apt runs as an ordinary user, with its own sources, lists and status.  apt verifies
Debian's signature and every hash, and never changes the packages of the machine.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import EngineUnavailableError
from tool0.installation.apt import ProgressCallback, explain_failure
from tool0.installation.child_process import last_lines, run_program

RELEASE: Final = "bullseye"
"""Debian 11, which is the last release that contains Gazebo 11."""

TRIPLETS: Final = {"amd64": "x86_64-linux-gnu", "arm64": "aarch64-linux-gnu"}
"""Folder of an architecture's libraries, by the architecture's name in apt."""

PROGRAMS: Final = ("gazebo", "gazebo-plugin-base")
"""Packages that are installed with all their dependencies, except dependencies in
``FROM_HOST``."""

FROM_HOST: Final = (
    # The host's newer libraries must be used, because code that the host's g++ compiles
    # needs them.
    *("libc6", "libgcc-s1", "libgcc1", "libstdc++6", "libcrypt1"),
    # Programs and scripts of the base system that the simulator never calls.
    *("coreutils", "debconf", "dpkg", "lsb-base", "mariadb-common", "mysql-common"),
    *("perl-base", "sensible-utils", "shared-mime-info", "tar", "ucf", "x11-common"),
)
"""Packages that are treated as installed. apt omits them and their dependencies."""

FOR_GUI: Final = (
    *("libgl1-mesa-dri", "libgvc6", "libspnav0"),
    *("libqt5core5a", "libqt5dbus5", "libqt5gui5", "libqt5network5", "libqt5opengl5"),
    *("libqt5svg5", "libqt5widgets5", "libqtpropertybrowser4", "libqwt-qt5-6"),
)
"""Packages that only gzclient loads, and the rendering driver for gzserver and
gzclient."""

HEADERS: Final = (
    *("libboost1.74-dev", "libgazebo-dev", "libprotobuf-dev", "libsdformat-dev"),
    *("libignition-common-dev", "libignition-math-dev", "libignition-msgs-dev"),
    *("libignition-transport-dev", "libtbb-dev", "libtinyxml-dev", "libtinyxml2-dev"),
    "uuid-dev",
)
"""Packages with headers.  These packages are installed without their dependencies,
because only their headers are needed to compile a plugin."""

DROPPED: Final = (
    *("./usr/share/bug", "./usr/share/doc", "./usr/share/icons"),
    *("./usr/share/lintian", "./usr/share/locale", "./usr/share/man"),
    "./usr/lib/*.a",
)
"""Parts of packages that are not unpacked, as patterns for tar."""

_EXPLANATIONS: Final = {
    "disk full": (
        "the disk is full; free some space (a GUI needs 1 GB), then run it again"
    ),
    "unreachable": (
        "the mirror {mirror} cannot be reached: check the network, or set the proxy "
        "in http_proxy or apt.conf. Another mirror: --mirror URL"
    ),
    "unsigned": (
        "the release file of {mirror} is not signed by a key of {keyring}; upgrade "
        "debian-archive-keyring, or pass other keys: --keyring FILE"
    ),
    "wrong content": (
        "the files of {mirror} differ from those that Debian signed; try again "
        "later, or use another mirror: --mirror URL"
    ),
    "no package": (
        "the mirror {mirror} has no Debian 11 (bullseye); pass one that has, such as "
        "an archive of old releases: --mirror URL"
    ),
}
_CONFIGURATION: Final = """\
#clear APT::Architectures;
#clear APT::Default-Release;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Stats;
#clear APT::Update::Post-Invoke-Success;
#clear APT::Update::Pre-Invoke;
#clear AptCli::Hooks;
#clear DPkg::Post-Invoke;
#clear DPkg::Pre-Install-Pkgs;
#clear DPkg::Pre-Invoke;
APT::Architecture "{architecture}";
APT::Architectures:: "{architecture}";
APT::Install-Recommends "false";
APT::Install-Suggests "false";
APT::Update::Error-Mode "any";
Acquire::Languages "none";
Acquire::Retries "3";
Dir::Cache "{folder}/cache";
Dir::Cache::pkgcache "";
Dir::Cache::srcpkgcache "";
Dir::Etc::preferences "/dev/null";
Dir::Etc::preferencesparts "/dev/null";
Dir::Etc::sourcelist "{folder}/sources.list";
Dir::Etc::sourceparts "/dev/null";
Dir::State "{folder}";
Dir::State::lists "{folder}/lists";
Dir::State::status "{folder}/status";
Dir::State::extended_states "{folder}/extended_states";
"""
"""Configuration of apt. apt reads it after the machine's own configuration, so that the
machine's proxies apply.

The machine's hooks, preferences and other architectures do not apply.  The hooks would
notify other programs.
"""
_AS_ROOT: Final = 'APT::Sandbox::User "root";\n'
"""Setting for apt when apt runs as root.  Without this setting, apt downloads as a user
who cannot write to this folder."""
_HOST_PACKAGE: Final = """\
Package: {name}
Status: install ok installed
Version: 99:0
Architecture: {architecture}
Multi-Arch: foreign
Maintainer: none
Description: provided by the host

"""
_PACKAGE: Final = re.compile(r"^'[^']*' (\S+) (\d+) (?:SHA256:([0-9a-f]{64}))?", re.M)
_INDEX: Final = re.compile(
    r"^'((?:https?|file|ftp|mirror[^:]*):\S*?)/dists/\S*/main/binary-", re.MULTILINE
)


# --- download ---


@final
@dataclass(frozen=True, slots=True)
class DebianPackage:
    """One file to download."""

    file: str
    """Name of the file in apt's format: ``name_version_architecture.deb``."""
    size: int
    """Size of the file [bytes]."""
    sha256: str
    """SHA-256 hash as a hexadecimal number; empty if the index does not contain it."""

    def size_in(self, folder: Path) -> int:
        """Return the number of bytes of the file that are already in the folder."""
        try:
            return min((folder / self.file).stat().st_size, self.size)
        except FileNotFoundError:
            return 0

    def is_damaged_in(self, folder: Path) -> bool:
        """Return whether a file in the folder has the right size but a wrong hash."""
        if self.size_in(folder) < self.size or not self.sha256:
            return False
        digest = hashlib.sha256()
        with (folder / self.file).open("rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
        return digest.hexdigest() != self.sha256


@final
class PrivateApt:
    """apt-get with its own configuration and its own folder."""

    def __init__(self, folder: Path, mirror: str, keyring: Path, architecture: str):
        """Write the configuration, and fetch the signed list of packages.

        Args:
            folder: Folder for apt.  The folder is created if necessary, and existing
                lists and downloads in the folder are reused.
            mirror: Address of a Debian mirror.
            keyring: The keys with which the release must be signed.
            architecture: Architecture in Debian's notation.

        Raises:
            EngineUnavailableError: If the list cannot be fetched, or if it is not
                signed.
        """
        self._folder, self._mirror, self._keyring = folder, mirror, keyring
        self.architecture = architecture
        self.downloads = folder / "debs"
        for part in ("lists/partial", "cache/archives/partial", "debs"):
            (folder / part).mkdir(parents=True, exist_ok=True)
        (folder / "sources.list").write_text(
            f"deb [arch={architecture} signed-by={keyring}] {mirror} {RELEASE} main\n",
            encoding="utf-8",
        )
        text = _CONFIGURATION.format(folder=folder, architecture=architecture)
        text += _AS_ROOT if os.geteuid() == 0 else ""
        (folder / "apt.conf").write_text(text, encoding="utf-8")
        self._run(["update"])

    def closure(self, wanted: Sequence[str], installed: Iterable[str]) -> list[str]:
        """Return the names of the packages that must be installed for ``wanted``.

        Args:
            wanted: Packages that must be usable after the installation.
            installed: Packages that are treated as installed.
        """
        text = "".join(
            _HOST_PACKAGE.format(name=name, architecture=self.architecture)
            for name in installed
        )
        (self._folder / "status").write_text(text, encoding="utf-8")
        output = self._run(["install", "--yes", "--print-uris", *wanted])
        return [item.file.split("_")[0] for item in listed_packages(output)]

    def files(self, names: Sequence[str]) -> list[DebianPackage]:
        """Return the files of packages, without the packages' dependencies."""
        return listed_packages(self._run(["download", "--print-uris", *names]))

    def download(self, names: Sequence[str], while_running: Callable[[], None]) -> None:
        """Download the packages' files, except files that have the right size.

        Raises:
            EngineUnavailableError: If a file is not available, or if its hash is wrong.
        """
        self._run(["download", *names], while_running, self.downloads)

    def _run(
        self,
        arguments: Sequence[str],
        while_running: Callable[[], None] | None = None,
        folder: Path | None = None,
    ) -> str:
        configuration = str(self._folder / "apt.conf")
        answer = run_program(
            ["apt-get", "--config-file", configuration, "-qq", *arguments],
            # In the folder of the downloads, apt would list only files that are missing
            # in this folder.
            folder=folder or self._folder,
            while_running=while_running,
        )
        if answer.returncode != 0:
            names = {"mirror": self._mirror, "keyring": self._keyring}
            reason = explain_failure(
                answer.stderr + answer.stdout,
                {cause: text.format(**names) for cause, text in _EXPLANATIONS.items()},
                otherwise="apt-get failed; run the same command again to resume",
            )
            raise EngineUnavailableError(reason)
        return answer.stdout


def listed_packages(output: str) -> list[DebianPackage]:
    """Return the files that ``apt-get --print-uris`` lists."""
    return [
        DebianPackage(file, int(size), sha256)
        for file, size, sha256 in _PACKAGE.findall(output)
    ]


def machine_mirrors() -> list[str]:
    """Return the mirrors that the machine's apt uses, with Debian's mirrors first."""
    answer = run_program(["apt-get", "update", "--print-uris"])
    found = dict.fromkeys(_INDEX.findall(answer.stdout))
    usable = (uri for uri in found if "security" not in uri)
    return sorted(usable, key=lambda uri: not uri.endswith("/debian"))


# --- unpacking ---

_WORKERS: Final = min(os.cpu_count() or 1, 8)
_UNPACK: Final = """\
set -o pipefail
dpkg-deb --fsys-tarfile "$1" | tar --extract --file=- "${@:2}"
"""
_TAR_OPTIONS: Final = (
    *("--no-same-owner", "--no-same-permissions", "--delay-directory-restore"),
    *(f"--exclude={pattern}" for pattern in DROPPED),
)


def unpack(files: Sequence[Path], root: Path, progress: ProgressCallback) -> None:
    """Unpack packages in parallel into the empty folder ``root``.

    Files that match ``DROPPED`` are not unpacked.  Unpacking is fastest if large
    packages come first in ``files``.

    Raises:
        EngineUnavailableError: If a package cannot be unpacked.
    """
    with ThreadPoolExecutor(_WORKERS) as pool:
        sizes = {pool.submit(_unpack_one, f, root): f.stat().st_size for f in files}
        done = 0
        try:
            for future in as_completed(sizes):
                future.result()
                done += sizes[future]
                progress(f"unpacking {len(files)} packages", done / sum(sizes.values()))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    _make_links_relative(root)


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
    file.unlink(missing_ok=True)  # the next run downloads the file again
    raise EngineUnavailableError(
        f"cannot unpack '{file.name}'; run the same command again to download it once "
        f"more:\n{last_lines(answer.stderr)}"
    )


def _make_links_relative(root: Path) -> None:
    """Make absolute links relative if their targets have been unpacked."""
    for folder, subfolders, files in os.walk(root):
        for link in (Path(folder, name) for name in (*subfolders, *files)):
            target = os.readlink(link) if link.is_symlink() else ""  # noqa: PTH115
            inside = root / target.lstrip("/")
            if target.startswith("/") and inside.exists():
                link.unlink()
                link.symlink_to(os.path.relpath(inside, link.parent))
