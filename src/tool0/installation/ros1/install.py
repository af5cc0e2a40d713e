"""Installs the ROS 1 packages that tool0 needs with the system's apt."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, final

from tool0.errors import RosUnavailableError
from tool0.installation.apt import ProgressCallback, explain_failure
from tool0.installation.machine import Machine
from tool0.installation.ros1.library import import_ros, is_of_distribution, ros_origin
from tool0.installation.ros1.packages import other_install_command, required_components

PYTHON_OF_RELEASE: Final = {"bookworm": "3.11", "trixie": "3.13", "jammy": "3.10"}
"""Python version of the ROS 1 packages of each release, by codename.

The releases are Debian 12 and 13, and Ubuntu 22.04.  Ubuntu removed ROS 1 before 24.04:
https://bugs.launchpad.net/ubuntu/+source/ros-catkin/+bug/2063103
"""
_NOT_PACKAGED: Final = (
    "use RoboStack, which runs on any Linux, or a container or machine with Debian 12 "
    "or 13 over ROS_MASTER_URI (docs/how-to/ros1.md)"
)
_ON_FOCAL: Final = (
    "On Ubuntu 20.04, ROS 1 is Noetic: install it from its own packages and "
    "`source /opt/ros/noetic/setup.bash` (docs/how-to/ros1.md)"
)

_APT: Final = (
    *("env", "DEBIAN_FRONTEND=noninteractive", "LC_ALL=C.UTF-8"),
    *("apt-get", "-q", "-o", "DPkg::Lock::Timeout=300"),
)
_INSTALL: Final = (
    *("install", "--yes", "--no-install-recommends", "-o", "APT::Status-Fd=1"),
)
_ACTIVITIES: Final = {"dlstatus": "downloading", "pmstatus": "installing"}
"""Activity by the start of apt's progress lines (``dlstatus:…:percent:…``)."""
_EXPLANATIONS: Final = {
    "disk full": "the disk is full; RViz needs 1 GB, the rest 0.4 GB",
    "unreachable": (
        "the distribution's mirror cannot be reached: check the network, or set the "
        "proxy in http_proxy or apt.conf"
    ),
    "no package": (
        "some packages are not in the machine's apt sources; on Ubuntu they are in "
        "`universe`: sudo add-apt-repository universe"
    ),
    "locked": "another program is installing packages; wait for it, then try again",
    "broken": (
        "packages of this machine conflict, or are partly installed; run "
        "sudo apt-get install --fix-broken"
    ),
}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros1InstallPlan:
    """The packages that must be installed, if any."""

    target: str
    """The distribution or the existing ROS for which packages are installed."""
    packages: tuple[str, ...]
    """Debian packages that are not yet installed."""

    @property
    def command(self) -> str:
        """The shell command that installs the packages."""
        sudo = "" if os.geteuid() == 0 else "sudo "
        return (
            f"{sudo}apt-get update && {sudo}apt-get install --yes "
            "--no-install-recommends -o DPkg::Lock::Timeout=300 "
            f"{' '.join(self.packages)}"
        )


def plan_install(*, rviz: bool) -> Ros1InstallPlan:
    """Return a plan with the missing packages.

    Raises:
        RosUnavailableError: If tool0 cannot install ROS.  The message describes another
            way to install it.
    """
    components = required_components(rviz=rviz)
    if _has_other_ros():
        missing = [part for part in components if part.missing()]
        if missing:
            names = ", ".join(component.name for component in missing)
            raise RosUnavailableError(
                f"{ros_origin()} is installed, without: {names}. Add them with its "
                f"own tools: {other_install_command(missing)}"
            )
        return Ros1InstallPlan(target=ros_origin() or "ROS", packages=())
    name, codename = Machine().name(), Machine().codename()
    theirs = PYTHON_OF_RELEASE.get(codename)
    if theirs is None:
        remedy = _ON_FOCAL if codename == "focal" else _NOT_PACKAGED
        raise RosUnavailableError(
            f"tool0 knows no ROS 1 packages for {name}; Debian 12 and 13 "
            f"and Ubuntu 22.04 have them. {remedy}"
        )
    ours = f"{sys.version_info.major}.{sys.version_info.minor}"
    if ours != theirs:
        raise RosUnavailableError(
            f"the packages of {name} are for Python {theirs}, and this is Python "
            f"{ours} ('{sys.prefix}'). Make a virtual environment with the "
            "distribution's: rm -rf .venv && make setup PYTHON=/usr/bin/python3, "
            "or /usr/bin/python3 -m venv FOLDER and FOLDER/bin/pip install ."
        )
    packages = not_installed(n for part in components for n in part.debian)
    return Ros1InstallPlan(target=name, packages=packages)


def install_ros1(plan: Ros1InstallPlan, progress: ProgressCallback) -> None:
    """Install the packages of the plan, as root or through sudo.

    Raises:
        RosUnavailableError: If the installation fails.  The message contains the reason
            and the command.
    """
    apt = [*_root_prefix(plan), *_APT]
    progress("updating the package lists", 0.0)
    # If one package source is unreachable, other sources may have the packages.
    _, update_output = _run_apt([*apt, "update"], progress)
    progress("resolving dependencies", 0.0)
    status, output = _run_apt([*apt, *_INSTALL, *plan.packages], progress)
    if status != 0:
        reason = explain_failure(
            "\n".join([*update_output, *output]),
            _EXPLANATIONS,
            otherwise=f"apt-get ended with status {status}",
        )
        raise RosUnavailableError(f"{reason}\nThe command was: {plan.command}")


def _has_other_ros() -> bool:
    """Return whether a ROS from outside the distribution is active."""
    try:
        import_ros()
    except RosUnavailableError:
        distro = os.environ.get("ROS_DISTRO")
        if distro is None or os.environ.get("ROS_VERSION", "1") != "1":
            return False  # ROS 2 does not affect ROS 1
        raise RosUnavailableError(
            f"ROS_DISTRO is '{distro}', but this Python finds no rospy: `source "
            f"/opt/ros/{distro}/setup.bash` in this terminal, without changing "
            "PYTHONPATH after that, or unset ROS_DISTRO to use the distribution's "
            "packages"
        ) from None
    return not is_of_distribution()


# --- the system's apt ---


def not_installed(packages: Iterable[str]) -> tuple[str, ...]:
    """Return the packages that dpkg does not list as installed."""
    names = tuple(dict.fromkeys(packages))
    if shutil.which("dpkg-query") is None or shutil.which("apt-get") is None:
        raise RosUnavailableError(
            f"this machine has no apt-get; install the equivalent of: {' '.join(names)}"
        )
    answer = subprocess.run(
        ["dpkg-query", "--show", "-f", "${Package} ${db:Status-Status}\n", *names],
        capture_output=True,
        text=True,
        check=False,  # the exit status is 1 if a package is unknown
    )
    rows = (line.split() for line in answer.stdout.splitlines())
    installed = {row[0] for row in rows if row[1:] == ["installed"]}
    return tuple(name for name in names if name not in installed)


def _root_prefix(plan: Ros1InstallPlan) -> tuple[str, ...]:
    """Return the prefix that runs a command as root."""
    if os.geteuid() == 0:
        return ()
    if shutil.which("sudo") is not None:
        if sys.stdin.isatty():  # sudo may ask for the password
            return ("sudo",)
        trial = subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False)
        if trial.returncode == 0:
            return ("sudo", "-n")
    raise RosUnavailableError(
        "installing packages needs root, and sudo is not permitted; run: "
        f"{plan.command}"
    )


def _run_apt(
    command: Sequence[str], progress: ProgressCallback
) -> tuple[int, list[str]]:
    """Run the command, and show its progress.

    Return the exit status and the output without progress.

    ``ChildProcess`` is not used, because sudo needs the terminal, and because dpkg must
    not be killed.
    """
    output: list[str] = []
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
            if kind in _ACTIVITIES:
                progress(_ACTIVITIES[kind], float(rest.split(":")[1]) / 100.0)
            elif line.strip():
                output.append(line.strip())
    return process.returncode, output
