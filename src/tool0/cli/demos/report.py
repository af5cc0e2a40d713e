"""The outcome and the measurements of a task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickReport:
    """Report of one pick and place, or of one handover.

    A value is None if the task failed before the value could be measured.
    """

    success: bool
    """Whether the object is in the bin at the end."""
    failure: str | None = None
    """The phase in which the task failed, and the reason; None if it succeeded."""
    item: str
    """Name of the object."""
    start: tuple[float, float, float]
    """Start position of the object, in the root frame [m]."""
    end: tuple[float, float, float] | None
    """Final position of the object, in the root frame [m]; None if it was removed."""
    force: float
    """Requested force at each pad [N]."""
    grip_force: float | None = None
    """Force of a pad on the object at the beginning of the lift [N]."""
    peak_force: float
    """Largest force of a pad on the object [N], sampled at 125 Hz.  When the pads meet
    a rigid object, the deceleration of the drive's rotor adds to this force."""
    width: float | None = None
    """Width of the held object, calculated from the position of the gripper's joint
    [m]."""
    slip: float | None = None
    """Largest slip of the object between the pads while it was held [m]."""
    duration: float
    """Duration of the task [simulated s]."""
    phases: Mapping[str, float] = field(default_factory=dict)
    """Phase → duration of the phase [simulated s]."""

    def to_text(self) -> str:
        """Return the report as a line of text."""
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
