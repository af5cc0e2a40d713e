"""Engine that simulates the robot's joints in Gazebo."""

from __future__ import annotations

import contextlib
import math
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import final

from tool0.description.bodies import check_masses, moving_bodies
from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.description.transform import Pose, pose_matrix
from tool0.engines.gazebo.connection import (
    RequestKind,
    pack_floats,
    pack_pose,
)
from tool0.engines.gazebo.robot_urdf import (
    body_poses,
    gazebo_urdf,
    mimic_constraints,
)
from tool0.engines.gazebo.sdf import EMPTY_WORLD, check_world
from tool0.engines.gazebo.server import GazeboServer
from tool0.engines.gazebo.world import GazeboServerWorld
from tool0.errors import DivergenceError, EngineError
from tool0.hardware.engine import (
    JointState,
    check_dt,
    effort_divergence,
    fastest,
    has_diverged,
)
from tool0.installation.gazebo.installation import find_installation
from tool0.installation.gazebo.plugin import bridge_libraries

_STRONGEST_BRAKE = 1e6
"""Brake torque or force of a drive that has no effort limit [N·m | N]."""


@final
class GazeboEngine:
    """An ``Engine`` with a separate gzserver in lockstep with the control loop."""

    name = "gazebo"
    stepper = None
    has_rotors = False

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
        """Start gzserver, and spawn the robot and its scene.

        ``EngineSettings`` and ``GazeboEngineOptions`` describe the arguments.

        Raises:
            EngineUnavailableError: If Gazebo is not installed, or does not start.
            EngineError: If Gazebo rejects the robot or an object.
        """
        check_dt(dt)
        if world is not None:
            check_world(world)
        model = description.model
        self._bodies = moving_bodies(model)
        check_masses(model, self._bodies)
        self.joint_names = tuple(joint.name for joint in model.movable_joints)
        self._root = pose_matrix(Pose(xyz=(0.0, 0.0, spawn_z)))
        self.dt = dt
        self._steps = 0
        n = len(self.joint_names)
        self._effort = [0.0] * n
        self._pack_step = struct.Struct(f"=I{n}d").pack
        state = struct.Struct(f"={2 * n}d")
        self._unpack_state, self._state_size = state.unpack_from, state.size
        self._diverged = ""
        self._is_stepping = False
        constraints = mimic_constraints(model, self._bodies)
        urdf = gazebo_urdf(description.urdf, model, self._bodies, constraints)
        installation = find_installation()
        libraries = bridge_libraries(installation)
        file = (world or EMPTY_WORLD).resolve()
        self.server = GazeboServer(
            installation,
            libraries,
            file,
            gui=gui,
            renders=world is not None or "<sensor" in urdf,
        )
        with contextlib.ExitStack() as failed:
            failed.callback(self.server.close)
            self._connection = self.server.connect(dt)
            failed.callback(self._connection.close)
            self.world = GazeboServerWorld(
                self._connection,
                self.server,
                model,
                self._bodies,
                urdf=urdf,
                gears=[c for c in constraints if not c.is_gearbox],
                root=self._root,
                scene=scene or Scene(),
                world_file=world,
                finish_step=self._finish_step,
            )
            self.reset([0.0] * n)
            self.server.open_window()
            failed.pop_all()

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        self._finish_step()
        self._steps = round(time / self.dt)
        poses = body_poses(self._bodies, list(position))
        answer = self._connection.request(
            RequestKind.RESET,
            pack_floats([self._steps * self.dt, *position]),
            *(pack_pose(self._root @ pose) for pose in poses),
            self.world.start_poses(),
        )
        self._take_state(answer)
        self._effort = [0.0] * len(self.joint_names)

    def read(self) -> JointState:
        if self._is_stepping:
            self._finish_step()
        values, n = self._state, len(self.joint_names)
        time = self._steps * self.dt
        velocity = list(values[n:])
        if not math.isfinite(sum(values)):
            kind, _, name = self._diverged.partition(" ")
            raise DivergenceError(name, time, kind=kind)
        if has_diverged(velocity):
            raise DivergenceError(self.joint_names[fastest(velocity)], time)
        return JointState(time, list(values[:n]), velocity, self._effort)

    def write(self, effort: Sequence[float]) -> None:
        held = list(effort)
        if not math.isfinite(sum(held)):
            raise effort_divergence(self.joint_names, held, self._steps * self.dt)
        self._effort = held

    def set_brakes(self, torques: Mapping[int, float]) -> None:
        self._finish_step()
        joints = range(len(self.joint_names))
        values = [min(torques.get(i, 0.0), _STRONGEST_BRAKE) for i in joints]
        self._connection.request(RequestKind.BRAKES, pack_floats(values))

    def set_rotors(self, inertias: Mapping[int, float]) -> None:
        if inertias:
            raise EngineError("Gazebo's joints have no rotors")

    def step(self) -> None:
        """Start a step of ``dt``; ``read`` waits for the result of the step."""
        if self._is_stepping:
            self._finish_step()
        self._connection.send(self._pack_step(RequestKind.STEP, *self._effort))
        self._is_stepping = True
        self._steps += 1

    def close(self) -> None:
        """End gzserver and gzclient; closing twice is allowed."""
        self._connection.close()
        self.server.close()

    def _finish_step(self) -> None:
        """Receive the state after the step, if a step is pending."""
        if self._is_stepping:
            self._is_stepping = False
            self._take_state(self._connection.receive())

    def _take_state(self, answer: memoryview) -> None:
        self._state = self._unpack_state(answer)
        # If an item has values that are not finite, the answer also contains its name.
        if len(answer) > self._state_size:
            self._diverged = answer[self._state_size :].tobytes().decode()
