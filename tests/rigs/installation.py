"""tool0 as ``pip install`` leaves it: a wheel, and what it requires, and nothing else.

The required packages are those of the Python that runs the tests, by links.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from email import message_from_bytes
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]


def build_wheel(folder: Path) -> Path:
    """Build a wheel of the checkout, with the page that is there, in a new folder."""
    project = folder / "project"
    project.mkdir(parents=True)
    for name in ("pyproject.toml", "hatch_build.py", ".gitignore", "README.md"):
        shutil.copy(ROOT / name, project)
    shutil.copy(ROOT / "LICENSE", project)
    (project / "tools").mkdir()
    shutil.copy(ROOT / "tools/web.py", project / "tools")
    shutil.copytree(
        ROOT / "src", project / "src", ignore=shutil.ignore_patterns("__pycache__")
    )
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=project,
        env={**os.environ, "TOOL0_SKIP_PANEL": "1"},
        check=True,
        capture_output=True,
    )
    shutil.rmtree(project)
    (wheel,) = folder.glob("*.whl")
    return wheel


@dataclass(frozen=True)
class Installation:
    """A virtual environment with tool0."""

    folder: Path

    def run(
        self, *words: str, cwd: Path, **variables: str
    ) -> subprocess.CompletedProcess[str]:
        """Run a program of it to its end."""
        program = str(self.folder / "bin" / words[0])
        return subprocess.run(
            [program, *words[1:]],
            cwd=cwd,
            env=_environment() | variables,
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )


def install(wheel: Path, folder: Path, extra: str | None = None) -> Installation:
    """Install a wheel, with an extra, into a new virtual environment.

    Raises:
        PackageNotFoundError: If this Python lacks what it requires.
    """
    needed = {name: found for name, found in _required(wheel, extra)}
    venv.create(folder, symlinks=True, with_pip=False)
    (packages,) = folder.glob("lib/python*/site-packages")
    for found in needed.values():
        for top in {file.parts[0] for file in found.files or ()} - {"..", "bin"}:
            link = packages / top
            source = Path(str(found.locate_file(top)))
            if not link.exists() and source.exists():
                link.symlink_to(source)
    pip = [sys.executable, "-m", "pip", "--python", str(folder / "bin/python")]
    quiet = ["--disable-pip-version-check", "--quiet"]
    offline = ["--no-deps", "--no-index", "--no-compile"]
    for words in (["install", *quiet, *offline, str(wheel)], ["check", *quiet]):
        done = subprocess.run(
            [*pip, *words], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    return Installation(folder)


def extras_of(wheel: Path) -> list[str]:
    """Return the extras that a wheel has."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        return message_from_bytes(archive.read(name)).get_all("Provides-Extra", [])


def _required(wheel: Path, extra: str | None) -> Iterator[tuple[str, Distribution]]:
    """Yield every distribution that has to be installed before the wheel."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        metadata = message_from_bytes(archive.read(name))
    own = [Requirement(line) for line in metadata.get_all("Requires-Dist", [])]
    waiting = [(each, {extra or ""}) for each in own]
    seen: set[tuple[str, str]] = set()
    while waiting:
        requirement, extras = waiting.pop()
        environments: list[Mapping[str, str]] = [{"extra": e} for e in extras | {""}]
        marker = requirement.marker
        if marker and not any(marker.evaluate(dict(e)) for e in environments):
            continue
        if requirement.name == "tool0":
            waiting += [(each, requirement.extras) for each in own]
            continue
        key = (requirement.name, ",".join(sorted(requirement.extras)))
        if key in seen:
            continue
        seen.add(key)
        found = distribution(requirement.name)
        assert requirement.specifier.contains(found.version, prereleases=True), key
        yield requirement.name, found
        waiting += [
            (Requirement(line), requirement.extras) for line in found.requires or ()
        ]


def _environment() -> dict[str, str]:
    """Return this process's variables, without what makes it find this checkout."""
    return {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONHOME")
    }


__all__ = [
    "Installation",
    "PackageNotFoundError",
    "build_wheel",
    "extras_of",
    "install",
]
