"""``tool0 check``: find errors in launch files, robot descriptions and YAML."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import counted, print_json

if TYPE_CHECKING:
    from tool0.cli.outputs import CheckOutput
    from tool0.lint.check import CheckReport

CLEAN = 0
FOUND = 1


def check(
    paths: Annotated[tuple[Path, ...], Option(is_positional=True, metavar="PATH ...")],
    as_json: AsJson = False,
    strict: bool = False,
) -> int:
    """Find errors in URDF, xacro, ros_control YAML, launch files and workspaces.

    Exit status: 0 if no errors were found, 1 if errors were found, 2 for wrong
    arguments.

    Args:
        paths: Files, or folders, which are searched recursively.
        as_json: Print one JSON object.
        strict: Treat warnings as errors.
    """
    from tool0.lint.check import check as look_into

    report = look_into(paths)
    if as_json:
        print_json(_plain(report))
    else:
        print(_text(report))
    is_bad = report.n_errors or (strict and report.findings)
    return FOUND if is_bad else CLEAN


def _text(report: CheckReport) -> str:
    lines = []
    for finding in report.findings:
        text = ": ".join(part for part in (finding.key, finding.message) if part)
        where = f"{finding.location}: {finding.severity}"
        lines.append(f"{where}: {text} [{finding.rule}]")
        if finding.remedy:
            lines.append(f"    {finding.remedy}")
    lines += [f"note: {note}" for note in report.notes]
    lines.append(
        f"{_count(report.n_errors, 'error')}, {_count(report.n_warnings, 'warning')} "
        f"in {_count(len(report.files), 'file')}"
    )
    return "\n".join(lines)


def _count(number: int, what: str) -> str:
    return counted(number, what) if number else f"no {what}s"


def _plain(report: CheckReport) -> CheckOutput:
    return {
        "findings": [finding.as_json() for finding in report.findings],
        "files": [str(path) for path in report.files],
        "notes": report.notes,
        "errors": report.n_errors,
        "warnings": report.n_warnings,
    }
