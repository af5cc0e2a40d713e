"""Handlers of the requests for objects around the robot."""

from __future__ import annotations

import math
from dataclasses import replace

from tool0.description.rigid_model import read_rigid_model
from tool0.description.scene import PALETTE, STILL_RGBA, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import (
    placed_geometries,
)
from tool0.description.transform import Pose, from_quaternion, to_transform
from tool0.errors import ConfigError
from tool0.protocol.objects import (
    AddModel,
    AddObject,
    ApplyWrench,
    ClearWrenches,
    FindCollisions,
    PlaceObject,
    PullLink,
    ReadContacts,
    RemoveObject,
    SpawnedModel,
    solid_of,
)
from tool0.simulation.applied_wrenches import AppliedWrench
from tool0.simulation.handlers.table import handles
from tool0.simulation.pull_springs import PullSpring
from tool0.simulation.simulation import Simulation

MOST_SHAPES = 500
"""Largest number of shapes in the scene.  Each additional shape increases the time for
adding an object."""


def _object_to_add(simulation: Simulation, request: AddObject) -> SceneObject:
    """Return the requested object.

    The color of the object may still change when the object is added.
    """
    rgba = STILL_RGBA if request.rgba is None else request.rgba
    item = SceneObject(
        name=request.name,
        geometry=solid_of(request.shape),
        pose=Pose(xyz=request.xyz, rpy=request.rpy),
        mass=request.mass,
        friction=request.friction,
        rgba=rgba,
    )
    _prepare(simulation, request, item)
    return item


_Placing = AddObject | AddModel | PlaceObject


def _prepare(simulation: Simulation, request: _Placing, item: SceneObject) -> None:
    """Execute the slow part of the check that the object is outside the robot."""
    if not request.allow_penetration:
        simulation.collisions.prepare(item)


def _require_outside(
    simulation: Simulation,
    request: _Placing,
    item: SceneObject,
    at: ObjectState | None = None,
) -> None:
    """Raise PenetrationError if an object would be inside a link.

    There is no error if the request allows penetrations.
    """
    if not request.allow_penetration:
        position = simulation.core.state.position
        simulation.collisions.require_outside(position, item, at)


@handles(AddObject, in_tick=True, prepare=_object_to_add)
def _add(simulation: Simulation, request: AddObject, item: SceneObject) -> None:
    if request.rgba is None and request.mass is not None:
        objects = simulation.core.scene.objects
        movable = sum(known.mass is not None for known in objects)
        item = replace(item, rgba=PALETTE[movable % len(PALETTE)])
    _spawn(simulation, request, item)


def _model_to_add(
    simulation: Simulation, request: AddModel
) -> tuple[SceneObject, SpawnedModel]:
    if not math.hypot(*request.quat_wxyz) > 0.0:
        raise ConfigError("'quat_wxyz' must not be zero")
    model = read_rigid_model(request.model)
    T_root_frame = from_quaternion(request.xyz, request.quat_wxyz)
    item = model.scene_object(request.name, T_root_frame @ model.placement)
    _prepare(simulation, request, item)
    T_frame_shape = model.placement @ model.T_model_shape
    return item, SpawnedModel(
        xyz=T_frame_shape.position, quat_wxyz=T_frame_shape.quat_wxyz
    )


@handles(AddModel, in_tick=True, prepare=_model_to_add)
def _add_model(
    simulation: Simulation, request: AddModel, model: tuple[SceneObject, SpawnedModel]
) -> SpawnedModel:
    item, spawned = model
    _spawn(simulation, request, item)
    return spawned


def _spawn(
    simulation: Simulation, request: AddObject | AddModel, item: SceneObject
) -> None:
    """Add an object.

    An error is raised if there would be too many shapes, or if the object would be
    inside a link.
    """
    scene = simulation.core.scene
    solids = [*(known.geometry for known in scene.objects), item.geometry]
    count = sum(len(placed_geometries(solid)) for solid in solids)
    if count > MOST_SHAPES:
        raise ConfigError(
            f"the objects would have {count} shapes; {MOST_SHAPES} is the most; "
            "remove some"
        )
    scene.check_names(item)
    _require_outside(simulation, request, item)
    scene.spawn(item)


handles(RemoveObject, in_tick=True)(
    lambda sim, request: sim.core.scene.delete(request.name)
)


def _state_to_place(simulation: Simulation, request: PlaceObject) -> ObjectState:
    pose = Pose(xyz=request.xyz, rpy=request.rpy)
    quat_wxyz = request.quat_wxyz or to_transform(pose).quat_wxyz
    state = ObjectState(
        request.name, request.xyz, quat_wxyz, request.linear, request.angular
    )
    for item in simulation.snapshot.scene:
        if item.name == request.name:
            _prepare(simulation, request, item)
    return state


@handles(PlaceObject, in_tick=True, prepare=_state_to_place)
def _place(simulation: Simulation, request: PlaceObject, state: ObjectState) -> None:
    scene = simulation.core.scene
    for item in scene.objects:
        if item.name == request.name and any(state.quat_wxyz):
            _require_outside(simulation, request, item, state)
    scene.place(state)


@handles(ApplyWrench, in_tick=True)
def _apply_wrench(simulation: Simulation, request: ApplyWrench) -> None:
    wrench = AppliedWrench(
        name=request.name,
        force=request.force,
        torque=request.torque,
        point=request.point,
        start=request.start,
        duration=math.inf if request.duration is None else request.duration,
    )
    simulation.core.scene.wrenches.add(wrench)


@handles(PullLink, in_tick=True, publishes=False)
def _pull_link(simulation: Simulation, request: PullLink) -> None:
    spring = PullSpring(
        link=request.name,
        point=request.point,
        target=request.target,
        stiffness=request.stiffness,
        damping=request.damping,
        max_force=request.max_force,
        duration=request.duration,
    )
    core = simulation.core
    core.pulls.pull(spring, core.state)


@handles(ClearWrenches, in_tick=True)
def _clear_wrenches(simulation: Simulation, request: ClearWrenches) -> None:
    simulation.core.pulls.release(request.name)
    simulation.core.scene.wrenches.clear(request.name)


handles(ReadContacts, in_tick=True, publishes=False)(
    lambda sim, _: sim.core.engine.world.contacts()
)
handles(FindCollisions)(
    lambda sim, request: sim.collisions.on_way(sim.snapshot, request.positions)
)
