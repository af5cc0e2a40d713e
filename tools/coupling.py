"""Print the share of package pairs that imports couple, and check its bound.

Packages are the direct children of ``tool0``.  Two packages are coupled if a module of
one package imports from the other package.  Imports inside functions, and imports that
are only for annotations, are included.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

SOURCE = Path(__file__).parent.parent / "src" / "tool0"
BOUND = 0.39
"""Largest allowed share of coupled pairs.  Reduce the bound when couplings have been
removed."""
_NO_PACKAGES = ("__init__", "__main__", "ros_packages")


def packages(source: Path) -> list[str]:
    """Return the names of the packages and modules directly below ``source``."""
    folders = (file.parent.name for file in source.glob("*/__init__.py"))
    names = {*folders, *(file.stem for file in source.glob("*.py"))}
    return sorted(names.difference(_NO_PACKAGES))


def coupled_pairs(source: Path) -> list[tuple[str, str]]:
    """Return the pairs of coupled packages.  Each pair is in alphabetical order."""
    imports = {
        (name, imported)
        for name in packages(source)
        for file in _files(source, name)
        for imported in _imported(file, source.name)
    }
    return [
        (one, other)
        for one, other in combinations(packages(source), 2)
        if {(one, other), (other, one)} & imports
    ]


def report(source: Path, bound: float) -> tuple[str, int]:
    """Return the line to print, and the exit status, which is 1 above the bound."""
    n, n_packages = len(coupled_pairs(source)), len(packages(source))
    n_all = n_packages * (n_packages - 1) // 2
    text = f"coupled package pairs: {n} of {n_all} ({n / n_all:.0%})"
    if round(n / n_all, 2) > bound:
        return f"{text}, more than the bound of {bound:.0%} in tools/coupling.py", 1
    return text, 0


def _files(source: Path, package: str) -> Iterator[Path]:
    yield from (source / package).rglob("*.py")
    yield from source.glob(f"{package}.py")


def _imported(file: Path, root: str) -> Iterator[str]:
    """Yield the name directly below ``root`` of each module that a file imports."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for first, _, rest in (name.partition(".") for name in names):
            if first == root and rest:
                yield rest.partition(".")[0]


if __name__ == "__main__":
    line, status = report(SOURCE, BOUND)
    print(line)
    sys.exit(status)
