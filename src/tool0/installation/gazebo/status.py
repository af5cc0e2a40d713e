"""The status of Gazebo on this machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict, final

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.installation import GazeboInstallation, find_installation
from tool0.installation.gazebo.plugin import compiler, expected_libraries


class GazeboJson(TypedDict):
    """The status as data for JSON."""

    can_run: bool
    """Whether a simulation can start."""
    version: str | None
    """Version of Gazebo, such as ``11.1.0``; null if there is no Gazebo."""
    prefix: str | None
    """The private prefix; null for the system's Gazebo."""
    size: int | None
    """Size of the private prefix on disk [bytes]; null for the system's Gazebo."""
    server: str | None
    """Path of the program gzserver."""
    client: str | None
    """Path of the program gzclient; null if it cannot run."""
    compiler: str | None
    """The command of the C++ compiler; null if there is no compiler."""
    is_compiled: bool
    """Whether the plugin for Gazebo is compiled."""
    missing: tuple[str, ...]
    """Reasons why Gazebo cannot run or open a window, each with a remedy."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GazeboStatus:
    """The output of ``tool0 gazebo status``."""

    installation: GazeboInstallation | None
    """The Gazebo that tool0 would run; None if there is none."""
    compiler: str | None
    """The command of the C++ compiler; None if there is no compiler."""
    is_compiled: bool = False
    """Whether the plugin for Gazebo is compiled."""
    missing: tuple[str, ...]
    """Reasons why Gazebo cannot run or open a window, each with a remedy."""

    @property
    def can_run(self) -> bool:
        """Whether a simulation can start.

        A simulation requires a plugin that is compiled or can be compiled.
        """
        has_bridge = self.is_compiled or self.compiler is not None
        return self.installation is not None and has_bridge

    def as_json(self) -> GazeboJson:
        """Return the status as data for JSON."""
        found = self.installation
        return {
            "can_run": self.can_run,
            "version": found and found.version,
            "prefix": None if not (found and found.prefix) else str(found.prefix),
            "size": found and found.size,
            "server": found and str(found.server),
            "client": None if not (found and found.client) else str(found.client),
            "compiler": self.compiler,
            "is_compiled": self.is_compiled,
            "missing": self.missing,
        }

    def rows(self) -> list[tuple[str, str]]:
        """Return the names and values of the status as text."""
        rows = [("gazebo", "none")]
        if found := self.installation:
            kind = "the system's"
            if found.prefix is not None:
                kind = f"private, {(found.size or 0) / 1e6:.0f} MB in {found.prefix}"
            rows = [
                ("gazebo", f"{found.version}, {kind}"),
                ("server", str(found.server)),
                ("window", str(found.client or "no gzclient")),
            ]
        return [
            *rows,
            ("compiler", self.compiler or "none"),
            ("bridge", "compiled" if self.is_compiled else "not compiled yet"),
            *(("missing", text) for text in self.missing),
        ]


def gazebo_status() -> GazeboStatus:
    """Return the status without starting or compiling anything."""
    command = " ".join(compiler() or ()) or None
    no_compiler = () if command else ("a C++ compiler: apt install g++",)
    try:
        found = find_installation()
    except EngineUnavailableError as error:
        missing = (str(error), *no_compiler)
        return GazeboStatus(installation=None, compiler=command, missing=missing)
    libraries = expected_libraries(found)
    is_compiled = libraries.bridge.is_file() and libraries.preload.is_file()
    no_window = () if found.client else ("a window: tool0 gazebo install --gui",)
    return GazeboStatus(
        installation=found,
        compiler=command,
        is_compiled=is_compiled,
        missing=(*(() if is_compiled else no_compiler), *no_window),
    )
