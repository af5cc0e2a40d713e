"""The interface between the manager and a controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from tool0.control.setpoint import Setpoint
from tool0.description.model import Interface
from tool0.hardware.joint_state import JointState


class Controller(Protocol):
    """A running controller: it exists, so it is ready; stopping drops it."""

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return a command per claimed joint, in the order of the spec's joints.

        Args:
            state: Every joint, in the engine's order.
            period: Time since the last update [s].
        """

    def setpoint(self) -> Setpoint | None:
        """Return where the joints are wanted; None if no position is.

        It is called between ticks, about a hundred times a second, so it only takes
        references to what will not change.
        """

    def stop(self) -> None:
        """End what is in progress: an active goal is PREEMPTED."""


class ControllerSpec(Protocol):
    """A loaded controller: its checked parameters, ready to be started."""

    @property
    def name(self) -> str: ...

    @property
    def type(self) -> str:
        """As in YAML: ``effort_controllers/JointTrajectoryController``."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it claims, in the order of its commands."""

    @property
    def interface(self) -> Interface | None:
        """The command interface it claims; None if it only reads."""

    @property
    def waits_for_command(self) -> bool:
        """Whether the brakes stay on from its start to its first command."""

    def start(self, indices: Sequence[int], state: JointState) -> Controller:
        """Return a running controller that holds the measured ``state``.

        Args:
            indices: Where its joints stand in the state's lists.
            state: The state at the instant of the start.
        """
