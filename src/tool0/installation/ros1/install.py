"""Getting what of ROS 1 is used onto this machine, or saying who else does."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import final

from tool0.errors import RosUnavailableError
from tool0.installation.ros1 import apt
from tool0.installation.ros1.distribution import check_distribution, distribution
from tool0.installation.ros1.library import import_ros
from tool0.installation.ros1.packages import lacks, wanted
from tool0.installation.ros1.readiness import own_command, whose


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What is to be installed; nothing may be."""

    where: str
    """The distribution, or the ROS, that it is for."""
    packages: tuple[str, ...]
    """Debian's packages that are not installed yet."""

    @property
    def command(self) -> str:
        """What a person would type to install them."""
        return apt.commands(self.packages)


def plan(*, rviz: bool) -> Plan:
    """Look what is missing.

    Raises:
        RosUnavailableError: If it is not ours to install, with who can.
    """
    parts = wanted(rviz=rviz)
    if _has_own_ros():
        missing = [part for part in parts if lacks(part)]
        if missing:
            names = ", ".join(part.name for part in missing)
            raise RosUnavailableError(
                f"there is a {whose()} here, without: {names}. Add them by its own "
                f"means: {own_command(missing)}"
            )
        return Plan(where=whose() or "ROS", packages=())
    check_distribution()
    packages = apt.not_installed(name for part in parts for name in part.debian)
    return Plan(where=distribution()[0], packages=packages)


def carry_out(plan: Plan, report: apt.Report) -> None:
    """Install what the plan names.

    Raises:
        RosUnavailableError: If it cannot be done, with the reason and the command.
    """
    apt.install(plan.packages, report)


def _has_own_ros() -> bool:
    """Return whether a ROS of another origin than the distribution is active."""
    try:
        import_ros()
    except RosUnavailableError:
        distro = os.environ.get("ROS_DISTRO")
        if distro is None or os.environ.get("ROS_VERSION", "1") != "1":
            return False  # a ROS 2 is in nobody's way
        raise RosUnavailableError(
            f"ROS_DISTRO is '{distro}', but this Python finds no rospy: `source "
            f"/opt/ros/{distro}/setup.bash` in this terminal, without changing "
            "PYTHONPATH after that, or unset ROS_DISTRO to use the distribution's "
            "packages"
        ) from None
    return whose() != "the distribution's"
