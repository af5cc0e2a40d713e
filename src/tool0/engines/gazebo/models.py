"""What is in Gazebo's world: put there, told to the bridge, taken away."""

from __future__ import annotations

import logging
import struct
from pathlib import Path
from typing import final

from tool0.description.model import RobotModel, Transmission
from tool0.description.scene import Scene
from tool0.engines.gazebo.connection import Connection, Kind, numbers, text
from tool0.engines.gazebo.couplings import Coupling
from tool0.engines.gazebo.objects import object_sdf
from tool0.engines.gazebo.server import Server
from tool0.errors import (
    DescriptionError,
    EngineError,
    EngineUnavailableError,
    SourceLocation,
)
from tool0.hardware.bodies import Matrix, transform

logger = logging.getLogger(__name__)

_OTHER_WORLD = "Falling back on"
_HALF_BUILT = "Loading model from factory message failed"
"""What gzserver says, and otherwise goes on as if nothing were."""


@final
class Models:
    """The models in the world of one gzserver."""

    def __init__(
        self, connection: Connection, server: Server, world: Path | None
    ) -> None:
        """Ask over ``connection``; ``world`` is the file of the world, for messages."""
        self._connection = connection
        self._server = server
        self._world = world

    def populate(
        self,
        model: RobotModel,
        urdf: str,
        gears: tuple[Coupling, ...],
        scene: Scene,
        root: Matrix,
    ) -> None:
        """Spawn the robot and the scene, and bind the bridge to them.

        Args:
            model: The robot.
            urdf: What libsdformat makes it of.
            gears: The couplings that are for the bridge to hold.
            scene: The objects around it.
            root: The robot's root in the world, shape (4, 4).

        Raises:
            EngineError: If Gazebo refuses one of them.
        """
        file = self._server.folder / "robot.urdf"
        file.write_text(urdf)
        self.spawn(model.name, file, root)
        for item in scene.objects:
            file = self._server.folder / f"{item.name}.sdf"
            file.write_text(object_sdf(item))
            try:
                self.spawn(item.name, file, root @ transform(item.pose))
            except EngineUnavailableError:
                raise
            except EngineError as error:
                raise EngineError(f"object '{item.name}': {error}") from error
        self._bind(model, gears, scene)

    def spawn(self, name: str, file: Path, pose: Matrix) -> None:
        """Put the model of a URDF or SDF file into the world, at ``pose`` there.

        Raises:
            EngineError: If Gazebo does not take it, or only half of it.
        """
        try:
            self._connection.spawn(name, file, pose)
        except EngineUnavailableError:
            raise
        except EngineError as error:
            raise EngineError(f"{error}{self._complaints()}") from None
        complaints = self._complaints()
        if _OTHER_WORLD in complaints:  # the first model's world, that is
            where = SourceLocation(self._world)
            raise DescriptionError(f"Gazebo cannot read this world:{complaints}", where)
        if _HALF_BUILT in complaints:
            self._connection.delete(name)
            raise EngineError(f"Gazebo cannot build '{name}':{complaints}")
        if complaints:
            logger.warning("Gazebo complains:%s", complaints)

    def _bind(
        self, model: RobotModel, gears: tuple[Coupling, ...], scene: Scene
    ) -> None:
        transmissions = model.transmission_by_joint
        names = [joint.name for joint in model.movable_joints]
        self._connection.ask(
            Kind.BIND,
            text(model.name),
            struct.pack("=I", len(names)),
            *(
                text(name)
                + numbers([_armature(transmissions.get(name)), 0.0])  # at zero now
                for name in names
            ),
            struct.pack("=I", len(gears)),
            *(
                struct.pack("=IId", gear.joint, gear.other, gear.multiplier)
                for gear in gears
            ),
            struct.pack("=I", len(scene.objects)),
            *(text(item.name) for item in scene.objects),
        )

    def _complaints(self) -> str:
        return "".join(f"\n  {line}" for line in self._server.complaints())


def _armature(transmission: Transmission | None) -> float:
    return transmission.armature if transmission else 0.0
