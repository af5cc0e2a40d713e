"""The robot that a program holds, in this process or in another one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

from msgspec.structs import asdict

from tool0.api.channel import Channel, LocalChannel
from tool0.api.controller import ControllerHandle, GoalHandle, Gripper
from tool0.api.scene import SceneHandle
from tool0.api.sensors import CameraHandle, ForceTorque
from tool0.control.config import TYPES
from tool0.description.model import JointLimits
from tool0.errors import ControlError, RenderError, did_you_mean
from tool0.requests import motion, state
from tool0.requests.arm import ListArms
from tool0.requests.objects import ReadContacts
from tool0.requests.sensors import ListCameras
from tool0.runtime.simulation import only_part

if TYPE_CHECKING:
    from tool0.api.arm import Arm
    from tool0.control.config import ControllerConfig
    from tool0.control.manager import ControllerStatus
    from tool0.description.catalogue import RobotDescription
    from tool0.description.transform import Transform
    from tool0.hardware.engine import Contact, Engine
    from tool0.runtime.bus import Subscription
    from tool0.runtime.poses import NamedPose
    from tool0.runtime.simulation import Simulation
    from tool0.sensing.snapshot import Snapshot


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
class Robot(AbstractContextManager["Robot"]):
    """A robot in simulation.  Close it, or use it as a context manager.

    ``tool0.bringup`` returns one in this process, which ends with it;
    ``tool0.connect`` one of another process, which goes on.
    """

    def __init__(self, channel: Channel) -> None:
        self.channel = channel
        """The way to the simulation, for requests of your own: ``channel.call``."""
        self.scene = SceneHandle(channel)
        """The objects around it."""

    # ---- state ----------------------------------------------------------------------

    @cached_property
    def info(self) -> state.SimulationInfo:
        """What does not change: engine, period, ground, limits, YAML."""
        return self.channel.call(state.ReadInfo())

    @property
    def description(self) -> RobotDescription:
        """The robot as a model and as URDF."""
        return self.channel.description

    @property
    def control_period(self) -> float:
        """Simulated time of a tick [s]."""
        return self.info.control_period

    @property
    def is_realtime(self) -> bool:
        """Whether time passes by itself."""
        return self.info.is_realtime

    @property
    def joint_limits(self) -> Mapping[str, JointLimits]:
        """Limits of each driven joint: the URDF's, or those of the YAML."""
        return {
            name: JointLimits(
                **{k: v for k, v in asdict(limits).items() if v is not None}
            )
            for name, limits in self.info.joint_limits.items()
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """Findings about the controllers' YAML, such as unused keys."""
        return self.info.warnings

    @property
    def simulation(self) -> Simulation:
        """The simulation itself; ControlError if it runs in another process."""
        if not isinstance(self.channel, LocalChannel):
            raise ControlError("the simulation runs in another process")
        return self.channel.simulation

    @property
    def engine(self) -> Engine:
        """The physics itself, for scripts; touch it only between runs."""
        return self.simulation.engine

    @property
    def snapshot(self) -> Snapshot:
        """The newest state, at most one snapshot period (8 ms) old."""
        return self.channel.snapshot

    def subscribe(self, rate: float | None = None) -> Subscription:
        """Return a reader of snapshots and events.

        Args:
            rate: Snapshots per simulated second, up to 500 [Hz]; 125 if left out.
        """
        return self.channel.subscribe(rate)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        if isinstance(self.channel, LocalChannel):
            return self.channel.simulation.loop.time
        return self.snapshot.time

    @property
    def joint_state(self) -> JointValues:
        """Measured joint states."""
        snapshot = self.snapshot
        names = snapshot.joint_names
        return JointValues(
            time=snapshot.time,
            position=snapshot.positions,
            velocity=dict(zip(names, snapshot.velocity, strict=True)),
            effort=dict(zip(names, snapshot.effort, strict=True)),
        )

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contact forces of the last physics step.

        One item for each pair of links or objects that touch.  A call costs the tick
        some microseconds; the engine computes them only when asked, and Gazebo reports
        none the first time.
        """
        return self.channel.call(ReadContacts())

    def pose(self, link: str, relative_to: str | None = None) -> Transform:
        """Return the frame of ``link`` in ``relative_to``, the root if left out."""
        return self.channel.call(state.ReadLinkPose(link=link, relative_to=relative_to))

    def summary(self) -> dict[str, Any]:
        """Return the run so far as plain values that JSON can hold."""
        return self.channel.call(state.ReadSummary())

    # ---- controllers ----------------------------------------------------------------

    def controllers(self) -> tuple[ControllerStatus, ...]:
        """Return every loaded controller with its state and claims."""
        return self.channel.call(motion.ListControllers())

    @staticmethod
    def controller_types() -> tuple[str, ...]:
        """Return every type of controller that can be loaded."""
        return TYPES

    def controller(self, name: str) -> ControllerHandle:
        """Return the loaded controller ``name``, or raise ControlError."""
        names = [status.name for status in self.controllers()]
        if name not in names:
            raise ControlError(
                f"no controller '{name}' is loaded{did_you_mean(name, names)}"
            )
        return ControllerHandle(name, self.channel)

    def load(self, name: str, config: ControllerConfig | None = None) -> None:
        """Load a controller that the configuration defines, or ``config`` instead."""
        if config is None:
            self.channel.call(motion.LoadController(name=name))
        else:
            self.channel.call(motion.LoadControllerWith(name=name, config=config))

    def unload(self, name: str) -> None:
        """Unload a controller that is not running."""
        self.channel.call(motion.UnloadController(name=name))

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
            strict: Whether one impossible change refuses all; otherwise it is skipped.

        Raises:
            ControlError: If the manager refuses; nothing has changed then.
        """
        self.channel.call(
            motion.SwitchControllers(
                start=tuple(start), stop=tuple(stop), strict=strict
            )
        )

    # ---- motion ---------------------------------------------------------------------

    def move_joints(
        self,
        positions: Mapping[str, float],
        *,
        speed: float = 0.5,
        duration: float | None = None,
    ) -> tuple[GoalHandle, ...]:
        """Move joints smoothly, by the controllers that claim them.

        Args:
            positions: Joint → target [rad | m].
            speed: Fraction of each joint's largest velocity, 0.01 … 1.
            duration: Instead of a speed: how long the motion takes [simulated s].  All
                joints must belong to one controller then.

        Returns:
            A goal for each running JointTrajectoryController that has one of the
            joints; its other joints continue to where they are going.

        Raises:
            ControlError: If no such controller claims a joint, or one of them refuses;
                nothing moves then.
        """
        request = motion.MoveJoints(
            positions=dict(positions), speed=speed, duration=duration
        )
        goals = self.channel.call(request)
        return tuple(GoalHandle(goal, self.channel) for goal in goals)

    def poses(self) -> Mapping[str, NamedPose]:
        """Return the robot's own poses and the saved ones.

        Raises:
            ConfigError: If the file of saved poses cannot be read.
        """
        return self.channel.call(motion.ListPoses())

    def save_pose(self, name: str) -> None:
        """Save the measured positions of the driven joints under ``name``.

        Raises:
            ControlError: If it is the name of one of the robot's own poses, or none.
            ConfigError: If the file of saved poses cannot be read or written.
        """
        self.channel.call(motion.SavePose(name=name))

    def delete_pose(self, name: str) -> None:
        """Delete a saved pose, or raise ControlError."""
        self.channel.call(motion.DeletePose(name=name))

    def go_to_pose(self, name: str, *, speed: float = 0.5) -> tuple[GoalHandle, ...]:
        """Move every joint of a pose there, as ``move_joints`` does."""
        goals = self.channel.call(motion.GoToPose(name=name, speed=speed))
        return tuple(GoalHandle(goal, self.channel) for goal in goals)

    # ---- parts ----------------------------------------------------------------------

    @cached_property
    def grippers(self) -> Mapping[str, Gripper]:
        """The grippers that the description names."""
        return {
            geometry.name: Gripper(geometry, self.channel)
            for geometry in self.description.model.grippers
        }

    @property
    def gripper(self) -> Gripper:
        """The robot's gripper, if it has exactly one."""
        return only_part(self.grippers, "gripper", self.description.model)

    @cached_property
    def arms(self) -> Mapping[str, Arm]:
        """The arms by the prefix of their links: six revolute joints up to a tool0."""
        from tool0.api.arm import Arm  # numpy, only when needed

        infos = self.channel.call(ListArms())
        return {info.name: Arm(info, self.channel) for info in infos}

    @property
    def arm(self) -> Arm:
        """The robot's arm, if it has exactly one: poses, inverse kinematics, motion."""
        return only_part(self.arms, "arm", self.description.model)

    @property
    def force_torque(self) -> ForceTorque:
        """What the tool exerts on ``tool0``, if the robot has one link of that name."""
        return self.force_torque_of(None)

    def force_torque_of(self, link: str | None) -> ForceTorque:
        """Return what ``link`` and all beyond it exert; ModelError if there is none."""
        sensor = ForceTorque(link, self.channel)
        _ = sensor.rate  # ModelError or ControlError, if there is no such link
        return sensor

    @cached_property
    def cameras(self) -> Mapping[str, CameraHandle]:
        """The cameras by name."""
        cameras = self.channel.call(ListCameras())
        return {item.name: CameraHandle(item, self.channel) for item in cameras}

    def camera(self, name: str) -> CameraHandle:
        """Return a camera, or raise RenderError; ``image()`` of it takes a picture."""
        if name not in self.cameras:
            hint = did_you_mean(name, list(self.cameras))
            raise RenderError(f"no camera '{name}'{hint}")
        return self.cameras[name]

    # ---- time and safety ------------------------------------------------------------

    def run(self, duration: float) -> None:
        """Let ``duration`` simulated seconds pass."""
        self.channel.call(state.Run(duration=duration))

    def pause(self) -> None:
        """Hold simulated time."""
        self.channel.call(state.Pause())

    def resume(self) -> None:
        """Let simulated time run."""
        self.channel.call(state.Resume())

    def step(self, ticks: int = 1) -> None:
        """Run ``ticks`` control periods while paused."""
        self.channel.call(state.Step(ticks=ticks))

    def set_speed(self, factor: float) -> None:
        """Run at ``factor`` times real time."""
        self.channel.call(state.SetSpeed(factor=factor))

    def reset(
        self,
        position: Mapping[str, float] | None = None,
        *,
        keep_time: bool = False,
    ) -> None:
        """Return to the initial pose changed by ``position``.

        Active goals are PREEMPTED; running controllers hold the pose.  Objects return
        to where they started; removed ones stay away.

        Args:
            position: Joint → position instead of the initial one [rad | m].
            keep_time: Whether simulated time continues; otherwise it is zero again.
        """
        self.channel.call(
            state.Reset(position=dict(position or {}), keep_time=keep_time)
        )

    def emergency_stop(self, engaged: bool = True) -> None:
        """Brake every joint at once, or release the brakes.

        Goals are PREEMPTED; after the release the controllers hold where they are.
        """
        self.channel.call(state.EmergencyStop(engaged=engaged))

    def close(self) -> None:
        """End the simulation, or the connection to it; closing twice is allowed."""
        self.channel.close()

    def __exit__(self, *_: object) -> None:
        self.close()
