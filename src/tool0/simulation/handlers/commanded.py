"""Commanded positions of arms, and the controllers that command them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tool0.errors import ControlError
from tool0.protocol.controllers import Role, why_not_driven
from tool0.simulation.simulation import Simulation

if TYPE_CHECKING:
    from tool0.kinematics.chain import ArmChain
    from tool0.protocol.trajectories import TrajectoryState


def trajectory_controller(simulation: Simulation, chain: ArmChain) -> str:
    """Return the running trajectory controller of the arm's joints."""
    for status in simulation.snapshot.controllers:
        if (
            status.is_running
            and status.role is Role.TRAJECTORY
            and status.joints.issuperset(chain.joint_names)
        ):
            return status.name
    statuses = simulation.snapshot.controllers
    raise ControlError(why_not_driven(statuses, chain.joint_names))


def standing(simulation: Simulation, *arms: str | None) -> Mapping[str, float]:
    """Return the positions of all joints.

    For ``arms``, the commanded positions are returned if they are available.
    """
    positions = dict(simulation.snapshot.positions)
    for arm in arms:
        try:
            name = trajectory_controller(simulation, simulation.arm(arm))
            state = _state(simulation, name)
        except ControlError:
            continue
        positions |= zip(state.joint_names, state.desired.positions, strict=True)
    return positions


def _state(simulation: Simulation, controller: str) -> TrajectoryState:
    """Return the setpoint of a trajectory controller."""
    executor = simulation.executor
    return simulation.loop.call(
        lambda: executor.trajectory_controller(controller).setpoint().state(),
        publishes=False,
    )
