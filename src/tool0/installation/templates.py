"""Fills in the templates of package files for one robot by replacing ``@words@``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Final

_TEMPLATE: Final = ".in"
"""Suffix of templates that are not valid files of their type."""


def filled(
    folder: Path, package: PurePosixPath, words: Mapping[str, str]
) -> dict[PurePosixPath, str]:
    """Return the files below ``folder`` by path, with template words replaced.

    Args:
        folder: The folder of the templates.
        package: Path of the resulting package.
        words: Texts that replace the words, by word, such as ``@robot@``.
    """
    files = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            text = path.read_text(encoding="utf-8")
            for word, meaning in words.items():
                text = text.replace(word, meaning)
            name = path.relative_to(folder).as_posix().removesuffix(_TEMPLATE)
            files[package / name] = text
    return files
