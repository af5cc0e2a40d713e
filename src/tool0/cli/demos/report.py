"""The outcome of a task, and its measurements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickReport:
    """One pick and place, or handover.  Values that were never reached are None."""

    success: bool
    """Whether the object is in the bin."""
    failure: str | None = None
    """The phase in which the task failed, and the reason; None if it succeeded."""
    item: str
    """The object."""
    start: tuple[float, float, float]
    """Start position of the object, in the root [m]."""
    end: tuple[float, float, float] | None
    """Final position [m]; None if it was removed."""
    force: float
    """Requested force at each pad [N]."""
    grip_force: float | None = None
    """Force of a pad when the object was lifted [N]."""
    peak_force: float
    """Largest force of a pad [N], sampled at 125 Hz; pads that meet a rigid object must
    also stop the rotor of their drive."""
    width: float | None = None
    """Width of the held object, from the gripper's joint [m]."""
    slip: float | None = None
    """Largest slip between the pads while it was held [m]."""
    duration: float
    """Duration of the task [simulated s]."""
    phases: Mapping[str, float] = field(default_factory=dict)
    """Phase → its duration [simulated s]."""

    def to_text(self) -> str:
        """Return the report as a readable line."""
        x, y, _ = self.start
        what = f"'{self.item}' from ({x:.3f}, {y:.3f})"
        if not self.success:
            return f"{what}: FAILED {self.failure}"
        words = [f"{what}: in the bin after {self.duration:.1f} s"]
        if self.width is not None:
            words.append(f"{1e3 * self.width:.1f} mm wide")
        if self.slip is not None:
            words.append(f"slip {1e3 * self.slip:.2f} mm")
        if self.grip_force is not None:
            words.append(f"gripped with {self.grip_force:.0f} N")
        words.append(f"peak {self.peak_force:.0f} N")
        return ", ".join(words)
