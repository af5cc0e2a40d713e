"""What is known of loaded controllers, and why none of them drives a joint."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final, final

from tool0.control.controller import Role
from tool0.errors import did_you_mean

KIND_OF: Final = {
    Role.TRAJECTORY: "JointTrajectoryController",
    Role.GRIPPER: "GripperActionController",
    Role.COMMAND: "ForwardCommandController",
}
"""The usual class of a role, for messages."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerStatus:
    """A loaded controller: controller_manager_msgs/ControllerState."""

    name: str
    """Its name in the YAML."""
    type: str
    """As in the YAML: ``effort_controllers/JointTrajectoryController``."""
    role: Role
    """What it is for."""
    state: str
    """ROS 1: ``initialized`` after loading, then ``running`` or ``stopped``.  ROS 2:
    ``unconfigured`` after loading, then ``inactive`` or ``active``."""
    is_running: bool
    """Whether it is running, or active."""
    claimed: tuple[tuple[str, tuple[str, ...]], ...]
    """Each command interface with the joints; claims count while it is running."""
    command_interfaces: tuple[str, ...] = ()
    """What it requires to command: ``elbow_joint/position``."""
    state_interfaces: tuple[str, ...] = ()
    """What it requires to read, as ROS 2 names it."""
    blocked: str = ""
    """Why it cannot be started: its arm is in a protective stop, powered off, or taken
    by another program; empty if it can."""

    @property
    def joints(self) -> frozenset[str]:
        """The joints that it drives while it is running."""
        return frozenset(joint for _, joints in self.claimed for joint in joints)


def why_not_driven(
    statuses: Sequence[ControllerStatus],
    joints: Collection[str],
    roles: Collection[Role] = (Role.TRAJECTORY,),
) -> str:
    """Return why no running controller of these roles drives ``joints``, and a remedy.

    The message is for a request that needs one.
    """
    able = [status for status in statuses if status.role in roles]
    known = frozenset[str]().union(*(status.joints for status in able))
    names = ", ".join(f"'{joint}'" for joint in joints)
    problem = (
        f"no running {' or '.join(KIND_OF[role] for role in roles)} drives {names}"
    )
    stopped = next((s for s in able if s.joints.issuperset(joints)), None)
    if stopped is None:
        unknown = next((joint for joint in joints if joint not in known), "")
        return problem + (did_you_mean(unknown, known) if unknown else "")
    name = stopped.name
    if stopped.blocked:
        return f"{problem}: {stopped.blocked}"
    for other in statuses:
        if other.is_running and other.joints & stopped.joints:
            return (
                f"{problem}: '{other.name}' is running instead of '{name}'; switch "
                f"with `tool0 controllers switch --stop {other.name} --start {name}` "
                f"or robot.switch(start=['{name}'], stop=['{other.name}'])"
            )
    return (
        f"{problem}: controller '{name}' is {stopped.state}; start it with "
        f"{start_command(name)}"
    )


def start_command(name: str) -> str:
    """Return how to start a loaded controller, for a message."""
    return f"`tool0 controllers start {name}` or robot.switch(start=['{name}'])"
