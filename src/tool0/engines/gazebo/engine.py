"""Gazebo behind the Engine port."""

from __future__ import annotations

import contextlib
import math
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import final

from tool0.description.catalogue import RobotDescription
from tool0.description.model import Pose, Vector3
from tool0.description.scene import Scene, SceneObject
from tool0.engines.gazebo.connection import (
    Connection,
    Kind,
    Listener,
    numbers,
    pose_bytes,
)
from tool0.engines.gazebo.couplings import couplings
from tool0.engines.gazebo.model import body_poses, gazebo_urdf
from tool0.engines.gazebo.models import Models
from tool0.engines.gazebo.server import Server
from tool0.engines.gazebo.touches import Names
from tool0.engines.gazebo.window import require_window
from tool0.engines.gazebo.world import EMPTY_WORLD, check_model, check_world
from tool0.errors import (
    ConfigError,
    DivergenceError,
    EngineUnavailableError,
)
from tool0.hardware.bodies import check_masses, moving_bodies, transform
from tool0.hardware.engine import Contact, ObjectState
from tool0.hardware.joint_state import JointState
from tool0.installation.gazebo.installation import find_installation
from tool0.installation.gazebo.plugin import bridge_libraries

START_PATIENCE = 30.0
"""[s] until gzserver has loaded the bridge; a cold disk takes ten."""


@final
class GazeboEngine:
    """One robot and its scene in a gzserver of our own, step by step with the loop."""

    name = "gazebo"

    def __init__(
        self,
        description: RobotDescription,
        dt: float = 0.001,
        *,
        spawn_z: float = 0.0,
        scene: Scene | None = None,
        world: Path | None = None,
        gui: bool = False,
    ) -> None:
        """Start gzserver and put the robot and what is around it into its world.

        Args:
            description: The robot.
            dt: Length of a step [s].
            spawn_z: Height of the robot's root above the world's origin [m].
            scene: The objects around it; None for none.
            world: A world file; None for an empty one with the ground at z = 0.
            gui: Whether to open gzclient.

        Raises:
            EngineUnavailableError: If there is no Gazebo, or it does not start.
            EngineError: If Gazebo refuses the robot or an object.
        """
        if not 0.0 < dt < math.inf:
            raise ConfigError(f"the step must be above 0 s and finite, got {dt}")
        if world is not None:
            check_world(world)
        model = description.model
        self._world = world
        self._model = model
        self._bodies = moving_bodies(model)
        check_masses(model, self._bodies)
        self._joint_names = tuple(joint.name for joint in model.movable_joints)
        self._root = transform(Pose(xyz=(0.0, 0.0, spawn_z)))
        self._dt = dt
        self._steps = 0
        self._objects: tuple[ObjectState, ...] = ()
        n = len(self._joint_names)
        self._effort = [0.0] * n
        self._pack_step = struct.Struct(f"=I{n}d").pack
        state = struct.Struct(f"={2 * n}d")
        self._unpack_state, self._state_size = state.unpack_from, state.size
        self._broken = ""
        self._stepped = False
        at_zero = body_poses(self._bodies, [0.0] * n)
        held = couplings(model, self._bodies, at_zero)
        gears = tuple(c for c in held if not c.is_gearbox)
        urdf = gazebo_urdf(description.urdf, model, self._bodies, held)
        installation = find_installation()
        if gui:
            require_window(installation)  # before seconds are spent on the rest
        self.server = Server(installation, bridge_libraries(installation))
        with contextlib.ExitStack() as failed:
            failed.callback(self.server.close)
            self._connection, self.version = self._start(gui)
            failed.callback(self._connection.close)
            names = Names(model, self._bodies, own_world=world is None)
            self._models = Models(
                self._connection, self.server, world, self._root, names
            )
            self._gravity = self._models.populate(model, urdf, gears, scene or Scene())
            self.reset([0.0] * n)
            if gui:
                self.server.open_window()
            failed.pop_all()

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self._joint_names

    @property
    def dt(self) -> float:
        return self._dt

    @property
    def gravity(self) -> Vector3:
        """As the world had it when the robot came [m/s²]."""
        return self._gravity

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        """Put joints at ``position`` [rad | m], at rest, and objects where they began.

        Args:
            position: Of each joint.
            time: Simulated time then [s], a whole number of steps.
        """
        self._await_step()
        self._steps = round(time / self._dt)
        poses = body_poses(self._bodies, list(position))
        answer = self._connection.ask(
            Kind.RESET,
            numbers([self._steps * self._dt, *position]),
            *(pose_bytes(self._root @ pose) for pose in poses),
            self._models.start_poses(),
        )
        self._take_state(answer)
        self._effort = [0.0] * len(self._joint_names)

    def read(self) -> JointState:
        """Return the measured state, or raise DivergenceError."""
        if self._stepped:
            self._await_step()
        values, n = self._numbers, len(self._joint_names)
        time = self._steps * self._dt
        if not math.isfinite(sum(values)):
            kind, _, name = self._broken.partition(" ")
            raise DivergenceError(name, time, kind=kind)
        return JointState(time, list(values[:n]), list(values[n:]), self._effort)

    def write(self, effort: Sequence[float]) -> None:
        """Hold ``effort`` [N·m | N] until the next call, or raise DivergenceError."""
        held = list(effort)
        if not math.isfinite(sum(held)):
            worst = next((i for i, u in enumerate(held) if not math.isfinite(u)), 0)
            name = self._joint_names[worst]
            raise DivergenceError(name, self._steps * self._dt, "effort")
        self._effort = held

    def step(self) -> None:
        """Advance simulated time by ``dt``; ``read`` waits until Gazebo has."""
        if self._stepped:
            self._await_step()
        self._connection.send(self._pack_step(Kind.STEP, *self._effort))
        self._stepped = True
        self._steps += 1

    def object_states(self) -> tuple[ObjectState, ...]:
        """Return how the objects are now.

        If Gazebo is gone they are as they were; the next step tells of the loss.
        """
        with contextlib.suppress(EngineUnavailableError):
            self._await_step()
            self._objects = self._models.object_states()
        return self._objects

    def spawn(self, item: SceneObject) -> None:
        """Put a further object into the scene, at rest; what moves goes on moving.

        Raises:
            ModelError: If it is a mesh that cannot be read, or is to move and encloses
                nothing.
            EngineError: If the name is taken, or Gazebo does not take it.
        """
        self._await_step()
        self._models.spawn(item)

    def spawn_file(self, name: str, file: Path, pose: Pose) -> None:
        """Put the model of a person's URDF or SDF file into the world.

        Args:
            name: What it is called there.
            file: The file.
            pose: Where, in the robot's root.

        Raises:
            DescriptionError: If the file is no XML with a model in it.
            EngineError: If Gazebo does not take it.
        """
        check_model(file)
        self._await_step()
        self._models.spawn_file(name, file.resolve(), pose)

    def delete(self, name: str) -> None:
        """Take an object of the scene, or another model, out of the world.

        Raises:
            EngineError: If there is none, or it is the robot.
        """
        self._await_step()
        self._models.delete(name)

    def place(self, state: ObjectState) -> None:
        """Put an object somewhere, moving so.

        Raises:
            EngineError: If there is none, or it stands still and is to move.
        """
        self._await_step()
        self._models.place(state)

    def contacts(self) -> tuple[Contact, ...]:
        """Return the forces of the last step's contacts, one item for each pair.

        Gazebo looks at them from the first call on, so that returns none.
        """
        self._await_step()
        return self._models.contacts()

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link as it is now, until it is detached.

        Raises:
            ModelError: If there is no such link.
            EngineError: If there is no such object, it stands still, or it is
                attached already.
        """
        self._await_step()
        self._models.attach(name, link)

    def detach(self, name: str) -> None:
        """Let an object go; one that is attached to nothing is left alone."""
        self._await_step()
        self._models.detach(name)

    def close(self) -> None:
        """End gzserver, and gzclient; closing twice is allowed."""
        self._connection.close()
        self.server.close()

    def _start(self, gui: bool) -> tuple[Connection, str]:
        listener = Listener(self.server.socket_path)
        try:
            world = self._world
            if world is None:
                world = self.server.folder / "empty.world"
                world.write_text(EMPTY_WORLD)
            self.server.start(world.resolve(), has_window=gui)
            peer, version = listener.accept(self._dt, self.server.check, START_PATIENCE)
        finally:
            listener.close()
        return Connection(peer, self.server.lost), version

    def _await_step(self) -> None:
        """Take the answer to the step, if there is one to come."""
        if self._stepped:
            self._stepped = False
            self._take_state(self._connection.receive())

    def _take_state(self, answer: memoryview) -> None:
        self._numbers = self._unpack_state(answer)
        if len(answer) > self._state_size:  # and the name of what is not finite
            self._broken = answer[self._state_size :].tobytes().decode()
