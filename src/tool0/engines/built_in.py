"""Definitions of MuJoCo and Gazebo for the registry."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.description.catalogue import RobotDescription
from tool0.engines.registry import EngineDefinition, EngineSettings
from tool0.errors import ConfigError
from tool0.hardware.engine import Engine


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class MujocoEngineOptions:
    """MuJoCo has no options of its own."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GazeboEngineOptions:
    """The options that only Gazebo has."""

    world: Path | str | None = None
    """A world file; None for an empty world with the ground at z = 0."""
    gui: bool = False
    """Whether to open gzclient, Gazebo's own window."""


def _create_mujoco(
    description: RobotDescription, settings: EngineSettings, _: MujocoEngineOptions
) -> Engine:
    from tool0.engines.mujoco.gl import import_mujoco

    import_mujoco()
    from tool0.engines.mujoco.engine import MujocoEngine

    return MujocoEngine(
        description.model,
        settings.dt,
        ground=-settings.spawn_z,
        scene=settings.scene,
    )


def _create_gazebo(
    description: RobotDescription,
    settings: EngineSettings,
    options: GazeboEngineOptions,
) -> Engine:
    loops = description.model.loops
    if loops:
        raise ConfigError(
            f"Gazebo cannot simulate the loop '{loops[0].name}'; "
            "use gripper_model mimic or the engine mujoco"
        )
    from tool0.engines.gazebo.engine import GazeboEngine

    return GazeboEngine(
        description,
        settings.dt,
        spawn_z=settings.spawn_z,
        scene=settings.scene,
        world=None if options.world is None else Path(options.world),
        gui=options.gui,
    )


MUJOCO: Final = EngineDefinition(options=MujocoEngineOptions, create=_create_mujoco)
GAZEBO: Final = EngineDefinition(options=GazeboEngineOptions, create=_create_gazebo)
