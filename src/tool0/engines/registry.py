"""Registry of the physics engines: their names, options, abilities and constructors.

To add an engine, pass an ``EngineDefinition`` to ``register_engine``.  Only ``create``
imports the simulator.  Therefore the options are available even if the simulator is not
installed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final, final

from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.engines.real_robot.options import RealRobotOptions
from tool0.errors import ConfigError, EngineUnavailableError, did_you_mean
from tool0.hardware.engine import Engine
from tool0.installation.machine import python_package_version

HARDWARE: Final = "hardware"
"""Name of the engine for a real robot."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EngineSettings:
    """The settings that all engines have."""

    dt: float
    """Length of a physics step [s]."""
    spawn_z: float
    """Height of the robot's root above the ground [m]."""
    scene: Scene
    """Objects around the robot."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EngineDefinition:
    """The name, options and constructor of an engine."""

    options: type[Any]  # a different dataclass for each engine
    """Type of the engine's specific options: a frozen dataclass with a default for each
    field."""
    create: Callable[[RobotDescription, EngineSettings, Any], Engine]
    """Function that starts the engine, with the robot, the settings and an instance of
    ``options`` as arguments.

    The function imports the simulator.  Unsupported settings raise ConfigError, and a
    missing simulator raises EngineUnavailableError.
    """
    package: str | None = None
    """Name of the Python package with a version that affects the results; None if there
    is no such package."""
    is_deterministic: bool = False
    """Whether the same input gives bit-identical results."""
    is_real: bool = False
    """Whether the engine is a real robot instead of a simulator."""
    runs_batches: bool = False
    """Whether ``tool0.Batch`` simulates its copies with this engine."""

    def versions(self) -> dict[str, str]:
        """Return a mapping from ``package`` to its version, or an empty mapping."""
        if self.package is None:
            return {}
        return {self.package: python_package_version(self.package) or "not installed"}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class MujocoEngineOptions:
    """Options that only MuJoCo has; there are no such options at present."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GazeboEngineOptions:
    """Options that only Gazebo has."""

    world: Path | str | None = None
    """World file; None selects an empty world with the ground at z = 0."""
    gui: bool = False
    """Whether to open gzclient, the window of Gazebo."""


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


def _create_real_robot(
    description: RobotDescription,
    settings: EngineSettings,
    options: RealRobotOptions,
) -> Engine:
    from tool0.engines.real_robot.engine import RealRobotEngine

    return RealRobotEngine(
        description, ground=-settings.spawn_z, scene=settings.scene, options=options
    )


_ENGINES: Final[dict[str, EngineDefinition]] = {
    "mujoco": EngineDefinition(
        options=MujocoEngineOptions,
        create=_create_mujoco,
        package="mujoco",
        is_deterministic=True,
        runs_batches=True,
    ),
    "gazebo": EngineDefinition(options=GazeboEngineOptions, create=_create_gazebo),
    HARDWARE: EngineDefinition(
        options=RealRobotOptions, create=_create_real_robot, is_real=True
    ),
}


def engine_names() -> tuple[str, ...]:
    """Return the names of the registered simulators."""
    return tuple(name for name, engine in _ENGINES.items() if not engine.is_real)


def register_engine(name: str, definition: EngineDefinition) -> None:
    """Register an engine, or replace the engine of this name."""
    _ENGINES[name] = definition


def batch_engine() -> str:
    """Return the name of the engine that runs batches."""
    return next(name for name, engine in _ENGINES.items() if engine.runs_batches)


def engine_definition(name: str) -> EngineDefinition:
    """Return the definition of an engine.

    Raises:
        EngineUnavailableError: If there is no engine of this name.
    """
    if name not in _ENGINES:
        hint = did_you_mean(name, set(_ENGINES))
        raise EngineUnavailableError(f"unknown engine '{name}'{hint}")
    return _ENGINES[name]


def make_engine(
    name: str,
    description: RobotDescription,
    *,
    dt: float = 0.001,
    spawn_z: float = 0.0,
    scene: Scene | None = None,
    options: Mapping[str, object] | None = None,
) -> Engine:
    """Start an engine with a robot and its scene.

    Args:
        name: Name of the engine, such as one of ``engine_names()``.
        description: The robot.
        dt: Length of a physics step [s].
        spawn_z: Height of the robot's root above the ground [m].
        scene: Objects around the robot.
        options: Fields of the engine's specific options with values other than the
            defaults.

    Raises:
        EngineUnavailableError: If there is no engine of this name, or if it cannot
            start on this machine.
        ConfigError: If the engine does not have one of the ``options``, or cannot
            simulate the robot.
        ModelError: If the engine rejects the robot or an object.
    """
    definition = engine_definition(name)
    known = [field.name for field in fields(definition.options)]
    for option in options or {}:
        if option not in known:
            own = f"its options are {', '.join(known)}" if known else "it has none"
            raise ConfigError(f"engine '{name}' has no option '{option}'; {own}")
    settings = EngineSettings(dt=dt, spawn_z=spawn_z, scene=scene or Scene())
    return definition.create(
        description, settings, definition.options(**(options or {}))
    )
