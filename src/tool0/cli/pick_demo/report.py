"""What came of a pick, as values for people and programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import final


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickReport:
    """One pick and place.  What was never reached is None."""

    success: bool
    failure: str | None = None
    """In which phase it failed, and why."""
    item: str
    """The object."""
    start: tuple[float, float, float]
    """Where it was, in the root [m]."""
    end: tuple[float, float, float] | None
    """Where it is [m]; None if somebody took it away."""
    force: float
    """That each pad was to exert [N]."""
    grip_force: float | None = None
    """That a pad exerted when it was lifted [N]."""
    peak_force: float
    """The largest that a pad exerted, of samples at 125 Hz: pads that meet something
    rigid have to stop their drive's rotor, too [N]."""
    width: float | None = None
    """Of what the gripper held, as its joint tells [m]."""
    slip: float | None = None
    """How far it moved between the pads while it was held, at most [m]."""
    duration: float
    """Simulated [s]."""
    phases: Mapping[str, float] = field(default_factory=dict)
    """Phase → its duration, simulated [s]."""

    def to_text(self) -> str:
        """Return it as a line for people."""
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


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DemoReport:
    """All picks of a demo, and under which conditions they were made."""

    engine: str
    gripper_model: str
    grasp_assist: bool
    """Whether objects were fixed to the gripper, which no real one does."""
    picks: tuple[PickReport, ...]
    sim_time: float
    wall_time: float
    video: str | None = None
    """The file that was written."""

    @property
    def n_succeeded(self) -> int:
        """How many ended in the bin."""
        return sum(pick.success for pick in self.picks)

    def to_json(self) -> dict[str, object]:
        """Return plain values."""
        return {**asdict(self), "succeeded": self.n_succeeded}

    def to_text(self) -> str:
        """Return what all came to, for people."""
        lines = []
        if self.grasp_assist:
            lines.append("grasp assist was on: a cheat, nothing here is grip alone")
        if self.video is not None:
            lines.append(f"video: {self.video}")
        ratio = self.sim_time / self.wall_time if self.wall_time > 0.0 else 0.0
        lines.append(
            f"{self.n_succeeded} of {len(self.picks)} in the bin; {self.engine}, "
            f"{self.gripper_model} gripper, {self.sim_time:.1f} s simulated in "
            f"{self.wall_time:.1f} s ({ratio:.1f} x real time)"
        )
        return "\n".join(lines)
