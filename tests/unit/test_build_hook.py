"""What the build hook puts into wheels and sdists; the page is not rebuilt here."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import hatch_build
import pytest
from kernel_sources import require_compiler, without_compilers
from machine import add_program

ROOT = Path(hatch_build.__file__).parent
LIBRARY = "tool0/kernel/_kernel.so"
PROGRAM = """\
import sys
sys.path.insert(0, sys.argv[1])
from tool0.kernel.library import kernel_status
print(kernel_status().path, kernel_status().reason, sep="\\n")
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of what the hook reads, with a stale library in it."""
    folder = tmp_path_factory.mktemp("project")
    for name in ("pyproject.toml", "hatch_build.py", ".gitignore", "README.md"):
        shutil.copy(ROOT / name, folder)
    shutil.copy(ROOT / "LICENSE", folder)
    (folder / "tools").mkdir()
    shutil.copy(ROOT / "tools/web.py", folder / "tools")
    source, target = ROOT / "src/tool0", folder / "src/tool0"
    shutil.copytree(source / "kernel", target / "kernel")
    for name in ("__init__.py", "errors.py"):
        shutil.copy(source / name, target)
    (target / "kernel/_kernel.so").write_bytes(b"stale")
    return folder


def make(
    project: Path, target: str, folder: Path, **variables: str
) -> tuple[Path, str]:
    """Build, and return the file and what was said."""
    done = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(folder)],
        capture_output=True,
        text=True,
        check=False,
        cwd=project,
        env={**os.environ, "TOOL0_SKIP_PANEL": "1", **variables},
    )
    assert done.returncode == 0, done.stderr
    (made,) = folder.iterdir()
    return made, done.stderr


@pytest.mark.slow
def test_a_wheel_has_the_kernel_for_every_python(project: Path, tmp_path: Path) -> None:
    require_compiler()
    wheel, said = make(project, "wheel", tmp_path / "dist")
    assert "cannot compile" not in said
    assert "-py3-none-" in wheel.name
    assert not wheel.stem.endswith("-any")
    if sys.platform == "linux":
        assert re.search(r"-py3-none-manylinux_2_\d+_\w+\.whl$", wheel.name)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index"]
    target = tmp_path / "installed"
    subprocess.run([*pip, "--target", str(target), str(wheel)], check=True)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(target)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "TOOL0_KERNEL": ""},
    )
    assert done.stdout.splitlines() == [str(target / LIBRARY), ""]


@pytest.mark.parametrize("skip", [False, True])
def test_without_a_kernel_the_wheel_is_of_any_machine(
    project: Path, tmp_path: Path, *, skip: bool
) -> None:
    fake = add_program(tmp_path / "bin/cc", "echo no licence >&2; exit 1")
    variables = {"CC": str(fake), "TOOL0_SKIP_KERNEL": "1" if skip else "0"}
    wheel, said = make(project, "wheel", tmp_path / "dist", **variables)
    assert wheel.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as file:
        assert LIBRARY not in file.namelist()
        assert "tool0/kernel/version.c" in file.namelist()
    assert ("cannot compile the kernel" in said) is not skip
    if not skip:
        assert "no licence" in said
        assert "everything works without it, more slowly" in said


@pytest.mark.parametrize(
    ("platform", "symbols", "tag"),
    [
        (
            "linux-x86_64",
            b"GLIBC_2.2.5\0GLIBC_2.34\0GLIBC_2.4",
            "manylinux_2_34_x86_64",
        ),
        ("linux-aarch64", b"GLIBC_2.17\0", "manylinux_2_17_aarch64"),
        ("linux-x86_64", b"musl has no versions", "linux_x86_64"),
        ("macosx-11.0-arm64", b"", "macosx_11_0_arm64"),
    ],
)
def test_a_wheel_names_the_glibc_that_it_needs(
    platform: str,
    symbols: bytes,
    tag: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sysconfig.get_platform", lambda: platform)
    library = tmp_path / "_kernel.so"
    library.write_bytes(symbols)
    assert hatch_build.platform_tag(library) == tag


def test_the_metadata_has_the_licences_of_the_page(
    project: Path, tmp_path: Path
) -> None:
    texts = project / hatch_build.LICENCES_OF_PAGE
    texts.parent.mkdir(parents=True)
    texts.write_text("# Licenses\n", encoding="utf-8")
    variables = {"TOOL0_SKIP_KERNEL": "1"}
    wheel, _ = make(project, "wheel", tmp_path / "dist", **variables)
    with zipfile.ZipFile(wheel) as file:
        (name,) = (name for name in file.namelist() if name.endswith("/METADATA"))
        metadata = file.read(name).decode()
        folder = name.removesuffix("METADATA")
        assert f"{folder}licenses/{hatch_build.LICENCES_OF_PAGE}" in file.namelist()
    assert f"License-File: {hatch_build.LICENCES_OF_PAGE}\n" in metadata
    assert "License-Expression: Apache-2.0 AND MIT\n" in metadata
    shutil.rmtree(texts.parent)


def test_an_sdist_has_the_sources_only(project: Path, tmp_path: Path) -> None:
    sdist, _ = make(project, "sdist", tmp_path / "dist", CC="/no/such/compiler")
    with tarfile.open(sdist) as file:
        names = [name.partition("/src/")[2] for name in file.getnames()]
    assert "tool0/kernel/version.c" in names
    assert LIBRARY not in names


def test_a_compiler_is_required_only_where_there_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    works = require_compiler()
    needed = hatch_build._needed_by_kernel
    assert needed("wheel") == []
    without_compilers(monkeypatch, path=tmp_path)
    (requirement,) = needed("wheel")
    assert requirement.startswith("ziglang>=")
    assert needed("sdist") == []
    monkeypatch.setenv("TOOL0_SKIP_KERNEL", "1")
    assert needed("wheel") == []
    monkeypatch.delenv("TOOL0_SKIP_KERNEL")
    monkeypatch.setenv("CC", works[0])
    assert needed("wheel") == []
