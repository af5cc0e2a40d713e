"""Description of a bring-up as plain data, and a bring-up from this data."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import msgspec

from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.model import RobotModel
from tool0.description.scene import Scene
from tool0.description.shapes import Mesh, placed_geometries
from tool0.errors import Tool0Error
from tool0.protocol.objects import info_of, object_of, with_meshes
from tool0.protocol.reproduction import MeshFile, ReadReproduction, Reproduction
from tool0.simulation.bringup import start_simulation
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.handlers.table import handles
from tool0.simulation.provenance import (
    current_platform,
    current_versions,
    is_kernel_compiled,
)
from tool0.simulation.simulation import Simulation


def reproduction(simulation: Simulation) -> Reproduction:
    """Return the data that, with the journal, make this simulation repeatable."""
    setup = simulation.setup
    description, options = setup.description, setup.options
    model, choice = description.model, setup.choice
    start = simulation.core.initial_position
    placed = zip(model.movable_joints, start, strict=True)
    return Reproduction(
        versions=current_versions(options.engine),
        platform=current_platform(),
        kernel=is_kernel_compiled(),
        name=model.name,
        source=str(description.source),
        urdf=description.urdf,
        meshes=tuple(_mesh_files(model, setup.scene)),
        controllers=choice.config.yaml(),
        started=choice.started,
        loaded=choice.stopped,
        initial_position={
            joint.name: joint.limits.clamp(q)
            for joint, q in placed
            if joint.mimic is None
        },
        poses=_poses(simulation),
        scene=tuple(map(info_of, setup.scene.objects)),
        cameras=tuple(
            replace(camera, location=None) for camera in simulation.cameras.values()
        ),
        engine=options.engine,
        engine_options={
            name: value if isinstance(value, bool | int | float | None) else str(value)
            for name, value in options.engine_options.items()
        },
        dt=options.dt,
        control_period=simulation.loop.control_period,
        gravity=simulation.engine.world.gravity,
        spawn_z=options.spawn_z,
        grasp_assist=options.grasp_assist,
    )


handles(ReadReproduction)(lambda sim, _: reproduction(sim))


def restarted(
    start: Reproduction, folder: Path, meshes: Mapping[str, Path]
) -> Simulation:
    """Bring up the same robot again, without real-time pacing.

    Args:
        start: Result of ``reproduction``.
        folder: An empty folder for the files that the bring-up reads.
        meshes: Current paths of the files in ``start.meshes``, by URI.

    Raises:
        Tool0Error: If the bring-up fails, for example because the engine is missing.
    """
    from xml.sax.saxutils import escape  # this import loads ssl

    urdf, controllers = folder / "robot.urdf", folder / "controllers.yaml"
    document = start.urdf
    for uri, path in meshes.items():
        document = document.replace(f'"{escape(uri)}"', f'"{escape(str(path))}"')
    urdf.write_text(document, encoding="utf-8")
    controllers.write_text(start.controllers, encoding="utf-8")
    description = load_description(DescriptionConfig(robot=urdf), spawn_z=start.spawn_z)
    objects = (
        object_of(msgspec.structs.replace(item, shape=with_meshes(item.shape, meshes)))
        for item in start.scene
    )
    simulation = start_simulation(
        description,
        ControlConfig(
            controllers_file=controllers,
            controllers=start.started,
            stopped_controllers=start.loaded,
            initial_pose=start.initial_position,
            control_period=start.control_period,
        ),
        SimulationConfig(
            engine=start.engine,
            engine_options=start.engine_options,
            dt=start.dt,
            spawn_z=start.spawn_z,
            scene=Scene(tuple(objects)),
            grasp_assist=start.grasp_assist,
            allow_penetration=True,  # penetrations were already accepted
            realtime=False,
        ),
    )
    simulation.poses.adopt(start.poses)
    return simulation


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _mesh_files(model: RobotModel, scene: Scene) -> Iterator[MeshFile]:
    """Yield each mesh file once, with its URI in the URDF or its path in the scene."""
    files: dict[str, Path] = {}
    for link in model.links:
        shapes = [visual.geometry for visual in link.visuals]
        shapes += [collision.geometry for collision in link.collisions]
        files |= {mesh.uri: mesh.path for mesh in shapes if isinstance(mesh, Mesh)}
    for item in scene.objects:
        for part, _ in placed_geometries(item.geometry):
            if isinstance(part, Mesh):
                files[str(part.path)] = part.path
    for uri, path in files.items():
        yield MeshFile(uri=uri, path=str(path), sha256=digest(path))


def _poses(simulation: Simulation) -> dict[str, dict[str, float]]:
    try:
        poses = simulation.poses.all()
    except Tool0Error:  # the user's file is invalid; built-in poses need no file
        poses = simulation.poses.own
    return {name: dict(pose.positions) for name, pose in poses.items()}
