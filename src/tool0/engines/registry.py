"""The physics engines by name: their options and constructors.

To add an engine, define an ``EngineDefinition`` as in ``built_in.py`` and register its
location.  Its module must import the simulator in ``create`` only, since it is also
loaded to list the engine's options.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Final, final

from tool0.description.catalogue import RobotDescription
from tool0.description.scene import Scene
from tool0.errors import ConfigError, EngineUnavailableError, did_you_mean
from tool0.hardware.engine import Engine

_LOCATIONS: Final[dict[str, str]] = {
    "mujoco": "tool0.engines.built_in:MUJOCO",
    "gazebo": "tool0.engines.built_in:GAZEBO",
}
"""Engine → module and name of its ``EngineDefinition``."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EngineSettings:
    """The settings that every engine has."""

    dt: float
    """Length of a physics step [s]."""
    spawn_z: float
    """Height of the robot's root above the ground [m]."""
    scene: Scene
    """The objects around the robot."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EngineDefinition:
    """How an engine is made."""

    options: type[Any]  # a different dataclass for each engine
    """The engine's own options: a frozen dataclass with a default for each field."""
    create: Callable[[RobotDescription, EngineSettings, Any], Engine]
    """Start the engine with a robot, from settings and an instance of ``options``.

    It imports the simulator.  It raises ConfigError for what the engine cannot do, and
    EngineUnavailableError if the simulator is missing.
    """


def engine_names() -> tuple[str, ...]:
    """Return the names of the registered engines."""
    return tuple(_LOCATIONS)


def register_engine(name: str, location: str) -> None:
    """Register or replace an engine.

    ``location`` of its ``EngineDefinition`` is ``package.module:NAME``.
    """
    _LOCATIONS[name] = location


def engine_options(name: str) -> type[Any]:  # a different dataclass for each engine
    """Return the dataclass of an engine's own options.

    Raises:
        EngineUnavailableError: If there is no such engine.
    """
    return _definition(name).options


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
        name: One of ``engine_names()``.
        description: The robot.
        dt: Length of a physics step [s].
        spawn_z: Height of the robot's root above the ground [m].
        scene: The objects around the robot.
        options: Fields of ``engine_options(name)`` that differ from their defaults.

    Raises:
        EngineUnavailableError: If there is no such engine, or it cannot start here.
        ConfigError: If the engine has no such option, or cannot simulate the robot.
        ModelError: If the engine refuses the robot or an object.
    """
    definition = _definition(name)
    known = [field.name for field in fields(definition.options)]
    for option in options or {}:
        if option not in known:
            own = f"its options are {', '.join(known)}" if known else "it has none"
            raise ConfigError(f"engine '{name}' has no option '{option}'; {own}")
    settings = EngineSettings(dt=dt, spawn_z=spawn_z, scene=scene or Scene())
    return definition.create(
        description, settings, definition.options(**(options or {}))
    )


def _definition(name: str) -> EngineDefinition:
    if name not in _LOCATIONS:
        hint = did_you_mean(name, set(_LOCATIONS))
        raise EngineUnavailableError(f"unknown engine '{name}'{hint}")
    module, _, attribute = _LOCATIONS[name].partition(":")
    definition: EngineDefinition = getattr(importlib.import_module(module), attribute)
    return definition
