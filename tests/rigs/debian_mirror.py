"""A Debian mirror of a few tiny packages, signed by a key of its own, in a folder."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tool0.installation.gazebo.debian import FROM_HOST, HEADERS

VERSION = "11.1.0"
CONFIG = f'#define GAZEBO_VERSION_FULL "{VERSION}"\n'
SERVER = f"#!/bin/sh\necho 'Gazebo multi-robot simulator, version {VERSION}'\n"

CAN_BE_MADE = all(map(shutil.which, ("apt-get", "dpkg-deb", "gpg", "gpgconf")))


@dataclass(frozen=True)
class Mirror:
    folder: Path
    keyring: Path

    @property
    def address(self) -> str:
        return f"file://{self.folder}"

    def package(self, name: str) -> Path:
        return next(self.folder.glob(f"pool/{name}_*.deb"))


def make_mirror(folder: Path, *, signed: bool = True) -> Mirror:
    """Return a mirror whose ``gazebo`` is a script and a header."""
    mirror = Mirror(folder / "mirror", folder / "keys.gpg")
    mirror.folder.mkdir()
    programs = {f"usr/bin/gzserver-{VERSION}": SERVER}
    programs[f"usr/bin/gzclient-{VERSION}"] = SERVER
    programs["usr/share/doc/gazebo/copyright"] = "dropped"
    header = {"usr/include/gazebo-11/gazebo/gazebo_config.h": CONFIG}
    needed = ("gazebo-common", *FROM_HOST[:3], "libqt5core5a")
    build_package(mirror.folder, "gazebo", programs, depends=needed)
    for name in ("gazebo-common", "gazebo-plugin-base", "libqt5core5a", *HEADERS):
        own = {f"usr/share/{name}/file": name}
        content = header if name == "libgazebo-dev" else own
        build_package(mirror.folder, name, content)
    _index(mirror.folder, "amd64")
    _index(mirror.folder, "arm64")
    _release(mirror.folder)
    if signed:
        _sign(mirror, folder / "gnupg")
    else:
        mirror.keyring.touch()
    return mirror


def build_package(
    folder: Path, name: str, files: Mapping[str, str], depends: tuple[str, ...] = ()
) -> Path:
    """Return a package of these files, which is in the subfolder ``pool``."""
    root = folder / "build" / name
    control = root / "DEBIAN" / "control"
    control.parent.mkdir(parents=True)
    lines = [f"Package: {name}", "Version: 1:11.1.0-6", "Architecture: all"]
    lines += [f"Depends: {', '.join(depends)}"] if depends else []
    control.write_text(
        "\n".join([*lines, "Maintainer: nobody <nobody@localhost>", "Description: x\n"])
    )
    for path, content in files.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(content)
        (root / path).chmod(0o755)
    package = folder / "pool" / f"{name}_11.1.0-6_all.deb"
    package.parent.mkdir(exist_ok=True)
    command = ["dpkg-deb", "--build", "--root-owner-group", str(root), str(package)]
    subprocess.run(command, check=True, capture_output=True)
    return package


def _index(folder: Path, architecture: str) -> None:
    stanzas = []
    for package in sorted((folder / "pool").iterdir()):
        control = subprocess.run(
            ["dpkg-deb", "--field", str(package)],
            check=True,
            capture_output=True,
            text=True,
        ).stdout.strip()
        content = package.read_bytes()
        stanzas.append(
            f"{control}\nFilename: pool/{package.name}\nSize: {len(content)}\n"
            f"SHA256: {hashlib.sha256(content).hexdigest()}\n"
        )
    index = folder / "dists" / "bullseye" / "main" / f"binary-{architecture}"
    index.mkdir(parents=True)
    (index / "Packages").write_text("\n".join(stanzas))


def _release(folder: Path) -> None:
    dists = folder / "dists" / "bullseye"
    rows = [
        f" {hashlib.sha256(file.read_bytes()).hexdigest()} {file.stat().st_size} "
        f"{file.relative_to(dists)}"
        for file in sorted(dists.rglob("Packages"))
    ]
    text = ["Suite: oldstable", "Codename: bullseye", "Architectures: amd64 arm64"]
    text += ["Components: main", "Date: Sat, 14 Aug 2021 07:42:00 UTC", "SHA256:"]
    (dists / "Release").write_text("\n".join([*text, *rows, ""]))


def _sign(mirror: Mirror, home: Path) -> None:
    home.mkdir(mode=0o700)
    environment = {**os.environ, "GNUPGHOME": str(home)}

    def gpg(*words: str) -> None:
        subprocess.run(
            ["gpg", "--batch", "--quiet", *words],
            check=True,
            capture_output=True,
            env=environment,
        )

    dists = mirror.folder / "dists" / "bullseye"
    try:
        gpg(*("--passphrase", ""), "--quick-generate-key", "tester", "ed25519", "sign")
        gpg("--output", str(mirror.keyring), "--export", "tester")
        gpg("--output", str(dists / "InRelease"), "--clearsign", str(dists / "Release"))
    finally:  # the agent that gpg started
        subprocess.run(["gpgconf", "--kill", "all"], check=True, env=environment)
