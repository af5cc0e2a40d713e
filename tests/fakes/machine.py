"""A machine to examine or install on, in a folder: its programs and files."""

from __future__ import annotations

from pathlib import Path

from tool0.installation.machine import Machine


def add_program(path: Path, script: str = "") -> Path:
    """Write a shell script that can be run, and return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


def make_machine(
    root: Path,
    *programs: str,
    release: str = "",
    system: str = "linux",
    **variables: str,
) -> Machine:
    """Return a machine with these programs, which do nothing.

    Args:
        root: Its file system; programs are in ``bin``.
        programs: Names.
        release: The text of ``/etc/os-release``.
        system: As ``sys.platform``.
        variables: Of its environment.
    """
    for name in programs:
        add_program(root / "bin" / name)
    (root / "etc").mkdir(exist_ok=True)
    (root / "etc/os-release").write_text(release)
    environ = {"PATH": str(root / "bin"), **variables}
    return Machine(root=root, environ=environ, system=system)


def add_gazebo_header(root: Path, version: str) -> None:
    """Write the header of Gazebo that states its version."""
    header = root / "include/gazebo-11/gazebo/gazebo_config.h"
    header.parent.mkdir(parents=True)
    header.write_text(f'#define GAZEBO_VERSION_FULL "{version}"\n')
