"""What a controller wants of its joints, as a frozen value that any thread may ask."""

from __future__ import annotations

from typing import Protocol

from tool0.control.trajectory import TrajectoryState


class Intent(Protocol):
    """What one controller wanted at one instant.

    Taking it costs the tick next to nothing: what it says is worked out when it is
    asked, in the thread that asks.
    """

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of every sequence here."""

    def state(self) -> TrajectoryState:
        """Return desired, actual and error at that instant."""

    def target(self) -> tuple[float, ...]:
        """Return where the joints are to end up [rad | m]."""
