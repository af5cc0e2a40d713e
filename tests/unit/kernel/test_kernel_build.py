"""The kernel's compilation: compilers that work, fail or are absent."""

from __future__ import annotations

import ctypes
import math
import os
import random
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from kernel_sources import (
    copy_kernel,
    require_compiler,
    without_compilers,
    write_function,
)
from machine import add_program

from tool0.kernel import build as kernel_build
from tool0.kernel.build import (
    FLAGS,
    LIBRARY,
    KernelBuildError,
    KernelUnusableError,
    build,
    find_compiler,
    main,
    open_library,
    source_digest,
)

pytestmark = pytest.mark.slow

LIBM = """\
#include <math.h>
#include "export.h"
TOOL0_EXPORT double sine(double x) { return sin(x); }
TOOL0_EXPORT double both(double x) { return sin(x) * cos(x); }
TOOL0_EXPORT double square(double x) { return pow(x, 2.0); }
TOOL0_EXPORT double root(double x) { return sqrt(x); }
TOOL0_EXPORT double fused(double x) { return x * x - 0.7; }
TOOL0_EXPORT double rounded(double x) { return (x + 1e16) - 1e16; }
"""


@pytest.fixture(autouse=True)
def _compiler() -> None:
    require_compiler()


# --- what is compiled ---


@pytest.mark.slow
def test_the_sources_of_the_kernel_compile_without_a_warning(tmp_path: Path) -> None:
    folder = copy_kernel(tmp_path / "kernel")
    path = build(folder, flags=["-Werror"])
    library = open_library(folder)
    digest = (ctypes.c_char * 100).in_dll(library, "tool0_kernel_digest")
    assert digest.value.decode() == source_digest(folder) == source_digest()
    assert path == folder / LIBRARY


def test_only_what_is_marked_is_exported(tmp_path: Path) -> None:
    folder = write_function(tmp_path, 42)
    build(folder)
    library = open_library(folder)
    assert library.answer() == 42
    with pytest.raises(AttributeError, match="hidden"):
        _ = library.hidden


def test_results_are_those_of_python_to_the_bit(tmp_path: Path) -> None:
    folder = write_function(tmp_path, 0)
    (folder / "libm.c").write_text(LIBM, encoding="ascii")
    build(folder)
    library = open_library(folder)
    expected = {
        "sine": math.sin,
        "both": lambda x: math.sin(x) * math.cos(x),
        "square": lambda x: x**2.0,
        "root": math.sqrt,
        "fused": lambda x: x * x - 0.7,
        "rounded": lambda x: (x + 1e16) - 1e16,
    }
    rng = random.Random(7)
    values = [rng.uniform(0.0, 10.0 ** rng.randint(-3, 4)) for _ in range(3000)]
    for name, function in expected.items():
        compiled = getattr(library, name)
        compiled.restype, compiled.argtypes = ctypes.c_double, [ctypes.c_double]
        assert [compiled(x) for x in values] == [function(x) for x in values], name


def test_the_digest_follows_from_names_texts_and_flags(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_function(tmp_path, 1)
    digests = {source_digest(folder)}
    (folder / "notes.txt").write_text("is no source")
    assert source_digest(folder) in digests
    write_function(folder, 2)
    digests.add(source_digest(folder))
    (folder / "answer.c").rename(folder / "other.c")
    digests.add(source_digest(folder))
    (folder / "new.h").touch()
    digests.add(source_digest(folder))
    monkeypatch.setattr(kernel_build, "FLAGS", (*FLAGS, "-g"))
    digests.add(source_digest(folder))
    assert len(digests) == 5


def test_a_process_keeps_the_library_that_it_uses(tmp_path: Path) -> None:
    folder = write_function(tmp_path, 1)
    path = build(folder)
    used = open_library(folder)
    build(write_function(folder, 2))
    assert used.answer() == 1
    copy = shutil.copy(path, tmp_path / "copy.so")
    assert ctypes.CDLL(str(copy)).answer() == 2


# --- what can go wrong ---


def test_a_broken_source_is_an_error_with_its_line(tmp_path: Path) -> None:
    folder = write_function(tmp_path, 1)
    before = build(folder).read_bytes()
    (folder / "answer.c").write_text("int answer(void)\n{ return missing(); }\n")
    with pytest.raises(KernelBuildError, match=r"(?s)answer\.c:2:.*missing"):
        build(folder)
    assert (folder / LIBRARY).read_bytes() == before
    assert not list(folder.glob(".new-*"))


@pytest.mark.parametrize(
    ("script", "problem"),
    [
        ("echo no licence >&2; exit 1", "no licence"),
        ("exit 3", "exit status 3"),
        ("exit 0", "it makes no file"),
    ],
)
def test_a_failing_compiler_in_cc_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, problem: str
) -> None:
    compiler = add_program(tmp_path / "bin/fake cc", script)
    monkeypatch.setenv("CC", shlex.join([str(compiler), "-m64"]))
    with pytest.raises(KernelBuildError) as raised:
        build(copy_kernel(tmp_path / "kernel"))
    said = str(raised.value)
    assert f"{compiler} -m64` fails: {problem}" in said
    assert said.endswith("correct or unset CC")


@pytest.mark.parametrize("value", ["/no/such/cc", "'gcc", "/"])
def test_a_cc_that_is_no_program_is_an_error(
    monkeypatch: pytest.MonkeyPatch, value: str
) -> None:
    monkeypatch.setenv("CC", value)
    with pytest.raises(KernelBuildError, match="CC"):
        find_compiler()


def test_a_compiler_that_fails_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    works = shlex.join(["exec", *require_compiler()])
    path = sys.exec_prefix + "/bin:/usr/bin:/bin"
    add_program(tmp_path / "bin/cc", "echo 'fatal error: math.h' >&2; exit 1")
    without_compilers(monkeypatch, path=tmp_path / "bin")
    with pytest.raises(KernelBuildError, match=r"(?s)no C compiler works.*math\.h"):
        find_compiler()
    add_program(tmp_path / "bin/clang", f'PATH={path} {works} "$@"')
    assert find_compiler() == ["clang"]
    assert build(write_function(tmp_path, 1)).is_file()


def test_no_compiler_is_an_error_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without_compilers(monkeypatch, path=tmp_path)
    with pytest.raises(
        KernelBuildError, match=r"no C compiler .* pip install 'ziglang"
    ):
        build(copy_kernel(tmp_path / "kernel"))


def test_a_folder_that_cannot_be_written_is_an_error() -> None:
    with pytest.raises(
        KernelBuildError, match=r"cannot write '/proc/self/.* its owner"
    ):
        build(Path("/proc/self"))  # also for root


def test_missing_sources_are_an_error(tmp_path: Path) -> None:
    with pytest.raises(KernelBuildError, match="sources of the kernel are not"):
        build(tmp_path)
    with pytest.raises(KernelUnusableError, match="does not exist"):
        open_library(tmp_path)


# --- the command ---


def run_command(folder: Path, *words: str, cc: str) -> tuple[int, str]:
    """Run it without installed packages, as the hook does before it installs any."""
    done = subprocess.run(
        [sys.executable, "-I", "-S", str(folder / "build.py"), *words],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "CC": cc},
    )
    assert done.stdout == ""
    return done.returncode, done.stderr


@pytest.mark.slow
def test_the_command_compiles_what_is_stale(tmp_path: Path) -> None:
    cc = shlex.join(require_compiler())
    folder = copy_kernel(tmp_path / "kernel")
    path = folder / LIBRARY
    assert run_command(folder, cc=cc) == (0, f"tool0: compiled {path}\n")
    assert run_command(folder, cc=cc) == (0, "")
    path.write_bytes(b"\x7fELF")
    assert run_command(folder, cc=cc) == (0, f"tool0: compiled {path}\n")
    (folder / "version.c").write_text("#error broken\n")
    status, said = run_command(folder, cc=cc)
    assert status == 1
    assert said.startswith("tool0: cannot compile the kernel: ")
    assert "version.c:1:" in said


def test_the_command_tells_its_options(tmp_path: Path) -> None:
    status, said = run_command(copy_kernel(tmp_path / "kernel"), "--clean", cc="cc")
    assert (status, "usage: " in said) == (2, True)


def test_the_command_installs_a_compiler_if_there_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    works = shlex.join(["exec", *require_compiler()])
    folder, programs = write_function(tmp_path / "kernel", 42), tmp_path / "bin"
    python = add_program(tmp_path / "python", "echo no network >&2; exit 1")
    path = "/usr/bin:/bin"
    without_compilers(monkeypatch, path=programs)
    monkeypatch.setattr(sys, "executable", str(python))
    assert main(["--install-compiler"], folder) == 1
    said = capfd.readouterr().err
    assert "no network\n" in said
    assert "pip cannot install 'ziglang" in said
    compiler = add_program(tmp_path / "cc", f'PATH={path} {works} "$@"')
    add_program(python, f"PATH={path}; mkdir {programs}; cp {compiler} {programs}")
    assert main(["--install-compiler"], folder) == 0
    assert open_library(folder).answer() == 42
    python.unlink()
    write_function(folder, 43)
    assert main(["--install-compiler"], folder) == 0
