"""Makes the cores and the backend of a batch, and checks their arguments."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tool0.batch.backend import CPU, BatchBackend
from tool0.description.camera import Camera, default_cameras, merged
from tool0.description.config import File
from tool0.description.model import RobotModel
from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.description.shapes import kind_of
from tool0.engines.registry import batch_engine
from tool0.errors import ConfigError
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.core import Core
from tool0.simulation.setup import Setup, chosen_scene


def checked_count(n: int) -> int:
    """Return the number of copies, or raise ConfigError if it is not valid."""
    if not isinstance(n, int | np.integer) or isinstance(n, bool) or n < 1:
        raise ConfigError(f"a batch needs a whole number of copies, 1 or more, got {n}")
    return int(n)


def checked_threads(threads: int | None, n: int) -> int:
    """Return the number of threads for ``n`` copies (default: one per processor)."""
    if threads is None:
        return min(n, os.cpu_count() or 1)
    if not isinstance(threads, int | np.integer) or not 1 <= threads <= n:
        raise ConfigError(
            f"threads must be within 1 … {n}, the number of copies, got {threads}"
        )
    return int(threads)


def core_scenes(
    robot: RobotDescription,
    scene: Scene | File | Sequence[Scene] | None,
    n: int,
    device: str,
) -> list[Scene]:
    """Return the scene of each copy, or the common scene of all copies on a GPU.

    Raises:
        ConfigError: If the scenes differ too much.
    """
    if scene is None or isinstance(scene, Scene | str | Path):
        scenes = [chosen_scene(robot, scene)] * n
    else:
        scenes = _checked_scenes([chosen_scene(robot, one) for one in scene], n)
    if device == CPU:
        return scenes
    if any(each != scenes[0] for each in scenes):
        raise ConfigError(
            "on a GPU, all copies have the same scene; place their objects with "
            "Batch.place, or use device='cpu'"
        )
    return scenes[:1]


def checked_cameras(model: RobotModel, scene: Scene) -> Mapping[str, Camera]:
    """Return the cameras of the robot and of the scene, by name.

    Raises:
        ConfigError: If the robot does not have the link that carries a camera.
    """
    cameras = merged(default_cameras(model), scene.cameras)
    for camera in cameras.values():
        camera.check_on(model)
    return cameras


def make_cores(
    robot: RobotDescription,
    control: ControlConfig,
    scenes: Sequence[Scene],
    dt: float,
) -> list[Core]:
    """Return a core for each scene, with physics steps of ``dt`` [s]."""
    options = SimulationConfig(engine=batch_engine(), dt=dt, scene=scenes[0])
    setup = Setup.of(robot, control, options)
    setups = [replace(setup, scene=scene) for scene in scenes]
    return [each.make_core(each.make_engine()) for each in setups]


def make_backend(
    cores: list[Core], model: RobotModel, n: int, *, device: str, threads: int
) -> BatchBackend:
    """Return a backend that simulates ``n`` copies on ``device``.

    Raises:
        ConfigError: If the device cannot run a controller.
        EngineError: If there is no such device, or the device cannot simulate the
            scene.
    """
    if device == CPU:
        from tool0.batch.copies import Copies

        return Copies(cores, threads)
    from tool0.batch.device import DeviceCopies

    return DeviceCopies(cores[0], model, n, device)


def _checked_scenes(scenes: list[Scene], n: int) -> list[Scene]:
    """Return the scenes after checking the differences between copies."""
    if len(scenes) != n:
        raise ConfigError(f"give one scene for all copies, or {n}, got {len(scenes)}")
    first = scenes[0]
    for i, scene in enumerate(scenes):
        names, wanted = ([o.name for o in each.objects] for each in (scene, first))
        if names != wanted:
            raise ConfigError(
                f"scene {i} has objects {', '.join(names) or 'none'}; the first has "
                f"{', '.join(wanted) or 'none'}; they must be the same"
            )
        for item, other in zip(scene.objects, first.objects, strict=True):
            what = None
            if kind_of(item.geometry) != kind_of(other.geometry):
                what = "another shape"
            elif (item.mass is None) != (other.mass is None):
                what = "no mass" if item.mass is None else "a mass"
            if what is not None:
                raise ConfigError(
                    f"object '{item.name}' of scene {i} has {what}, unlike that of the "
                    "first; copies differ in mass, friction, pose, colour, and in the "
                    "size of boxes, cylinders and spheres only"
                )
    return scenes
