"""Collision checks of arm motions before the motions begin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tool0.simulation.handlers.commanded import standing
from tool0.simulation.simulation import Simulation

if TYPE_CHECKING:
    from tool0.simulation.motion_plans import MotionPlans


def motion_plans(simulation: Simulation) -> MotionPlans:
    """Return the object that checks and plans motions of a simulation."""
    from tool0.simulation.motion_plans import MotionPlans  # loads numpy and the planner

    return simulation.service(MotionPlans)


def require_free(simulation: Simulation, targets: Mapping[str, float]) -> None:
    """Raise CollisionError if arms would collide on the way to ``targets`` [rad | m].

    The joints move synchronously, starting at their commanded positions.
    """
    arms = [
        name
        for name, chain in simulation.arms.items()
        if not targets.keys().isdisjoint(chain.joint_names)
    ]
    if arms:
        positions = standing(simulation, *arms)
        motion_plans(simulation).require_free(targets, positions)
