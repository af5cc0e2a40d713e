"""Telling a package that this machine lacks from one that is misspelt."""

from __future__ import annotations

import re
from dataclasses import replace

from tool0.description.finding import Finding
from tool0.lint.package_file import declared_dependencies

_RULES = ("unresolved-find", "unknown-package", "missing-package")
_NO_PACKAGE = re.compile(r"there is no ROS package '([\w-]+)'")


def absence_judged(finding: Finding) -> Finding | str:
    """Return a finding as it counts, or a note that stands in its place.

    What the file's own package depends on is no fault of the file; and of a file in no
    package nobody knows, unless the name is nearly that of a package.
    """
    lacking, file = _lacking(finding), finding.location.file
    if lacking is None or file is None:
        return finding
    folder = next(
        (f for f in file.absolute().parents if (f / "package.xml").is_file()), None
    )
    if folder is not None and lacking in declared_dependencies(folder):
        return (
            f"{file}: '{lacking}' is not on this machine; what it holds was not "
            "looked into"
        )
    if folder is None and "did you mean" not in finding.text:
        return replace(finding, severity="warning")
    return finding


def _lacking(finding: Finding) -> str | None:
    """Return the package that is not found, if the finding says that."""
    if finding.rule in _RULES:
        return finding.key
    match = _NO_PACKAGE.search(finding.message)
    return None if match is None else match[1]
