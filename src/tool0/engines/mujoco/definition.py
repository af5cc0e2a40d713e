"""MuJoCo's entry in the registry of engines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

from tool0.description.catalogue import RobotDescription
from tool0.engines.registry import EngineDefinition, EngineSettings
from tool0.hardware.engine import Engine


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class MujocoEngineOptions:
    """MuJoCo has no options of its own."""


def _create(
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


MUJOCO: Final = EngineDefinition(options=MujocoEngineOptions, create=_create)
