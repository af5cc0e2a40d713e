"""The system's apt-get: what is installed, installing more, and what went wrong."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Final

from tool0.errors import RosUnavailableError

Report = Callable[[str, float], None]
"""What is being done, and how much of it is, from 0 to 1."""

_APT: Final = (
    *("env", "DEBIAN_FRONTEND=noninteractive", "LC_ALL=C.UTF-8"),
    *("apt-get", "-q", "-o", "DPkg::Lock::Timeout=300"),
)
_UPDATE: Final = (*_APT, "update")
_INSTALL: Final = (*_APT, "install", "--yes", "--no-install-recommends")
_STATUS: Final = ("-o", "APT::Status-Fd=1")
"""apt tells by lines how far it is: 'dlstatus:…:percent:…', 'pmstatus:…'."""
_TOLD: Final = {"dlstatus": "downloading", "pmstatus": "installing"}
_COMPLAINTS: Final = ("E:", "Err:", "W:")
_LAST: Final = 6
"""Lines of apt that an error repeats."""
_CAUSES: Final = (
    (
        ("no space left", "enough free space"),
        "the disk is full; RViz and what it needs take 1 GB, the rest 0.4 GB",
    ),
    (
        (
            *("could not resolve", "temporary failure", "could not connect"),
            *("connection failed", "connection timed out", "connection refused"),
            *("network is unreachable", "no route to host", "unable to connect"),
        ),
        "the distribution's mirror cannot be reached: is there a network, or a proxy "
        "to be set in http_proxy or apt.conf?",
    ),
    (
        ("unable to locate package", "has no installation candidate"),
        "the machine's sources of packages lack some; on Ubuntu they are in "
        "`universe`: sudo add-apt-repository universe",
    ),
    (
        ("could not get lock",),
        "another program installs packages; wait for it, then run this again",
    ),
    (
        ("unmet dependencies", "broken packages", "dpkg was interrupted"),
        "packages of this machine are in the way, or half installed: "
        "sudo apt-get install --fix-broken",
    ),
)


def not_installed(packages: Iterable[str]) -> tuple[str, ...]:
    """Return those that dpkg does not have."""
    names = tuple(dict.fromkeys(packages))
    if shutil.which("dpkg-query") is None or shutil.which("apt-get") is None:
        raise RosUnavailableError(
            f"this machine has no apt-get; install the equivalent of: {' '.join(names)}"
        )
    answer = subprocess.run(
        ["dpkg-query", "--show", "-f", "${Package} ${db:Status-Status}\n", *names],
        capture_output=True,
        text=True,
        check=False,  # 1 if one of them is unknown
    )
    rows = (line.split() for line in answer.stdout.splitlines())
    installed = {row[0] for row in rows if row[1:] == ["installed"]}
    return tuple(name for name in names if name not in installed)


def commands(packages: Sequence[str]) -> str:
    """Return what a person would type."""
    sudo = "" if os.geteuid() == 0 else "sudo "
    return (
        f"{sudo}apt-get update && {sudo}apt-get install --yes --no-install-recommends "
        f"-o DPkg::Lock::Timeout=300 {' '.join(packages)}"
    )


def install(packages: Sequence[str], report: Report) -> None:
    """Install them, as root or through sudo.

    Raises:
        RosUnavailableError: If it may not or cannot, with the reason and the command.
    """
    prefix = _as_root(packages)
    report("asking for the lists of packages", 0.0)
    # Where one source of many cannot be reached, the packages may be there yet.
    _, first = _run([*prefix, *_UPDATE], report)
    report("finding what they need", 0.0)
    status, then = _run([*prefix, *_INSTALL, *_STATUS, *packages], report)
    if status != 0:
        complaints = [line for line in first if line.startswith(_COMPLAINTS)]
        raise RosUnavailableError(_explained(status, [*complaints, *then], packages))


def _as_root(packages: Sequence[str]) -> tuple[str, ...]:
    if os.geteuid() == 0:
        return ()
    if shutil.which("sudo") is not None:
        if sys.stdin.isatty():  # sudo may ask for the password
            return ("sudo",)
        asked = subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False)
        if asked.returncode == 0:
            return ("sudo", "-n")
    raise RosUnavailableError(
        f"installing packages needs root, and sudo does not let us; run: "
        f"{commands(packages)}"
    )


def _run(command: Sequence[str], report: Report) -> tuple[int, list[str]]:
    """Run it and tell how far it is; return its status and what else it said."""
    said: list[str] = []
    with subprocess.Popen(
        command,
        stdin=None if command[:1] == ["sudo"] else subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            kind, _, rest = line.partition(":")
            if kind in _TOLD:
                report(_TOLD[kind], float(rest.split(":")[1]) / 100.0)
            elif line.strip():
                said.append(line.strip())
    return process.returncode, said


def _explained(status: int, said: Sequence[str], packages: Sequence[str]) -> str:
    lower = "\n".join(said).lower()
    cause = next(
        (text for words, text in _CAUSES if any(word in lower for word in words)),
        f"apt-get ended with status {status}",
    )
    lines = [line for line in said if line.startswith(_COMPLAINTS)] or list(said)
    last = "\n".join(f"  {line}" for line in lines[-_LAST:])
    return f"{cause}. apt said:\n{last}\nThe command was: {commands(packages)}"
