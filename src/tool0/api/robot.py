"""The robot in the Python API, in this process or in another process."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from tool0.api.controller import ControllerHandle, GoalHandle
from tool0.api.gripper import Gripper
from tool0.api.parts import Parts
from tool0.api.scene import SceneHandle
from tool0.api.sensors import CameraHandle, ForceTorque
from tool0.description.model import JointLimits
from tool0.description.parts import find_grippers
from tool0.errors import ControlError, RenderError, RequestError, did_you_mean
from tool0.kinematics.only_part import only_part
from tool0.protocol.arm import ListArms
from tool0.protocol.channel import Channel, backend_of
from tool0.protocol.controllers import (
    ConfigureController,
    ListControllers,
    ListControllerTypes,
    LoadController,
    SwitchControllers,
    UnloadController,
)
from tool0.protocol.motion import MoveJoints
from tool0.protocol.objects import (
    ApplyWrench,
    ClearWrenches,
    FindCollisions,
    ReadContacts,
)
from tool0.protocol.planning import CancelPlanning, ExecutePlan, Plan, PlanMotion
from tool0.protocol.poses import DeletePose, GoToPose, ListPoses, SavePose
from tool0.protocol.request import CollisionRule, checked_path, checked_value
from tool0.protocol.robot import ReadInfo, ReadLinkPose, ReadSummary, SimulationInfo
from tool0.protocol.running import (
    EmergencyStop,
    Pause,
    Reset,
    Resume,
    Run,
    SetSpeed,
    Step,
)
from tool0.protocol.sensors import ListCameras

if TYPE_CHECKING:
    from pathlib import Path

    from typing_extensions import Unpack

    from tool0.api.arm import Arm, PlanOptions
    from tool0.api.episodes import EpisodesHandle
    from tool0.api.programs import ProgramHandle, Programs
    from tool0.api.recording import Recording
    from tool0.control.config import ControllerConfig
    from tool0.description.named_pose import NamedPose
    from tool0.description.robot import RobotDescription
    from tool0.description.scene_state import Contact
    from tool0.description.transform import Transform
    from tool0.hardware.engine import Engine
    from tool0.protocol.bus import Subscription
    from tool0.protocol.controllers import ControllerStatus
    from tool0.protocol.objects import Collision
    from tool0.protocol.planning import PlanTarget
    from tool0.protocol.program import Program
    from tool0.protocol.recordings import RecordingStatus
    from tool0.protocol.state import Snapshot
    from tool0.simulation.simulation import Simulation


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointValues:
    """Joint states by name, like sensor_msgs/JointState in ROS."""

    time: float
    """Simulated time [s]."""
    position: Mapping[str, float]
    """Positions [rad | m]."""
    velocity: Mapping[str, float]
    """Velocities [rad/s | m/s]."""
    effort: Mapping[str, float]
    """Efforts [N·m | N]."""


@final
class Robot(AbstractContextManager["Robot"]):
    """A simulated or real robot; close it, or use it as a context manager.

    ``tool0.bringup`` starts a simulation in this process, and returns the robot;
    ``close`` then ends the simulation.  ``tool0.connect`` returns a robot in another
    process; ``close`` then ends only the connection.  The robots from ``bringup`` and
    ``connect`` have the same methods.

    The names of joints are the names in the URDF.  Unless stated otherwise, poses are
    in the robot's root frame, which is ``world`` for the built-in robots.  Every method
    raises TransportError if the process of the robot has ended.  Methods that wait for
    simulated time raise EngineError if the physics has failed.
    """

    def __init__(self, channel: Channel) -> None:
        """Create a handle for the robot at the other end of ``channel``."""
        self._channel = channel
        self._scene = SceneHandle(channel)

    # ---- state ----------------------------------------------------------------------

    @property
    def channel(self) -> Channel:
        """Connection to the robot for requests: ``channel.call(request)``."""
        return self._channel

    @property
    def scene(self) -> SceneHandle:
        """Handle to add, remove and place the objects around the robot."""
        return self._scene

    @property
    def info(self) -> SimulationInfo:
        """Constant properties: engine, control period, ground, limits and YAML."""
        return self._info

    @cached_property
    def _info(self) -> SimulationInfo:
        return self.channel.call(ReadInfo())

    @property
    def description(self) -> RobotDescription:
        """The robot's description: a checked model and the URDF."""
        return self.channel.description

    @property
    def control_period(self) -> float:
        """Simulated time between two updates of the controllers [s]."""
        return self.info.control_period

    @property
    def is_realtime(self) -> bool:
        """Whether simulated time passes automatically, in real time."""
        return self.info.is_realtime

    @property
    def joint_limits(self) -> Mapping[str, JointLimits]:
        """Limits of each driven joint, from the URDF or the controllers' YAML.

        The units are [rad | m] for positions, [rad/s | m/s] for velocities, and [N·m |
        N] for efforts.
        """
        return {name: found.limits for name, found in self.info.joint_limits.items()}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Findings about the controllers' YAML, such as unused keys."""
        return self.info.warnings

    @property
    def simulation(self) -> Simulation:
        """The simulation of the robot, for code in the same process.

        Raises:
            ControlError: If the simulation runs in another process.
        """
        from tool0.simulation.simulation import Simulation

        states = backend_of(self.channel).states
        if not isinstance(states, Simulation):
            raise ControlError("this robot is not simulated")
        return states

    @property
    def engine(self) -> Engine:
        """The physics engine; do not use it while simulated time passes.

        Raises:
            ControlError: If the simulation runs in another process.
        """
        return self.simulation.engine

    @property
    def snapshot(self) -> Snapshot:
        """Newest state of the robot; its age is at most 8 ms of simulated time."""
        return self.channel.snapshot

    def subscribe(self, rate: float | None = None) -> Subscription:
        """Return a reader of snapshots and events.

        A reader with more than 256 unread snapshots loses the oldest; use ``record`` to
        keep all snapshots.

        Args:
            rate: Snapshots per simulated second [Hz], at most 500; the default is 125.

        Raises:
            ControlError: If ``rate`` is out of range.
        """
        checked_value("subscribe", "rate", rate, float | None)
        return self.channel.subscribe(rate)

    def record(self, rate: float = 125.0) -> Recording:
        """Start recording joint states and setpoints, until ``stop``.

        For example::

            with robot.record(rate=500) as recording:
                robot.move_joints({"elbow_joint": 1.0})[0].wait()
            recording.to_csv("motion.csv")

        Args:
            rate: Samples per simulated second [Hz], at most 500.  At a control period
                of 1 ms, the possible rates are 500, 250, 125, and 125 divided by an
                integer.  Other values are rounded up to the next possible rate.

        Raises:
            ControlError: If ``rate`` is out of range.
        """
        from tool0.api.recording import Recording

        return Recording(self.channel, rate, self.control_period)

    def start_recording(
        self,
        file: Path | str | None = None,
        *,
        overwrite: bool = False,
        max_size: int | None = None,
        max_duration: float | None = None,
        max_files: int | None = None,
        cameras: Sequence[str] = (),
        camera_rate: float = 5.0,
    ) -> RecordingStatus:
        """Record the robot to an MCAP file until ``stop_recording`` or ``close``.

        ``tool0.open_recording``, Foxglove and the tools of ROS 2 can read the file.

        Args:
            file: Path on the simulation's machine: a file with the suffix .mcap, or a
                folder; the default is the user's folder of recordings.
            overwrite: Whether to replace an existing file.
            max_size: Start a new file when the current file has this size [bytes].
            max_duration: Start a new file after this simulated time [s].
            max_files: Number of files to keep; older files are deleted.
            cameras: Names of cameras whose images are recorded.
            camera_rate: Image rate of each camera in simulated time [Hz].

        Returns:
            The state of the recording, with the path of the file.

        Raises:
            ControlError: If a recording is already in progress.
            RecordingError: If the file cannot be written.
            RenderError: If a camera cannot take images.
        """
        from tool0.protocol.recordings import StartRecording

        method = "start_recording"
        path = None if file is None else str(checked_path(method, "file", file))
        return self.channel.call(
            StartRecording(
                file=path,
                overwrite=overwrite,
                max_size=max_size,
                max_duration=max_duration,
                max_files=max_files,
                cameras=checked_value(method, "cameras", cameras, tuple[str, ...]),
                camera_rate=camera_rate,
            )
        )

    def stop_recording(self) -> RecordingStatus:
        """End the recording, and complete its file.

        Raises:
            ControlError: If no recording is in progress.
        """
        from tool0.protocol.recordings import StopRecording

        return self.channel.call(StopRecording())

    @property
    def recording(self) -> RecordingStatus | None:
        """State of the recording in progress or of the last recording, or None."""
        from tool0.protocol.recordings import ReadRecording

        return self.channel.call(ReadRecording())

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.channel.time

    @property
    def joint_state(self) -> JointValues:
        """Measured positions, velocities and efforts by joint."""
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

        There is one item for each pair of links or objects in contact, with force [N],
        torque [N·m] and point [m] in the robot's root frame.  The engine computes
        contacts only on request.  With Gazebo, the first call returns no contacts.
        """
        return self.channel.call(ReadContacts())

    def find_collisions(self, positions: Mapping[str, float]) -> tuple[Collision, ...]:
        """Return the collisions at a target posture and on the path to it.

        On the path, all joints move synchronously from their current positions, and an
        object in a gripper moves with it.  A pair that already overlaps at least as
        deeply at present is left out.  The collision shapes are those of MuJoCo, even
        with Gazebo.

        For example::

            for each in robot.find_collisions({"shoulder_lift_joint": 0.2}):
                print(each.first, each.second, each.depth, each.begins)

        Args:
            positions: Joint → target [rad | m]; the other joints keep their positions.

        Raises:
            ModelError: If a joint is unknown, if a position is outside the joint's
                limits, or if MuJoCo does not support a shape.
        """
        return self.channel.call(
            FindCollisions(positions=positions)  # type: ignore[arg-type]
        )

    def apply_wrench(
        self,
        name: str,
        *,
        force: Sequence[float] = (0.0, 0.0, 0.0),
        torque: Sequence[float] = (0.0, 0.0, 0.0),
        point: Sequence[float] | None = None,
        duration: float | None = None,
    ) -> None:
        """Start to apply a force and a torque to a link or an object.

        Args:
            name: A link or an object that can move.
            force: Force [N], with a constant direction in the robot's root frame.
            torque: Torque [N·m], with a constant direction in the robot's root frame.
            point: Initial point of action of the force, in the robot's root frame [m];
                the default is the center of mass of the body.
            duration: Duration [simulated s]; by default, it is unlimited.

        Raises:
            ControlError: If a value has the wrong number of elements, or is not finite.
            EngineError: If the link or the object does not exist, or cannot move.
        """
        self.channel.call(
            ApplyWrench(
                name=name,
                force=force,  # type: ignore[arg-type]  # any sequence: see scene.add
                torque=torque,  # type: ignore[arg-type]
                point=point,  # type: ignore[arg-type]
                duration=duration,
            )
        )

    def clear_wrenches(self, name: str | None = None) -> None:
        """Remove the wrenches of ``apply_wrench`` from one body or from all bodies."""
        self.channel.call(ClearWrenches(name=name))

    def pose(self, link: str, relative_to: str | None = None) -> Transform:
        """Return the measured pose of a link.

        Args:
            link: Name of the link.
            relative_to: Link in whose frame the pose is given; the default is the
                robot's root.

        Raises:
            ModelError: If the link does not exist.
        """
        return self.channel.call(ReadLinkPose(link=link, relative_to=relative_to))

    def summary(self) -> dict[str, Any]:
        """Return a summary of the run as JSON-compatible values.

        The summary contains the simulated and wall time [s], late ticks, controllers,
        joints, the largest drift of an uncommanded joint [rad | m], and warnings.
        """
        return self.channel.call(ReadSummary())

    # ---- controllers ----------------------------------------------------------------

    def controllers(self) -> tuple[ControllerStatus, ...]:
        """Return the status of every loaded controller, with its claimed joints."""
        return self.channel.call(ListControllers())

    def controller_types(self) -> tuple[str, ...]:
        """Return every type of controller that can be loaded."""
        types = self.channel.call(ListControllerTypes())
        return tuple(each.name for each in types)

    def controller(self, name: str) -> ControllerHandle:
        """Return a handle for a loaded controller.

        Args:
            name: Name of the controller in the YAML.

        Raises:
            ControlError: If no controller with this name is loaded.
        """
        checked_value("controller", "name", name, str)
        names = [status.name for status in self.controllers()]
        if name not in names:
            raise ControlError(
                f"no controller '{name}' is loaded{did_you_mean(name, names)}"
            )
        return ControllerHandle(name, self.channel)

    def load(self, name: str, config: ControllerConfig | None = None) -> None:
        """Load a controller without starting it.

        Args:
            name: Name of the controller in the YAML of the bring-up, or in ``config``.
            config: Different YAML that defines the controller; only for a simulation in
                this process.

        Raises:
            ControlError: If the controller is already loaded.
            ConfigError: If the YAML does not define the controller, or if its
                parameters are invalid.
        """
        if config is None:
            self.channel.call(LoadController(name=name))
            return
        from tool0.control.config import ControllerConfig
        from tool0.simulation.handlers.motion import LoadControllerWith

        if not isinstance(config, ControllerConfig):
            problem = f"'config': need a ControllerConfig, got {config!r:.80}"
            raise RequestError("load", problem)
        self.channel.call(LoadControllerWith(name=name, config=config))

    def configure(self, name: str) -> None:
        """Configure a ROS 2 controller that was loaded without being configured.

        Raises:
            ControlError: If the controller is already configured, or is not loaded.
            ConfigError: If the controller's parameters are invalid.
        """
        self.channel.call(ConfigureController(name=name))

    def unload(self, name: str) -> None:
        """Unload a controller.

        Raises:
            ControlError: If the controller is running, or is not loaded.
        """
        self.channel.call(UnloadController(name=name))

    def switch(
        self,
        start: Sequence[str] = (),
        stop: Sequence[str] = (),
        *,
        strict: bool = True,
    ) -> None:
        """Stop and start controllers at the same instant.

        Args:
            start: Controllers to start.
            stop: Controllers to stop.
            strict: Whether an impossible change rejects the whole request; otherwise,
                impossible changes are skipped.

        Raises:
            ControlError: If the controller manager refuses the request; all controllers
                then keep their states.
        """
        self.channel.call(
            SwitchControllers(
                start=start,  # type: ignore[arg-type]  # any sequence: it is checked
                stop=stop,  # type: ignore[arg-type]
                strict=strict,
            )
        )

    # ---- motion ---------------------------------------------------------------------

    def move_joints(
        self,
        positions: Mapping[str, float],
        *,
        speed: float = 0.5,
        duration: float | None = None,
        collision: CollisionRule = "refuse",
    ) -> tuple[GoalHandle, ...]:
        """Move joints smoothly through the controllers that claim them.

        Args:
            positions: Joint → target [rad | m].
            speed: Fraction of each joint's maximum velocity, 0.01 … 1.
            duration: Duration of the motion [simulated s], instead of a speed; it is
                the same for all controllers.
            collision: ``refuse`` the motion if an arm would collide on the straight
                path in joint space (the error contains the bodies and the position on
                the path), or ``ignore`` collisions.

        Returns:
            A goal for each running JointTrajectoryController that has one of the
            joints.  The other joints of the controller continue their motion.

        Raises:
            CollisionError: If an arm would collide.
            ControlError: If no JointTrajectoryController claims a joint, or if a
                controller refuses the goal; the robot then does not move.
        """
        request = MoveJoints(
            positions=positions,  # type: ignore[arg-type]  # any mapping
            speed=speed,
            duration=duration,
            collision=collision,
        )
        goals = self.channel.call(request)
        return tuple(GoalHandle(goal, self.channel) for goal in goals)

    def plan(
        self, targets: Sequence[PlanTarget], **options: Unpack[PlanOptions]
    ) -> Plan:
        """Plan a collision-free motion of several arms, without moving the robot.

        Args:
            targets: One target for each moving arm, from ``Arm.target``.
            **options: See ``Arm.plan``.

        Raises:
            Tool0Error: See ``Arm.plan``.
        """
        request = PlanMotion(targets=targets, **options)  # type: ignore[arg-type]
        return self.channel.call(request)

    def execute(self, plan: Plan) -> tuple[GoalHandle, ...]:
        """Follow a plan, and return the goal of each controller.

        A contact of one arm stops all arms.  See ``Arm.execute``.
        """
        if not isinstance(plan, Plan):
            raise RequestError("execute", f"'plan': need a Plan, got {plan!r:.80}")
        goals = self.channel.call(ExecutePlan(number=plan.number))
        return tuple(GoalHandle(goal, self.channel) for goal in goals)

    def cancel_planning(self) -> None:
        """Cancel all planning in progress; ``plan`` then raises PlanningError."""
        self.channel.call(CancelPlanning())

    def poses(self) -> Mapping[str, NamedPose]:
        """Return the built-in poses and the saved poses, by name.

        Raises:
            ConfigError: If the file of saved poses cannot be read.
        """
        return self.channel.call(ListPoses())

    def save_pose(self, name: str, *, robot: str | None = None) -> None:
        """Save the measured positions of the driven joints under ``name``.

        Args:
            name: Name of the pose.
            robot: Save only the joints of this robot; by default, the joints of all
                robots are saved.

        Raises:
            ControlError: If the name is that of a built-in pose, or is not printable.
            ConfigError: If the file of saved poses cannot be read or written.
        """
        self.channel.call(SavePose(name=name, robot=robot))

    def delete_pose(self, name: str) -> None:
        """Delete a saved pose.

        Raises:
            ControlError: If there is no pose with this name, or if the pose is built
                in.
        """
        self.channel.call(DeletePose(name=name))

    def go_to_pose(
        self,
        name: str,
        *,
        robot: str | None = None,
        speed: float = 0.5,
        collision: CollisionRule = "refuse",
    ) -> tuple[GoalHandle, ...]:
        """Move joints to a named pose, in the same way as ``move_joints``.

        A pose that contains joints of an arm does not move the gripper.  A pose that
        contains only gripper joints, such as ``open``, moves the gripper.

        Args:
            name: A built-in or saved pose.
            robot: Move only the joints of this robot; by default, the joints of all
                robots move.
            speed: Fraction of each joint's maximum velocity, 0.01 … 1.
            collision: See ``move_joints``.

        Raises:
            CollisionError: If an arm would collide.
            ControlError: If the pose does not exist, or if it cannot be reached.
        """
        request = GoToPose(name=name, robot=robot, speed=speed, collision=collision)
        goals = self.channel.call(request)
        return tuple(GoalHandle(goal, self.channel) for goal in goals)

    # ---- demonstrations -------------------------------------------------------------

    @property
    def episodes(self) -> EpisodesHandle:
        """Recorder of demonstrations, which writes episodes into a folder."""
        from tool0.api.episodes import EpisodesHandle

        return EpisodesHandle(self.channel)

    # ---- programs -------------------------------------------------------------------

    @cached_property
    def _programs(self) -> Programs:
        from tool0.api.programs import Programs

        return Programs(self.channel)

    @property
    def programs(self) -> Programs:
        """Handle for programs: to list, save, check, run and export them."""
        return self._programs

    def run_program(
        self, program: Program | Path | str, *, paused: bool = False
    ) -> ProgramHandle:
        """Check and start a program, and return a handle to wait for its end.

        Args:
            program: The program, its file (``.yaml``), or the name of a saved program.
            paused: Whether the program is paused before its first step, until ``step``
                or ``resume``.

        Raises:
            ProgramError: If a step cannot be executed; the message contains the reason,
                and the robot does not move.
            ConfigError: If the file cannot be read, or is not a program.
            ControlError: If the arm is not allowed to move, or if no program is saved
                under this name.
        """
        return self.programs.run(program, paused=paused)

    # ---- parts ----------------------------------------------------------------------

    @property
    def grippers(self) -> Mapping[str, Gripper]:
        """Grippers by name: a gripper's prefix, or ``gripper`` without a prefix."""
        return self._grippers

    @cached_property
    def _grippers(self) -> Mapping[str, Gripper]:
        model = self.description.model
        found = find_grippers(model).items()
        return Parts(
            "gripper",
            {name: Gripper(name, g, model, self.channel) for name, g in found},
        )

    @property
    def gripper(self) -> Gripper:
        """The robot's only gripper.

        Reading it raises ControlError if the robot does not have exactly one gripper.
        """
        return only_part(self.grippers, "gripper", self.description.model)

    @property
    def arms(self) -> Mapping[str, Arm]:
        """Arms by name: the prefix of an arm's links, or ``arm`` without a prefix.

        An arm is a chain of six revolute joints that ends in a link ``…tool0``.
        """
        return self._arms

    @cached_property
    def _arms(self) -> Mapping[str, Arm]:
        from tool0.api.arm import Arm  # imports numpy, only when needed

        infos = self.channel.call(ListArms())
        return Parts("arm", {info.name: Arm(info, self.channel) for info in infos})

    @property
    def arm(self) -> Arm:
        """The robot's only arm: poses, inverse kinematics, and motion of the tool.

        Raises:
            ControlError: If the robot does not have exactly one arm.
        """
        return only_part(self.arms, "arm", self.description.model)

    @property
    def force_torque(self) -> ForceTorque:
        """The force-torque sensor at the only ``tool0``.

        Reading it raises ControlError if the robot does not have exactly one ``tool0``.
        """
        return self.force_torque_of(None)

    def force_torque_of(self, link: str | None) -> ForceTorque:
        """Return the sensor for the wrench that ``link`` and all links beyond it exert.

        Raises:
            ModelError: If the link does not exist.
        """
        sensor = ForceTorque(link, self.channel)
        _ = sensor.rate  # raises ModelError or ControlError if the link does not exist
        return sensor

    @property
    def cameras(self) -> Mapping[str, CameraHandle]:
        """The cameras by name."""
        return self._cameras

    @cached_property
    def _cameras(self) -> Mapping[str, CameraHandle]:
        cameras = self.channel.call(ListCameras())
        handles = {item.name: CameraHandle(item, self.channel) for item in cameras}
        return Parts("camera", handles)

    def camera(self, name: str) -> CameraHandle:
        """Return a camera; its ``image()`` takes a picture.

        Raises:
            RenderError: If there is no camera with this name.
        """
        checked_value("camera", "name", name, str)
        if name not in self.cameras:
            hint = did_you_mean(name, list(self.cameras))
            raise RenderError(f"no camera '{name}'{hint}")
        return self.cameras[name]

    # ---- time and safety ------------------------------------------------------------

    def run(self, duration: float) -> None:
        """Advance simulated time, and return when this time has passed.

        Args:
            duration: Duration [simulated s], 0 or more.

        Raises:
            ControlError: If the simulation is paused or closed.
            EngineError: If the physics fails during this time.
        """
        self.channel.call(Run(duration=duration))

    def pause(self) -> None:
        """Pause simulated time; requests are still answered."""
        self.channel.call(Pause())

    def resume(self) -> None:
        """Resume simulated time."""
        self.channel.call(Resume())

    def step(self, ticks: int = 1) -> None:
        """Advance a paused simulation by ``ticks`` control periods, 1 … 1 000 000.

        Raises:
            ControlError: If the simulation is not paused.
        """
        self.channel.call(Step(ticks=ticks))

    def set_speed(self, factor: float) -> None:
        """Set the simulated seconds per wall second: above 0, and at most 1000.

        Raises:
            ControlError: If the simulation does not run in real time.
        """
        self.channel.call(SetSpeed(factor=factor))

    def reset(
        self,
        position: Mapping[str, float] | None = None,
        *,
        keep_time: bool = False,
        allow_penetration: bool = False,
    ) -> None:
        """Return the robot to its initial pose, and the objects to their start poses.

        Active goals are PREEMPTED; running controllers hold the pose.  Removed objects
        are not added again.  A reset also clears a fault of the physics.

        Args:
            position: Joint → position that replaces the initial position [rad | m].
            keep_time: Whether simulated time continues; otherwise, the time restarts at
                0.
            allow_penetration: Whether a link at ``position`` may penetrate the ground,
                an object or another link by more than 2 mm; the physics then separates
                the bodies violently.

        Raises:
            ModelError: If a joint is unknown, or if a position is outside the joint's
                limits.
            PenetrationError: If a link at ``position`` penetrates a body; the robot is
                then unchanged.
        """
        self.channel.call(
            Reset(
                position={} if position is None else position,  # type: ignore[arg-type]
                keep_time=keep_time,
                allow_penetration=allow_penetration,
            )
        )

    def emergency_stop(self, engaged: bool = True) -> None:
        """Brake every joint immediately, or release the brakes.

        Goals are PREEMPTED.  After the release, the controllers hold the positions.
        """
        self.channel.call(EmergencyStop(engaged=engaged))

    def close(self) -> None:
        """End the simulation or the connection; further calls have no effect."""
        self.channel.close()

    def __exit__(self, *_: object) -> None:
        self.close()
