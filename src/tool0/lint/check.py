"""Runs all rules on the files of ``tool0 check``."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import ParamSpec, TypeVar, final

from tool0.description.config import File
from tool0.description.finding import Finding
from tool0.description.packages import packages_around
from tool0.errors import SourceLocation, Tool0Error
from tool0.lint import launch_file
from tool0.lint.launch_file import ParsedLaunch
from tool0.lint.package_file import (
    MISSING_PACKAGE,
    judge_missing_package,
    package_findings,
)
from tool0.lint.packages import PackageIndex, Packages
from tool0.lint.parameters.yaml_text import YamlText, syntax_findings, yaml_findings
from tool0.lint.resource_limits import ResourceLimitError, run_limited
from tool0.lint.robot.facts import RobotFacts
from tool0.lint.robot_file import (
    ParsedRobot,
    XacroSource,
    read_robot,
    read_xacro_source,
)
from tool0.lint.sources import FileKind, Source, collect, finding_of, read_text

R = TypeVar("R")
P = ParamSpec("P")

_WORD = re.compile(r"[\w.-]+")
_Expansion = tuple[Path, tuple[tuple[str, str], ...]]
"""A file, and the arguments with which it is read."""


@final
@dataclass(frozen=True, slots=True)
class CheckReport:
    """Findings of one run, and the files that were checked."""

    findings: tuple[Finding, ...]
    """The findings, sorted by file and line."""
    files: tuple[Path, ...]
    """The files that were checked."""
    notes: tuple[str, ...]
    """Notes on checks that were not possible, with the reasons.  The notes are not
    findings, because the files are not faulty."""

    @property
    def n_errors(self) -> int:
        """The number of errors."""
        return sum(finding.severity == "error" for finding in self.findings)

    @property
    def n_warnings(self) -> int:
        """The number of warnings."""
        return len(self.findings) - self.n_errors


def check(paths: File | Iterable[File]) -> CheckReport:
    """Check files and folders, with time and memory limits for each file.

    Args:
        paths: One path or several paths.  Each path is a URDF, xacro, YAML or launch
            file, a package, or a folder that contains such files.

    Raises:
        ConfigError: If a path does not exist, or if its kind is not supported.
    """
    several = (paths,) if isinstance(paths, str | Path) else paths
    return _Check([Path(path) for path in several]).report()


@final
class _Check:
    """One run, which stores the findings and the files that other files load."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self._sources = collect(paths)
        self._packages = {
            name: folder.absolute() for name, folder in self._sources.packages.items()
        }
        for source in self._sources.files:
            if source.was_named:
                for name, folder in packages_around(source.path).items():
                    self._packages.setdefault(name, folder)
        self._places = PackageIndex(self._packages)
        self._findings: list[Finding] = []
        self._notes = [f"{path}: {why}" for path, why in self._sources.skipped]
        self._loaded: set[Path] = set()
        self._robots: dict[_Expansion, ParsedRobot | None] = {}

    def report(self) -> CheckReport:
        """Check all files, starting with files that load other files."""
        self._launch_files()
        self._xacro_files()
        self._urdf_files()
        self._yaml_files()
        self._package_files()
        judged = [judge_missing_package(finding) for finding in self._findings]
        self._notes += [item for item in judged if isinstance(item, str)]
        findings = [item for item in judged if isinstance(item, Finding)]
        once = {_identity(item): item for item in sorted(findings, key=_place)}
        return CheckReport(
            findings=tuple(once.values()),
            files=tuple(source.path for source in self._sources.files),
            notes=tuple(dict.fromkeys(self._notes)),
        )

    # --- kinds of files ---

    def _launch_files(self) -> None:
        read = self._read_all(FileKind.LAUNCH, launch_file.read_launch_file)
        included = {path for answer in read.values() for path in answer.included}
        for path, answer in read.items():
            named = any(s.path == path and s.was_named for s in self._sources.files)
            if path.absolute() not in included or named:
                self._launch_file(path, answer)

    def _launch_file(self, path: Path, read: ParsedLaunch) -> None:
        own = {source.path.resolve() for source in self._sources.files}
        self._findings += [  # without findings in files of other packages
            finding
            for finding in read.findings
            if finding.location.file is None or finding.location.file.resolve() in own
        ]
        self._notes += read.notes
        facts = None
        for file, args in read.robots:
            answer = self._read_robot(file, args, spawned=read.spawns)
            if answer is not None:
                self._findings += answer.findings
                facts = facts or answer.facts
        self._loaded |= {
            y.location.file.resolve() for y in read.yamls if y.location.file
        }
        rules = launch_file.control_findings
        self._apply(path, rules, read, facts, self._packages)

    def _xacro_files(self) -> None:
        read = self._read_all(FileKind.XACRO, read_xacro_source)
        self._findings += [found for item in read.values() for found in item.findings]
        parts = {path for answer in read.values() for path in answer.includes}
        for path, answer in read.items():
            if answer.makes_a_robot and path.resolve() not in parts | self._loaded:
                self._xacro_robot(path, answer)

    def _xacro_robot(self, path: Path, answer: XacroSource) -> None:
        """Check the robot in a file that no other file loads."""
        read = self._read_robot(path, {})
        if read is not None and read.facts is None and answer.needs:
            needs = ", ".join(answer.needs)
            self._notes.append(
                f"{path}: not expanded, since nothing here gives it {needs}"
            )
        elif read is not None and (read.facts is None or read.facts.links):
            # without a link, the file contains only a part of a robot
            self._findings += read.findings

    def _urdf_files(self) -> None:
        for source in self._sources.of(FileKind.URDF):
            if source.path.resolve() in self._loaded:
                continue
            read = self._read_robot(source.path, None)
            self._findings += () if read is None else read.findings

    def _yaml_files(self) -> None:
        sources = {
            source.path: source
            for source in self._sources.of(FileKind.PARAMETERS)
            if source.path.resolve() not in self._loaded
        }
        texts = self._try_each({path: partial(read_text, path) for path in sources})
        rules = {
            path: self._rules_of_yaml(sources[path], text)
            for path, text in texts.items()
        }
        for found in self._try_each(rules).values():
            self._findings += found

    def _rules_of_yaml(
        self, source: Source, text: str
    ) -> Callable[[], Sequence[Finding]]:
        """Return a function that checks a YAML file that no launch file loads."""
        yaml = YamlText(text, SourceLocation(source.path, 1))
        if not yaml.is_about_controllers:
            if source.was_named:
                self._notes.append(f"{source.path}: holds no controllers")
            return lambda: tuple(syntax_findings(yaml))
        robot = self._robot_of(source, yaml)
        rules = yaml_findings if source.was_named else _yaml_alone
        return lambda: tuple(rules((yaml,), robot, self._packages))

    def _robot_of(self, yaml: Source, text: YamlText) -> RobotFacts | None:
        """Return the robot for a YAML file, if exactly one robot fits the file.

        A robot fits a YAML file under two conditions.  Either the user named both
        files, or the two files are in the same package or folder.  In addition, the
        robot has a joint that occurs in the YAML file.
        """
        named = {s.path.resolve() for s in self._sources.files if s.was_named}
        home, words = self._home(yaml.path), set(_WORD.findall(text.text))
        found = [
            read.facts
            for (file, _), read in self._robots.items()
            if read is not None
            and read.facts is not None
            and (self._home(file) == home or (yaml.was_named and file in named))
            and not words.isdisjoint(read.facts.joints)
        ]
        return found[0] if len(found) == 1 else None

    def _home(self, file: Path) -> str | Path:
        return self._places.package_of(file.absolute()) or file.resolve().parent

    def _package_files(self) -> None:
        files = self._sources.files
        for source in self._sources.of(FileKind.PACKAGE):
            file = source.path
            self._apply(file, package_findings, file, files, self._packages)

    # --- parts ---

    def _read_all(
        self, kind: FileKind, reader: Callable[[Path, Packages], R]
    ) -> dict[Path, R]:
        """Return the results of ``reader`` for the files that it can read."""
        return self._try_each(
            {
                source.path: partial(reader, source.path, self._packages)
                for source in self._sources.of(kind)
            }
        )

    def _read_robot(
        self,
        file: Path,
        args: Mapping[str, str] | None,
        *,
        spawned: bool | None = None,
    ) -> ParsedRobot | None:
        """Return the robot in a file.  Each set of arguments is read only once."""
        self._loaded.add(file.resolve())
        key = (file.resolve(), tuple(sorted((args or {}).items())))
        if key not in self._robots:
            self._robots[key] = self._try(
                file, read_robot, file, args, self._packages, spawned=spawned
            )
        return self._robots[key]

    def _try(
        self,
        file: Path,
        work: Callable[P, R],
        *arguments: P.args,
        **keywords: P.kwargs,
    ) -> R | None:
        """Return the result of ``work``.

        If ``work`` fails, add a finding and return None.
        """
        outcome = _limited(lambda: work(*arguments, **keywords))
        if isinstance(outcome, Exception):
            self._findings.append(finding_of(outcome, "unreadable", file))
            return None
        return outcome

    def _try_each(self, works: Mapping[Path, Callable[[], R]]) -> dict[Path, R]:
        """Return the results of functions, by file.  Add a finding for each failure.

        A single process does all of the work, because starting a process takes longer
        than checking most files.  If that process exceeds a limit, a separate process
        is started for each file.
        """
        outcomes: Mapping[Path, R | Exception]
        try:
            outcomes = run_limited(_outcomes, works)
        except ResourceLimitError:
            outcomes = {path: _limited(work) for path, work in works.items()}
        results = {}
        for path, outcome in outcomes.items():
            if isinstance(outcome, Exception):
                self._findings.append(finding_of(outcome, "unreadable", path))
            else:
                results[path] = outcome
        return results

    def _apply(
        self,
        file: Path,
        rules: Callable[P, Iterable[Finding]],
        *arguments: P.args,
        **keywords: P.kwargs,
    ) -> None:
        """Add the findings that ``rules`` returns for ``file``."""

        def found() -> list[Finding]:
            return list(rules(*arguments, **keywords))

        self._findings += self._try(file, found) or ()


def _limited(work: Callable[[], R]) -> R | Exception:
    """Return the result of ``work`` in a process with limits, or the error."""
    try:
        return run_limited(_outcome, work)
    except ResourceLimitError as error:
        return error


def _outcome(work: Callable[[], R]) -> R | Exception:
    try:
        return work()
    except RecursionError:
        return ValueError("its elements are nested too deep to be read")
    except (Tool0Error, OSError, ValueError) as error:
        return error


def _outcomes(works: Mapping[Path, Callable[[], R]]) -> dict[Path, R | Exception]:
    return {path: _outcome(work) for path, work in works.items()}


def _yaml_alone(
    yamls: Iterable[YamlText], robot: RobotFacts | None, packages: Packages
) -> Iterator[Finding]:
    """Yield the findings of YAML files that the user did not name and no file loads.

    Interface mismatches are omitted, because the robot may offer other interfaces if it
    gets other arguments.
    """
    for finding in yaml_findings(yamls, robot, packages):
        if finding.rule != "interface-mismatch":
            yield finding


def _identity(finding: Finding) -> tuple[object, ...]:
    """Return a key that is equal for any two findings of the same fault.

    If a macro contains a typo, the findings in the macro's source and in its expansion
    have different keys.  A missing package is reported once for each file.
    """
    if finding.rule in MISSING_PACKAGE:
        return finding.location.file, finding.rule, finding.key
    key = finding.remedy if finding.rule == "interface-typo" else finding.key
    return finding.location, finding.rule, key, finding.remedy


def _place(finding: Finding) -> tuple[str, int, str]:
    return str(finding.location.file), finding.location.line or 0, finding.key
