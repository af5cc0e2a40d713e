"""Planned paths as requests."""

from __future__ import annotations

from tool0.motion.path import Path
from tool0.protocol.arm_motion import ExecutePath


def path_request(
    arm: str | None, path: Path, *, after: int | None = None, at: float | None = None
) -> ExecutePath:
    """Return the request that a taken arm follows a path.

    ``after`` and ``at`` are those of the request.
    """
    accelerations = path.accelerations
    return ExecutePath(
        arm=arm,
        times=tuple(path.times.tolist()),
        positions=tuple(map(tuple, path.positions.tolist())),
        velocities=tuple(map(tuple, path.velocities.tolist())),
        accelerations=(
            () if accelerations is None else tuple(map(tuple, accelerations.tolist()))
        ),
        after=after,
        at=at,
    )
