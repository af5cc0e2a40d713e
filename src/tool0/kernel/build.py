"""Compile the C sources in this folder into a library, if it is out of date.

usage: python -m tool0.kernel.build [--install-compiler]

The library is written to the same folder.  If CC is set, its value is the command of
the compiler.  If CC is not set, the compiler is the first of cc, gcc, clang and ziglang
(`pip install ziglang`) that works.  `--install-compiler` installs ziglang if no
compiler works.  The library does not depend on the version of Python.

`hatch_build.py` loads this file by its path before tool0's requirements are installed.
Therefore this file imports only the standard library.
"""

from __future__ import annotations

import ctypes
import os
import sys
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).resolve().parent
LIBRARY: Final = "_kernel.so"
ZIG: Final = "ziglang>=0.13,<0.18"
"""Requirement of a Python package that contains a C compiler, for machines without a
compiler."""

FLAGS: Final = (
    *("-std=c11", "-O2", "-fPIC", "-shared", "-pthread", "-fvisibility=hidden"),
    # The results must be identical to those of Python.  Operations are executed in the
    # same order, and the same functions of libm are called, without constant folding
    # and without merging of sin and cos into sincos.
    *("-ffp-contract=off", "-fno-fast-math"),
    *("-fno-builtin-sin", "-fno-builtin-cos", "-fno-builtin-pow"),
    *("-Wall", "-Wextra", "-Werror=implicit-function-declaration"),
)
_LIBRARIES: Final = ("-lm",)
_TIMEOUT: Final = 300.0
"""Timeout of one call of a compiler [wall s]."""
_PROBE: Final = """\
#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <string.h>
double probe(double x) { return pthread_self() == 0 ? x : sin(x); }
"""
"""Program with which a compiler is tested.  The program needs headers and libraries
that are missing on some machines."""


class KernelBuildError(Exception):
    """The kernel cannot be compiled; the message states the remedy."""


class KernelUnusableError(Exception):
    """The library is missing, was built from other sources, or cannot be loaded."""


def open_library(folder: Path = FOLDER) -> ctypes.CDLL:
    """Return the library in ``folder``.

    Raises:
        KernelUnusableError: If the library is missing, or was built from other sources
            or for another machine.
    """
    path = folder / LIBRARY
    try:  # the library is not loaded if it was built from other sources
        is_fresh = source_digest(folder).encode() in path.read_bytes()
    except FileNotFoundError:
        raise KernelUnusableError(f"'{path}' does not exist") from None
    except OSError as error:
        raise KernelUnusableError(f"cannot read '{path}': {error.strerror}") from None
    if not is_fresh:
        raise KernelUnusableError(f"'{path}' was compiled from other sources")
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise KernelUnusableError(f"cannot load '{path}': {error}") from None


def source_digest(folder: Path = FOLDER) -> str:
    """Return a digest of the sources and of the compiler flags.

    The digest only detects accidental changes. hashlib is not used, since its import
    would take ten times as long.
    """
    parts = ["\0".join((*FLAGS, *_LIBRARIES)).encode()]
    for path in _sources(folder):
        parts += [path.name.encode(), path.read_bytes()]
    text = b"\0".join(parts)
    return f"tool0-kernel-{zlib.crc32(text):08x}-{len(text)}"


def build(folder: Path = FOLDER, *, flags: Sequence[str] = ()) -> Path:
    """Compile the sources in ``folder``, and return the path of the library.

    A process that uses the previous library can continue to use it.

    Args:
        folder: The folder that contains the sources, and to which the library is
            written.
        flags: Additional compiler flags.

    Raises:
        KernelBuildError: If there is no compiler, if the compilation fails, or if the
            folder is read-only.
    """
    import tempfile

    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix=".new-") as made_in:
            made = Path(made_in) / LIBRARY
            warnings = _compile(_sources(folder), made, source_digest(folder), flags)
            made.replace(folder / LIBRARY)
    except OSError as error:
        raise KernelBuildError(
            f"cannot write '{error.filename or folder}': {error.strerror}; run this as "
            "its owner, or install tool0 into a virtual environment of your own"
        ) from None
    if warnings:
        print(warnings, file=sys.stderr)
    return folder / LIBRARY


def find_compiler() -> list[str]:
    """Return the command of the first C compiler that works.

    Raises:
        KernelBuildError: If no compiler works.  The error states the problems of the
            existing compilers.
    """
    if os.name != "posix":
        raise KernelBuildError("the kernel is not compiled on this operating system")
    problems = []
    for command in _compilers():
        problem = _problem(command)
        if problem is None:
            return command
        problems.append(f"`{' '.join(command)}` fails: {problem}")
    if os.environ.get("CC", "").strip():
        raise KernelBuildError(f"{problems[0]}; correct or unset CC")
    raise KernelBuildError(
        "no C compiler works here; install gcc or clang, or run: "
        f"{sys.executable} -m pip install '{ZIG}'"
        + "".join(f"\n{problem}" for problem in problems)
    )


def _compilers() -> Iterator[list[str]]:
    """Yield the command in CC, or the commands of all existing compilers."""
    import importlib.util
    import platform
    import shlex
    import shutil

    try:
        named = shlex.split(os.environ.get("CC", ""))
    except ValueError as error:
        raise KernelBuildError(f"CC={os.environ['CC']!r}: {error}") from None
    if named:
        yield named
        return
    yield from ([name] for name in ("cc", "gcc", "clang") if shutil.which(name))
    if importlib.util.find_spec("ziglang") is not None:
        machine = platform.machine()
        # Without this option, the target is this machine's processor.
        target = ["-mcpu=baseline"]
        if machine in ("x86_64", "aarch64") and platform.libc_ver()[0] == "glibc":
            target = ["-target", f"{machine}-linux-gnu.2.17"]
        yield [sys.executable, "-m", "ziglang", "cc", *target]


def _problem(command: Sequence[str]) -> str | None:
    """Return the reason why a compiler cannot build a shared library, or None."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "probe.c"
        source.write_text(_PROBE, encoding="ascii")
        library = Path(folder) / "probe.so"
        try:
            _call([*command, *FLAGS, str(source), "-o", str(library), *_LIBRARIES])
        except KernelBuildError as error:
            return str(error)
        return None if library.is_file() else "it makes no file"


def _compile(
    sources: Sequence[Path], library: Path, digest: str, flags: Sequence[str]
) -> str:
    """Compile the library, and return the compiler's warnings."""
    if not sources:
        raise KernelBuildError("the C sources of the kernel are not installed")
    command = find_compiler()
    files = [path.name for path in sources if path.suffix == ".c"]
    output = [f'-DTOOL0_KERNEL_DIGEST="{digest}"', "-o", str(library)]
    try:
        return _call(
            [*command, *FLAGS, *flags, *files, *output, *_LIBRARIES],
            folder=sources[0].parent,
        )
    except KernelBuildError as error:
        raise KernelBuildError(f"`{' '.join(command)}` fails: {error}") from None


def _call(command: Sequence[str], folder: Path | None = None) -> str:
    """Run a compiler, and return its output."""
    import subprocess

    try:
        done = subprocess.run(
            command,
            check=False,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=_TIMEOUT,
        )
    except OSError as error:
        raise KernelBuildError(f"{command[0]}: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise KernelBuildError(f"it does not end within {_TIMEOUT:.0f} s") from None
    said = done.stdout.decode(errors="replace").strip()
    if done.returncode:
        lines = "\n".join(said.splitlines()[-12:])
        raise KernelBuildError(lines or f"exit status {done.returncode}")
    return said


def _sources(folder: Path) -> list[Path]:
    """Return the files from which the library is built, including headers."""
    return sorted(path for path in folder.iterdir() if path.suffix in (".c", ".h"))


def _install_compiler() -> None:
    """Install ziglang for this Python installation, unless a compiler works."""
    import importlib
    import subprocess

    try:
        find_compiler()
    except KernelBuildError:
        print(f"tool0: installing a C compiler ({ZIG})", file=sys.stderr)
        options = ("--quiet", "--disable-pip-version-check")
        done = subprocess.run(
            [sys.executable, "-m", "pip", "install", *options, ZIG], check=False
        )
        if done.returncode:
            raise KernelBuildError(
                f"pip cannot install '{ZIG}' (see above); install gcc or clang"
            ) from None
        importlib.invalidate_caches()


def main(words: Sequence[str], folder: Path = FOLDER) -> int:
    """Execute the command line, and return the exit status."""
    if words not in ([], ["--install-compiler"]):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        open_library(folder)
    except KernelUnusableError:
        try:
            if words:
                _install_compiler()
            path = build(folder)
        except KernelBuildError as error:
            print(f"tool0: cannot compile the kernel: {error}", file=sys.stderr)
            return 1
        print(f"tool0: compiled {path}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
