"""The facade that every edge uses: a robot with controllers, gripper and time."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import TracebackType
from typing import TYPE_CHECKING, final

from tool0.control.config import ControllerConfig
from tool0.control.controller_types import TYPES
from tool0.control.manager import ControllerStatus, Strictness
from tool0.description.camera import Camera
from tool0.description.catalogue import RobotDescription
from tool0.description.finding import Finding
from tool0.description.forward_kinematics import link_pose
from tool0.description.model import JointLimits
from tool0.description.transform import Transform
from tool0.errors import ControlError, did_you_mean
from tool0.hardware.engine import Contact, Engine
from tool0.runtime import commands as ask
from tool0.runtime.bus import Bus, Snapshot, Subscription
from tool0.runtime.gripper import Gripper
from tool0.runtime.handles import ControllerHandle, GoalHandle
from tool0.runtime.joint_motion import import_planner
from tool0.runtime.loop import Loop
from tool0.runtime.poses import NamedPose, PoseBook
from tool0.runtime.scene import SceneHandle
from tool0.runtime.summary import summarize
from tool0.sensing.cameras import CameraHandle, Cameras, find_camera
from tool0.sensing.force_torque import ForceTorque, ForceTorques

if TYPE_CHECKING:
    from tool0.runtime.arm import Arm


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointValues:
    """Joint states by name, as ROS's sensor_msgs/JointState."""

    time: float
    """Simulated time [s]."""
    position: Mapping[str, float]
    """[rad | m]"""
    velocity: Mapping[str, float]
    """[rad/s | m/s]"""
    effort: Mapping[str, float]
    """[N·m | N]"""


@final
class Robot:
    """A robot in simulation.  Close it, or use it as a context manager."""

    def __init__(
        self,
        *,
        description: RobotDescription,
        engine: Engine,
        loop: Loop,
        bus: Bus,
        poses: PoseBook,
        defined_controllers: Mapping[str, str],
        parameters: Mapping[str, object],
        joint_limits: Mapping[str, JointLimits],
        spawn_z: float = 0.0,
        ground: float | None = None,
        grasp_assist: bool = False,
        cameras: Mapping[str, Camera],
        warnings: Sequence[Finding] = (),
    ) -> None:
        self.description = description
        self.engine = engine
        """The physics itself, for scripts; touch it only between runs."""
        self.spawn_z = spawn_z
        """Height of the robot's root above the world's origin [m]."""
        self.ground = ground
        """Height of the ground [m], in the robot's root; None if there is none."""
        self.grasp_assist = grasp_assist
        """Whether what a gripper grips is fixed to it: a cheat."""
        self.warnings = tuple(warnings)
        """What the controllers' YAML says that nothing reads."""
        self.defined_controllers = defined_controllers
        """The type of each controller of the YAML, loaded or not, in its order."""
        self.parameters = parameters
        """The whole YAML, as plain values."""
        self.joint_limits = joint_limits
        """Of each driven joint: the URDF's, or what the YAML puts in their place."""
        self.cameras = Cameras(
            description.model, cameras, ground, lambda: self.snapshot
        )
        """What looks at it, by name; see ``camera``."""
        self._poses = poses
        self._loop = loop
        self._bus = bus
        self._wall_start = time.perf_counter()
        self.scene = SceneHandle(loop, lambda: self.snapshot)
        """What is around it: objects that come, go and are put somewhere."""
        self._force_torques = ForceTorques(
            description,
            joint_names=engine.joint_names,
            dt=engine.dt,
            gravity=engine.gravity,
            loop=loop,
        )
        self._grippers = {
            gripper.name: Gripper(gripper, self, loop, bus)
            for gripper in description.model.grippers
        }

    @property
    def snapshot(self) -> Snapshot:
        """The newest state on the bus, at most 8 ms of simulated time old."""
        snapshot = self._bus.latest
        if snapshot is None:  # the loop publishes one before a Robot can exist
            raise ControlError("nothing was published yet")
        return snapshot

    def subscribe(self) -> Subscription:
        """Return a reader of snapshots and events."""
        return self._bus.subscribe()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._loop.time

    @property
    def joint_state(self) -> JointValues:
        snapshot = self.snapshot
        names = snapshot.joint_names
        return JointValues(
            time=snapshot.time,
            position=dict(zip(names, snapshot.position, strict=True)),
            velocity=dict(zip(names, snapshot.velocity, strict=True)),
            effort=dict(zip(names, snapshot.effort, strict=True)),
        )

    def contacts(self) -> tuple[Contact, ...]:
        """Return what presses on what, and how hard, in the last step of the physics.

        One item for each pair of links or objects that touch.  Asking costs some
        microseconds of the tick; the engine works nothing out while nobody asks, and
        Gazebo tells none the first time that somebody does.
        """
        contacts: tuple[Contact, ...] = self._loop.call(ask.ReadContacts())
        return contacts

    def pose(self, link: str, relative_to: str | None = None) -> Transform:
        """Return the frame of ``link`` in ``relative_to``, the root if left out."""
        return link_pose(
            self.description.model,
            self.joint_state.position,
            link,
            relative_to=relative_to,
        )

    def controllers(self) -> tuple[ControllerStatus, ...]:
        """Return every loaded controller with its state and claims."""
        return self.snapshot.controllers

    @staticmethod
    def controller_types() -> tuple[str, ...]:
        """Return every type of controller that can be loaded."""
        return TYPES

    @property
    def control_period(self) -> float:
        """Simulated time of a tick [s]."""
        return self._loop.control_period

    @property
    def is_realtime(self) -> bool:
        """Whether time passes by itself."""
        return self._loop.is_realtime

    def controller(self, name: str) -> ControllerHandle:
        """Return the loaded controller ``name``, or raise ControlError."""
        names = [status.name for status in self.controllers()]
        if name not in names:
            raise ControlError(
                f"no controller '{name}' is loaded{did_you_mean(name, names)}"
            )
        return ControllerHandle(name, self._loop)

    def load(self, name: str, config: ControllerConfig | None = None) -> None:
        """Load a controller that the configuration defines, or ``config`` instead."""
        self._loop.call(ask.LoadController(name, config))

    def unload(self, name: str) -> None:
        """Unload a controller that does not run."""
        self._loop.call(ask.UnloadController(name))

    def switch(
        self,
        start: Sequence[str] = (),
        stop: Sequence[str] = (),
        *,
        strict: bool = True,
    ) -> None:
        """Stop and start controllers at one instant.

        Args:
            start: Controllers to start.
            stop: Controllers to stop.
            strict: Whether one impossible wish refuses all; otherwise it is skipped.

        Raises:
            ControlError: If the manager refuses; nothing has changed then.
        """
        strictness = Strictness.STRICT if strict else Strictness.BEST_EFFORT
        self._loop.call(
            ask.SwitchControllers(
                start=tuple(start), stop=tuple(stop), strictness=strictness
            )
        )

    def move_joints(
        self, positions: Mapping[str, float], *, speed: float = 0.5
    ) -> tuple[GoalHandle, ...]:
        """Send joints somewhere smoothly, by the controllers that claim them.

        Args:
            positions: Joint → where to [rad | m].
            speed: Part of each joint's largest velocity, 0.01 … 1.

        Returns:
            A goal for each running JointTrajectoryController that has one of the
            joints; its other joints go on to where they are going, or stay.

        Raises:
            ControlError: If no such controller claims a joint, or one of them refuses;
                nothing moves then.
        """
        import_planner()
        goals = self._loop.call(ask.MoveJoints(positions=dict(positions), speed=speed))
        return tuple(GoalHandle(goal, self._loop) for goal in goals)

    def poses(self) -> Mapping[str, NamedPose]:
        """Return the robot's own poses and those that a person saved.

        Raises:
            ConfigError: If the file of saved poses cannot be read.
        """
        return self._poses.all()

    def save_pose(self, name: str) -> None:
        """Keep the measured positions of the driven joints under ``name``.

        Raises:
            ControlError: If it is the name of one of the robot's own poses, or none.
            ConfigError: If the file of saved poses cannot be read or written.
        """
        position = self.joint_state.position
        driven = [item.joint for item in self.description.model.transmissions]
        joints = self.description.model.joint_by_name
        self._poses.save(
            name,
            {joint: joints[joint].limits.clamp(position[joint]) for joint in driven},
        )

    def delete_pose(self, name: str) -> None:
        """Forget a saved pose, or raise ControlError."""
        self._poses.delete(name)

    def go_to_pose(self, name: str, *, speed: float = 0.5) -> tuple[GoalHandle, ...]:
        """Send every joint of a pose there, as ``move_joints`` does."""
        return self.move_joints(self._poses.find(name).positions, speed=speed)

    @property
    def grippers(self) -> Mapping[str, Gripper]:
        """The grippers that the description names."""
        return self._grippers

    @property
    def gripper(self) -> Gripper:
        """The robot's gripper, if it has exactly one."""
        if len(self._grippers) != 1:
            names = ", ".join(self._grippers) or "none"
            raise ControlError(
                f"'gripper' needs exactly one gripper, this robot has: {names}"
            )
        return next(iter(self._grippers.values()))

    @property
    def force_torque(self) -> ForceTorque:
        """What the tool exerts on ``tool0``, if the robot has one link of that name."""
        return self._force_torques.at_tool0()

    def force_torque_of(self, link: str) -> ForceTorque:
        """Return what ``link`` and all beyond it exert on what carries it.

        Raises:
            ModelError: If there is no such link.
        """
        return self._force_torques.at(link)

    @cached_property
    def arms(self) -> Mapping[str, Arm]:
        """The arms: six turning joints that end at a link ``…tool0``, by its prefix."""
        from tool0.runtime.arms import find_arms  # numpy and more, for who asks

        return find_arms(self)

    @property
    def arm(self) -> Arm:
        """The robot's arm, if it has exactly one: poses, inverse kinematics, motion."""
        from tool0.runtime.arms import the_arm

        return the_arm(self, self.arms)

    def camera(self, name: str) -> CameraHandle:
        """Return a camera, or raise RenderError; ``image()`` of it takes a picture."""
        return find_camera(self.cameras, name)

    def run(self, duration: float) -> None:
        """Let ``duration`` simulated seconds pass."""
        if not duration >= 0.0:
            raise ControlError(f"duration must be at least 0 s, got {duration}")
        self._loop.run(duration)

    def pause(self) -> None:
        self._loop.call(ask.SetPaused(True))

    def resume(self) -> None:
        self._loop.call(ask.SetPaused(False))

    def step(self, ticks: int = 1) -> None:
        """Run ``ticks`` control periods while paused."""
        self._loop.call(ask.Step(ticks))

    def set_speed(self, factor: float) -> None:
        """Run at ``factor`` times real time."""
        self._loop.call(ask.SetSpeed(factor))

    def reset(
        self,
        position: Mapping[str, float] | None = None,
        *,
        keep_time: bool = False,
    ) -> None:
        """Start again in the initial pose changed by ``position``.

        Active goals are PREEMPTED; running controllers run on and hold the pose.
        Objects go where they began; those that were deleted stay away.

        Args:
            position: Joint → where to, besides the initial pose [rad | m].
            keep_time: Whether simulated time goes on; otherwise it is zero again.
        """
        self._loop.call(ask.Reset(position=dict(position or {}), keep_time=keep_time))

    def emergency_stop(self, engaged: bool = True) -> None:
        """Brake every joint at once, or release the brakes.

        Goals are PREEMPTED; after the release the controllers hold where they are.
        """
        self._loop.call(ask.EmergencyStop(engaged))

    def summary(self) -> dict[str, object]:
        """Return the run so far as plain values that JSON can hold."""
        return summarize(
            self, self._loop, wall_time=time.perf_counter() - self._wall_start
        )

    def close(self) -> None:
        """End the simulation; closing twice is allowed."""
        try:
            self.cameras.close()
        finally:
            self._loop.close()

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
