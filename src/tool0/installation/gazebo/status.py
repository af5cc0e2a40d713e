"""Whether a Gazebo could run here, which, and what is missing."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import final

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.installation import find_installation, read_marker
from tool0.installation.gazebo.plugin import compiler, expected_libraries


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GazeboStatus:
    """What ``tool0 gazebo status`` prints."""

    version: str | None = None
    """Of the Gazebo that would run; None if there is none."""
    prefix: Path | None = None
    """Its private prefix; None for a system's."""
    size: int | None = None
    """Bytes of the private prefix on disk."""
    server: Path | None = None
    """The program gzserver."""
    client: Path | None = None
    """The program gzclient."""
    compiler: str | None = None
    """The C++ compiler."""
    is_compiled: bool = False
    """Whether what runs inside Gazebo is compiled."""
    missing: tuple[str, ...] = ()
    """What prevents it from running, or from having a window; each with a remedy."""

    @property
    def can_run(self) -> bool:
        """Whether a simulation can start: the bridge is compiled, or can be."""
        has_bridge = self.is_compiled or self.compiler is not None
        return self.version is not None and has_bridge

    def as_json(self) -> dict[str, object]:
        """Return what JSON can hold."""
        plain = {
            name: str(value) if isinstance(value, Path) else value
            for name, value in asdict(self).items()
        }
        return {"can_run": self.can_run, **plain}

    def rows(self) -> list[tuple[str, str]]:
        """Return names and values for people."""
        kind = "the system's"
        if self.prefix is not None:
            kind = f"private, {(self.size or 0) / 1e6:.0f} MB in {self.prefix}"
        rows = [("gazebo", f"{self.version}, {kind}" if self.version else "none")]
        if self.version:
            rows += [
                ("server", str(self.server)),
                ("window", str(self.client or "no gzclient")),
            ]
        return [
            *rows,
            ("compiler", self.compiler or "none"),
            ("bridge", "compiled" if self.is_compiled else "not compiled yet"),
            *(("missing", text) for text in self.missing),
        ]


def gazebo_status() -> GazeboStatus:
    """Return the status; nothing is started or compiled."""
    command = compiler()
    shown = None if command is None else " ".join(command)
    no_compiler = () if shown else ("a C++ compiler: apt install g++",)
    try:
        found = find_installation()
    except EngineUnavailableError as error:
        return GazeboStatus(compiler=shown, missing=(str(error), *no_compiler))
    libraries = expected_libraries(found)
    is_compiled = libraries.bridge.is_file() and libraries.preload.is_file()
    marker = None if found.prefix is None else read_marker(found.prefix)
    no_window = () if found.client else ("a window: tool0 gazebo install --gui",)
    return GazeboStatus(
        version=found.version,
        prefix=found.prefix,
        size=None if marker is None else marker.size,
        server=found.server,
        client=found.client,
        compiler=shown,
        is_compiled=is_compiled,
        missing=(*(() if is_compiled else no_compiler), *no_window),
    )
