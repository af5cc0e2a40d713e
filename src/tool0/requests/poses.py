"""Requests about named poses."""

from __future__ import annotations

from tool0.requests.fields import Name, SpeedScale
from tool0.requests.motion import GoalStarted, MoveJoints
from tool0.requests.table import Request, answer, handles
from tool0.runtime.poses import NamedPose
from tool0.runtime.simulation import Simulation


class ListPoses(Request[dict[str, NamedPose]], frozen=True):
    """The robot's own poses and the saved ones, by name."""


class SavePose(Request[None], frozen=True):
    """Save the measured positions of the driven joints on the simulation's machine."""

    name: Name


class DeletePose(Request[None], frozen=True):
    """Delete a saved pose; the robot's own poses stay."""

    name: Name


class GoToPose(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move every joint of a named pose there, as ``MoveJoints`` does."""

    name: Name
    speed: SpeedScale = 0.5


@handles(ListPoses)
def _list(simulation: Simulation, request: ListPoses) -> dict[str, NamedPose]:
    return dict(simulation.poses.all())


@handles(SavePose)
def _save(simulation: Simulation, request: SavePose) -> None:
    model, snapshot = simulation.description.model, simulation.snapshot
    position = dict(zip(snapshot.joint_names, snapshot.position, strict=True))
    driven = [item.joint for item in model.transmissions]
    joints = model.joint_by_name
    simulation.poses.save(
        request.name,
        {joint: joints[joint].limits.clamp(position[joint]) for joint in driven},
    )


@handles(DeletePose)
def _delete(simulation: Simulation, request: DeletePose) -> None:
    simulation.poses.delete(request.name)


@handles(GoToPose)
def _go(simulation: Simulation, request: GoToPose) -> tuple[GoalStarted, ...]:
    positions = dict(simulation.poses.find(request.name).positions)
    return answer(simulation, MoveJoints(positions=positions, speed=request.speed))
