"""A batch beside single bring-ups that get the same commands, copy by copy.

And MuJoCo Warp in tests: where it is installed, and on which device.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import final

import numpy as np
import pytest
from numpy.typing import NDArray

import tool0
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.drive_limits import DriveLimits
from tool0.description.parts import find_grippers
from tool0.description.scene_state import ObjectState
from tool0.motion.gripper import direct_path
from tool0.protocol.controllers import Role
from tool0.scene import Box, Scene, SceneObject
from tool0.simulation.core import Core
from tool0.simulation.paths import trajectory_points

Array = NDArray[np.float64]
DEVICE = "TOOL0_TEST_DEVICE"
"""Names the device of the tests that simulate on it: ``cuda``, or ``warp:cpu``."""


@final
class Beside:
    """A batch and one bring-up for each copy; every method is for all of them."""

    def __init__(
        self,
        n: int,
        *,
        description: tool0.DescriptionConfig = tool0.DescriptionConfig(),
        control: tool0.ControlConfig | None = None,
        scene: Scene | str | Sequence[Scene] | None = None,
        dt: float = 0.001,
        threads: int | None = None,
    ) -> None:
        control = control or tool0.ControlConfig()
        self._stack = ExitStack()
        self.batch = self._stack.enter_context(
            tool0.Batch(
                n,
                description=description,
                control=control,
                scene=scene,
                dt=dt,
                threads=threads,
            )
        )
        self._start = self.batch.position
        own = isinstance(scene, Scene | str | None)
        scenes = [scene] * n if own else list(scene)
        self.robots = [
            self._stack.enter_context(
                tool0.bringup(
                    description=description,
                    control=control,
                    scene=one,
                    simulation=tool0.SimulationConfig(dt=dt),
                    realtime=False,
                )
            )
            for one in scenes
        ]

    def __enter__(self) -> Beside:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def cores(self) -> list[Core]:
        found = [robot.simulation.core for robot in self.robots]
        for core in found:
            core.sync_from_kernel()
        return found

    def command(
        self,
        positions: Array,
        *,
        velocities: Array | None = None,
        duration: float,
        joints: Sequence[str] | None = None,
        which: Sequence[int] | None = None,
    ) -> None:
        self.batch.command(
            positions,
            velocities=velocities,
            duration=duration,
            joints=joints,
            which=which,
        )
        names = self.batch.arm_joints if joints is None else joints
        for i in range(self.batch.n) if which is None else which:
            for name, columns in self._owners(names).items():
                point = tool0.TrajectoryPoint(
                    positions[i, columns].tolist(),
                    None if velocities is None else velocities[i, columns].tolist(),
                    time_from_start=duration,
                )
                self.robots[i].controller(name).command_trajectory(
                    [point], joint_names=[names[k] for k in columns]
                )

    def follow(
        self, positions: Array, times: Sequence[float], velocities: Array | None = None
    ) -> None:
        self.batch.follow(positions, times, velocities=velocities)
        names = self.batch.arm_joints
        for i, robot in enumerate(self.robots):
            for name, columns in self._owners(names).items():
                points = [
                    tool0.TrajectoryPoint(
                        positions[i, m, columns].tolist(),
                        None
                        if velocities is None
                        else velocities[i, m, columns].tolist(),
                        time_from_start=time,
                    )
                    for m, time in enumerate(times)
                ]
                robot.controller(name).command_trajectory(
                    points, joint_names=[names[k] for k in columns]
                )

    def move_gripper(
        self,
        opening: Sequence[float],
        speed: Sequence[float] | None = None,
        force: Sequence[float] | None = None,
        gripper: str | None = None,
    ) -> None:
        self.batch.move_gripper(opening, speed=speed, force=force, gripper=gripper)
        found = find_grippers(self.robots[0].description.model)
        geometry = next(iter(found.values())) if gripper is None else found[gripper]
        for i, core in enumerate(self.cores):
            executor = self.robots[i].simulation.executor
            fastest, strongest = geometry.speed[1], geometry.force[1]
            limits = DriveLimits(
                gripper=geometry,
                speed=fastest if speed is None else speed[i],
                force=strongest if force is None else force[i],
            )
            joint = geometry.joint
            (status,) = (s for s in core.manager.list() if joint in s.joints)
            if status.role is Role.GRIPPER:
                most = None if force is None else core.hardware.limits[joint].effort
                target = geometry.position(opening[i])
                executor.command_gripper(status.name, target, most, limits)
                continue
            controller = executor.trajectory_controller(status.name)
            setpoint = controller.query_state(core.time)
            path = direct_path(
                geometry,
                setpoint.positions[0],
                opening[i],
                limits.speed or fastest,
                core.control_period,
            )
            goal = TrajectoryGoal(points=trajectory_points(path), joint_names=[joint])
            executor.command_trajectory(status.name, goal, {joint: limits})

    def place(self, name: str, positions: Array) -> None:
        self.batch.place(name, positions)
        for core, (x, y, z) in zip(self.cores, positions.tolist(), strict=True):
            core.scene.place(ObjectState(name, (x, y, z), (1.0, 0.0, 0.0, 0.0)))

    def reset(
        self, which: Sequence[int], position: Mapping[str, float] | None = None
    ) -> None:
        given = None
        if position is not None:
            given = self._start.copy()
            for joint, value in position.items():
                given[:, self.batch.joint_names.index(joint)] = value
        self.batch.reset(which, given)
        for i in which:
            self.robots[i].reset(position)

    def run(self, duration: float) -> None:
        self.batch.run(duration)
        for robot in self.robots:
            robot.run(duration)

    def check(self) -> None:
        """Assert that every copy is where its bring-up is, to the bit."""
        batch = self.batch
        for i, core in enumerate(self.cores):
            state = self.robots[i].snapshot
            assert batch.time[i] == core.time
            assert batch.position[i].tolist() == list(state.position), i
            assert batch.velocity[i].tolist() == list(state.velocity), i
            assert batch.effort[i].tolist() == list(state.effort), i
            for k, item in enumerate(state.objects):
                assert batch.object_position[i, k].tolist() == list(item.position)
                assert batch.object_quat[i, k].tolist() == list(item.quat_wxyz)
                assert batch.object_linear[i, k].tolist() == list(item.linear)
                assert batch.object_angular[i, k].tolist() == list(item.angular)

    def _owners(self, joints: Sequence[str]) -> dict[str, list[int]]:
        manager = self.cores[0].manager
        owners: dict[str, list[int]] = {}
        for k, joint in enumerate(joints):
            (name,) = (
                status.name
                for status in manager.list()
                if joint in status.joints and status.is_running
            )
            owners.setdefault(name, []).append(k)
        return owners


def block_between(pads: tool0.Transform, mass: float, friction: float = 1.0) -> Scene:
    """Return a block on a post, in the frame midway between the pads."""
    x, y, z = pads.position
    return Scene(
        (
            SceneObject(
                name="post",
                geometry=Box(size=(0.02, 0.02, 0.1)),
                pose=tool0.Pose(xyz=(x, y, z - 0.0701)),
            ),
            SceneObject(
                name="block",
                geometry=Box(size=(0.03, 0.03, 0.04)),
                pose=tool0.Pose(xyz=(x, y, z)),
                mass=mass,
                friction=friction,
            ),
        )
    )


def has_warp() -> bool:
    return importlib.util.find_spec("mujoco_warp") is not None


needs_warp = pytest.mark.skipif(
    not has_warp(), reason="MuJoCo Warp is not installed: pip install '.[gpu]'"
)


def device_under_test() -> str:
    """Return the device to simulate on, or skip visibly: compiling takes minutes."""
    if not has_warp():
        pytest.skip("MuJoCo Warp is not installed: pip install '.[gpu]'")
    if not (device := os.environ.get(DEVICE)):
        pytest.skip(f"set {DEVICE}=cuda, or warp:cpu; it compiles for minutes at first")
    return device
