"""A private apt with its own sources, lists and status, and the machine's proxies.

apt itself verifies Debian's signature and every hash, as an ordinary user, and never
touches what the machine has installed.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import EngineUnavailableError
from tool0.installation.apt import FailureCause, explain_failure
from tool0.installation.child_process import last_lines, run_program
from tool0.installation.gazebo.packages import RELEASE

_PACKAGE: Final = re.compile(r"^'[^']*' (\S+) (\d+) (?:SHA256:([0-9a-f]{64}))?", re.M)
_SOURCE_LINE: Final = re.compile(
    r"^\s*deb\s+(?:\[[^\]]*\]\s*)?(\S+)\s+\S+\s+(.*)$", re.MULTILINE
)
_SCHEMES: Final = ("http:", "https:", "file:", "ftp:", "mirror")
_EXPLANATIONS: Final[dict[FailureCause, str]] = {
    "disk full": (
        "the disk is full; free some space (a GUI needs 1 GB), then run it again"
    ),
    "unreachable": (
        "the mirror {mirror} cannot be reached: is there a network, or a proxy to be "
        "set in http_proxy or apt.conf? Another mirror: --mirror URL"
    ),
    "unsigned": (
        "the release file of {mirror} is not signed by a key of {keyring}; upgrade "
        "debian-archive-keyring, or name other keys: --keyring FILE"
    ),
    "wrong content": (
        "{mirror} provides other files than Debian signed; try again later, or "
        "another mirror: --mirror URL"
    ),
    "no package": (
        "the mirror {mirror} has no Debian 11 (bullseye); name one that has, such as "
        "an archive of old releases: --mirror URL"
    ),
}


@final
@dataclass(frozen=True, slots=True)
class DebianPackage:
    """One file to download."""

    file: str
    """Its name, as apt writes it: ``name_version_architecture.deb``."""
    size: int
    """Bytes."""
    sha256: str
    """Of its content, in hexadecimal; empty if the index does not state it."""

    def size_in(self, folder: Path) -> int:
        """Return the bytes of it that the folder has."""
        try:
            return min((folder / self.file).stat().st_size, self.size)
        except FileNotFoundError:
            return 0

    def is_complete_in(self, folder: Path) -> bool:
        """Return whether the folder has all of it, with the right content."""
        file = folder / self.file
        if not file.is_file() or file.stat().st_size != self.size:
            return False
        with file.open("rb") as stream:
            digest = hashlib.sha256()
            while block := stream.read(1 << 20):
                digest.update(block)
        return self.sha256 in ("", digest.hexdigest())


@final
class PrivateApt:
    """apt-get with a configuration of its own, in a folder of its own."""

    def __init__(self, folder: Path, mirror: str, keyring: Path, architecture: str):
        """Write the configuration.

        Args:
            folder: Made if it does not exist; lists and downloads in it are reused.
            mirror: Address of a Debian mirror.
            keyring: The keys by which the release must be signed.
            architecture: As Debian calls it.
        """
        self._folder, self._mirror, self._keyring = folder, mirror, keyring
        self._architecture = architecture
        self._configuration = folder / "apt.conf"
        self.downloads = folder / "debs"
        for part in ("lists/partial", "cache/archives/partial", "debs"):
            (folder / part).mkdir(parents=True, exist_ok=True)
        (folder / "sources.list").write_text(
            f"deb [arch={architecture} signed-by={keyring}] {mirror} {RELEASE} main\n",
            encoding="utf-8",
        )
        text = _configuration(folder, architecture)
        self._configuration.write_text(text, encoding="utf-8")

    def update(self) -> None:
        """Fetch the list of packages, signed.

        Raises:
            EngineUnavailableError: If it cannot be fetched or is not signed.
        """
        self._run(["update"])

    def closure(self, wanted: Sequence[str], installed: Iterable[str]) -> list[str]:
        """Return the names of the packages to add for ``wanted``.

        Args:
            wanted: Packages that shall run.
            installed: Packages to consider as installed.
        """
        (self._folder / "status").write_text(
            "".join(
                f"Package: {name}\nStatus: install ok installed\nVersion: 99:0\n"
                f"Architecture: {self._architecture}\nMulti-Arch: foreign\n"
                "Maintainer: none\nDescription: the host's\n\n"
                for name in installed
            ),
            encoding="utf-8",
        )
        output = self._run(["install", "--yes", "--print-uris", *wanted])
        return [item.file.split("_")[0] for item in listed_packages(output)]

    def files(self, names: Sequence[str]) -> list[DebianPackage]:
        """Return the files of these packages, without their dependencies."""
        return listed_packages(self._run(["download", "--print-uris", *names]))

    def download(self, names: Sequence[str], while_running: Callable[[], None]) -> None:
        """Download the files of these packages, except those of the right size.

        Raises:
            EngineUnavailableError: If one is not available, or has a wrong hash.
        """
        self._run(["download", *names], while_running, self.downloads)

    def _run(
        self,
        arguments: Sequence[str],
        while_running: Callable[[], None] | None = None,
        folder: Path | None = None,
    ) -> str:
        answer = run_program(
            ["apt-get", "--config-file", str(self._configuration), "-qq", *arguments],
            # Not where the downloads are: apt lists only files that are not there.
            folder=folder or self._folder,
            while_running=while_running,
        )
        if answer.returncode != 0:
            output = answer.stderr + answer.stdout
            raise download_failure(output, self._mirror, self._keyring)
        return answer.stdout


def listed_packages(output: str) -> list[DebianPackage]:
    """Return the files that ``apt-get --print-uris`` lists."""
    return [
        DebianPackage(file, int(size), sha256)
        for file, size, sha256 in _PACKAGE.findall(output)
    ]


def download_failure(output: str, mirror: str, keyring: Path) -> EngineUnavailableError:
    """Return the error that says what went wrong, and the remedy.

    Args:
        output: All that apt printed.
        mirror: The mirror that it used.
        keyring: The keys that it trusted.
    """
    text = explain_failure(output, _EXPLANATIONS)
    text = text or "apt-get failed; run the same command again to resume"
    text = text.format(mirror=mirror, keyring=keyring)
    return EngineUnavailableError(f"{text}. apt printed:\n{last_lines(output)}")


def _configuration(folder: Path, architecture: str) -> str:
    """Return the settings, which are read after the machine's own.

    So the machine's proxies apply.  Its hooks, which would inform other programs of
    packages that are not theirs, its preferences and other architectures do not.
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


# --- the mirrors of the machine's own apt ---


def machine_mirrors() -> list[str]:
    """Return those that may have Debian, the likeliest first; perhaps none."""
    row = "$(REPO_URI)|$(ORIGIN)|$(COMPONENT)"
    answer = run_program(
        ["apt-get", "indextargets", "--format", row, "Created-By: Packages"]
    )
    rows = [line.split("|") for line in answer.stdout.splitlines()]
    found = [(uri, origin) for uri, origin, part in rows if part == "main"]
    if not found:  # apt's lists or files are damaged
        found = [(uri, "") for uri in mirrors_in_files(Path("/etc/apt"))]
    return likeliest_first(found)


def likeliest_first(found: list[tuple[str, str]]) -> list[str]:
    """Return the addresses once each: Debian's own first, no security archive.

    Args:
        found: Addresses, each with the origin that its index states, if it is known.
    """

    def rank(item: tuple[str, str]) -> tuple[bool, bool]:
        uri, origin = item
        return origin != "Debian", not uri.rstrip("/").endswith("/debian")

    usable = [
        (uri.rstrip("/"), origin)
        for uri, origin in found
        if uri.startswith(_SCHEMES) and "security" not in uri
    ]
    return list(dict.fromkeys(uri for uri, _ in sorted(usable, key=rank)))


def mirrors_in_files(folder: Path) -> list[str]:
    """Return the addresses in apt's own files, of sources with a component ``main``."""
    parts = folder / "sources.list.d"
    found: list[str] = []
    for file in (folder / "sources.list", *sorted(parts.glob("*.list"))):
        for uri, components in _SOURCE_LINE.findall(_text(file)):
            found += [uri] if "main" in components.split() else []
    for file in sorted(parts.glob("*.sources")):
        for fields in _stanzas(_text(file)):
            is_enabled = fields.get("enabled", "yes") not in ("no", "false", "0")
            has_programs = "deb" in fields.get("types", "").split()
            has_main = "main" in fields.get("components", "").split()
            if is_enabled and has_programs and has_main:
                found += fields.get("uris", "").split()
    return list(dict.fromkeys(found))


def _stanzas(text: str) -> Iterator[dict[str, str]]:
    """Yield the fields of each paragraph of a deb822 file, names in lower case."""
    fields: dict[str, str] = {}
    name = ""
    for line in [*text.splitlines(), ""]:
        if line.startswith("#"):
            continue
        if not line.strip():
            if fields:
                yield fields
            fields, name = {}, ""
        elif line[0].isspace():
            if name:
                fields[name] += f" {line.strip()}"
        else:
            key, _, value = line.partition(":")
            name = key.strip().lower()
            fields[name] = value.strip()


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
