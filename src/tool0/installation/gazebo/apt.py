"""A private apt: its own sources, lists and status, the host's proxies and settings.

apt itself verifies Debian's signature and every hash, as an ordinary user, and never
touches what the machine has installed.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.installation.gazebo.apt_failures import explained
from tool0.installation.gazebo.host_tools import run_host
from tool0.installation.gazebo.packages import RELEASE

_PACKAGE: Final = re.compile(r"^'[^']*' (\S+) (\d+) (?:SHA256:([0-9a-f]{64}))?", re.M)


@final
@dataclass(frozen=True, slots=True)
class Package:
    """One file to download."""

    file: str
    """Its name, as apt writes it: ``name_version_architecture.deb``."""
    size: int
    """Bytes."""
    sha256: str
    """Of its content, in hexadecimal; empty if the index does not state it."""


@final
class PrivateApt:
    """apt-get with a configuration of its own, in a folder of its own."""

    def __init__(self, folder: Path, mirror: str, keyring: Path, architecture: str):
        """Write the configuration.

        Args:
            folder: Made if it is not there; lists and downloads from before are used.
            mirror: Address of a Debian mirror.
            keyring: The keys by which the release must be signed.
            architecture: As Debian calls it.
        """
        self._folder, self._mirror, self._keyring = folder, mirror, keyring
        self._architecture = architecture
        self._configuration = folder / "apt.conf"
        self._status = folder / "status"
        self.downloads = folder / "debs"
        for part in ("lists/partial", "cache/archives/partial", "debs"):
            (folder / part).mkdir(parents=True, exist_ok=True)
        (folder / "sources.list").write_text(
            f"deb [arch={architecture} signed-by={keyring}] {mirror} {RELEASE} main\n",
            encoding="utf-8",
        )
        text = _configuration(folder, architecture)
        self._configuration.write_text(text, encoding="utf-8")

    def update(self, while_running: Callable[[], None]) -> None:
        """Fetch the list of packages, signed.

        Raises:
            EngineUnavailableError: If it cannot be fetched or is not signed.
        """
        self._get(["update"], while_running)

    def closure(self, wanted: Sequence[str], installed: Iterable[str]) -> list[str]:
        """Return the packages to add for ``wanted``, by name.

        Args:
            wanted: Packages that shall run.
            installed: Packages to take for installed.
        """
        self._status.write_text(
            "".join(
                f"Package: {name}\nStatus: install ok installed\nVersion: 99:0\n"
                f"Architecture: {self._architecture}\nMulti-Arch: foreign\n"
                "Maintainer: none\nDescription: the host's\n\n"
                for name in installed
            ),
            encoding="utf-8",
        )
        answer = self._get(["install", "--yes", "--print-uris", *wanted])
        return [item.file.split("_")[0] for item in listed(answer)]

    def files(self, names: Sequence[str]) -> list[Package]:
        """Return the files of these packages, without those that they depend on."""
        return listed(self._get(["download", "--print-uris", *names]))

    def download(self, names: Sequence[str], while_running: Callable[[], None]) -> None:
        """Download the files of these packages, but for those of the right size.

        Raises:
            EngineUnavailableError: If one cannot be had, or has a wrong hash.
        """
        self._get(["download", *names], while_running, self.downloads)

    def _get(
        self,
        words: Sequence[str],
        while_running: Callable[[], None] | None = None,
        folder: Path | None = None,
    ) -> str:
        command = ["apt-get", "--config-file", str(self._configuration), "-qq", *words]
        # Not where the downloads are: apt lists only what is not there.
        answer = run_host(
            command, folder=folder or self._folder, while_running=while_running
        )
        if answer.returncode != 0:
            said = answer.stderr + answer.stdout
            raise explained(said, self._mirror, self._keyring)
        return answer.stdout


def listed(text: str) -> list[Package]:
    """Return the files that ``apt-get --print-uris`` lists."""
    return [
        Package(file, int(size), sha256)
        for file, size, sha256 in _PACKAGE.findall(text)
    ]


def is_whole(file: Path, package: Package) -> bool:
    """Return whether the file is there, all of it, with the right content."""
    if not file.is_file() or file.stat().st_size != package.size:
        return False
    with file.open("rb") as handle:
        digest = hashlib.sha256()
        while block := handle.read(1 << 20):
            digest.update(block)
    return package.sha256 in ("", digest.hexdigest())


def _configuration(folder: Path, architecture: str) -> str:
    """Return the settings, which are read after the machine's own.

    So its proxies hold; its hooks, which would tell other programs of packages that
    are none of theirs, its preferences and its other architectures do not.
    """
    settings = {
        "APT::Architecture": architecture,
        "APT::Install-Recommends": "false",
        "APT::Install-Suggests": "false",
        "APT::Update::Error-Mode": "any",
        "Acquire::Languages": "none",
        "Acquire::Retries": "3",
        "Dir::Cache": f"{folder}/cache",
        "Dir::Cache::pkgcache": "",
        "Dir::Cache::srcpkgcache": "",
        "Dir::Etc::preferences": "/dev/null",
        "Dir::Etc::preferencesparts": "/dev/null",
        "Dir::Etc::sourcelist": f"{folder}/sources.list",
        "Dir::Etc::sourceparts": "/dev/null",
        "Dir::State": str(folder),
        "Dir::State::lists": f"{folder}/lists",
        "Dir::State::status": f"{folder}/status",
        "Dir::State::extended_states": f"{folder}/extended_states",
    }
    if os.geteuid() == 0:  # or apt downloads as a user who may not write here
        settings["APT::Sandbox::User"] = "root"
    cleared = (
        "APT::Architectures",
        "APT::Default-Release",
        "APT::Update::Post-Invoke",
        "APT::Update::Post-Invoke-Stats",
        "APT::Update::Post-Invoke-Success",
        "APT::Update::Pre-Invoke",
        "AptCli::Hooks",
        "DPkg::Post-Invoke",
        "DPkg::Pre-Install-Pkgs",
        "DPkg::Pre-Invoke",
    )
    return "".join(
        [
            *(f"#clear {name};\n" for name in cleared),
            f'APT::Architectures {{ "{architecture}"; }};\n',
            *(f'{name} "{value}";\n' for name, value in settings.items()),
        ]
    )
