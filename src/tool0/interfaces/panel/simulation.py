"""A running robot, as the panel's pages see and drive it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, final

from tool0.description.catalogue import named_poses
from tool0.errors import ConfigError, ControlError, did_you_mean
from tool0.interfaces.panel import protocol as ask
from tool0.interfaces.panel.controller_info import controller_infos
from tool0.interfaces.panel.happenings import Watcher
from tool0.interfaces.panel.object_requests import change_objects
from tool0.interfaces.panel.protocol import Frame, GripperState, PoseInfo, Scene, Status
from tool0.interfaces.panel.robot_files import RobotFiles
from tool0.interfaces.panel.robot_info import object_info, robot_info
from tool0.interfaces.panel.source import Facts, Happening
from tool0.sensing.grasp import GraspDetector

if TYPE_CHECKING:
    from tool0.description.scene import SceneObject
    from tool0.runtime.bus import Snapshot
    from tool0.runtime.gripper import Gripper
    from tool0.runtime.robot import Robot

_DIGITS = 6
"""Of positions and the like: micrometres.  What rests is then the same every time."""


@final
class SimulationSource:
    """Reads the bus, and asks the façade for what pages want."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._files = RobotFiles(robot.description)
        first = robot.snapshot
        self._facts = Facts(
            mode="simulation",
            engine=robot.engine.name,
            control_period=robot.control_period,
            grasp_assist=robot.grasp_assist,
            robot=robot_info(
                robot.description, first.joint_names, robot.ground, robot.joint_limits
            ),
            files=self._files,
        )
        self._joints = {
            name: replace(joint, limits=robot.joint_limits.get(name, joint.limits))
            for name, joint in robot.description.model.joint_by_name.items()
        }
        self._seen: Snapshot | None = None
        self._objects = first.scene
        self._scene = self._scene_of(0, first.scene)
        self._frame = _frame_of(first, self._scene.number)
        self._watcher = Watcher(robot)
        self._grasps = {
            name: GraspDetector(gripper.geometry)
            for name, gripper in robot.grippers.items()
        }
        self._grippers: list[GripperState] = []

    @property
    def facts(self) -> Facts:
        return self._facts

    def scene(self) -> Scene:
        return self._scene

    def frame(self) -> Frame:
        snapshot = self._robot.snapshot
        if snapshot is not self._seen:
            self._seen = snapshot
            self._grippers = [
                _gripper_state(name, detector, snapshot)
                for name, detector in self._grasps.items()
            ]
            if snapshot.scene is not self._objects:
                self._objects = snapshot.scene
                self._scene = self._scene_of(self._scene.number + 1, snapshot.scene)
            frame = _frame_of(snapshot, self._scene.number)
            if frame != self._frame:
                self._frame = frame
        return self._frame

    def status(self, clients: int) -> Status:
        self.frame()  # what the grippers do is told by every snapshot
        robot, snapshot = self._robot, self._robot.snapshot
        return Status(
            paused=snapshot.is_paused,
            stopped=snapshot.is_stopped,
            fault=snapshot.fault,
            speed=snapshot.speed,
            real_time_factor=round(snapshot.real_time_factor, 2),
            overruns=snapshot.overruns,
            clients=clients,
            controllers=controller_infos(
                robot.defined_controllers,
                snapshot.controllers,
                self._joints,
            ),
            grippers=self._grippers,
            poses=self._poses(),
            targets={
                joint: _rounded(target)
                for intent in snapshot.intents.values()
                for joint, target in zip(
                    intent.joint_names, intent.target(), strict=True
                )
            },
        )

    def happenings(self) -> Sequence[Happening]:
        return self._watcher.happenings()

    def check(self, message: ask.Stream) -> None:
        match message:
            case ask.Steer(controller=name, positions=positions):
                defined = set(self._robot.defined_controllers)
                if name not in defined:
                    raise ControlError(
                        f"no controller '{name}' in the YAML"
                        f"{did_you_mean(name, defined)}"
                    )
                for joint in positions:
                    self._robot.description.model.joint(joint)
            case ask.PoseJoints():
                raise ControlError(
                    "joints are put somewhere in `tool0 view` only; here they have "
                    "weight: steer a trajectory controller"
                )

    def displaced_by(self, message: ask.ClientMessage) -> Collection[str]:
        match message:
            case ask.HoldStill(controller=name):
                return (name,)
            case ask.SwitchControllers(stop=names):
                return names
            case ask.Grip(gripper=name) if name in self._robot.grippers:
                joint = self._robot.grippers[name].geometry.joint
                return [
                    status.name
                    for status in self._robot.controllers()
                    if any(joint in joints for _, joints in status.claimed)
                ]
            case ask.GoToPose() | ask.Reset() | ask.EmergencyStop(engaged=True):
                return tuple(self._robot.defined_controllers)
        return ()

    def carry_out(self, message: ask.ClientMessage) -> None:
        robot = self._robot
        match message:
            case ask.Steer():
                controller = robot.controller(message.controller)
                controller.steer(message.positions, speed=message.speed)
            case ask.PoseJoints():
                self.check(message)
            case ask.GoToPose(name=name, speed=speed):
                robot.go_to_pose(name, speed=speed)
            case ask.SavePose(name=name):
                robot.save_pose(name)
            case ask.DeletePose(name=name):
                robot.delete_pose(name)
            case ask.HoldStill(controller=name):
                robot.controller(name).command_trajectory([])
            case ask.Grip():
                self._gripper(message.gripper).move(
                    opening=message.opening, speed=message.speed, force=message.force
                )
            case ask.AddObject() | ask.RemoveObject() | ask.PlaceObject():
                change_objects(robot.scene, message)
            case ask.LoadController(name=name):
                robot.load(name)
            case ask.UnloadController(name=name):
                robot.unload(name)
            case ask.SwitchControllers(start=start, stop=stop, strict=strict):
                robot.switch(start, stop, strict=strict)
            case ask.Pause():
                robot.pause()
            case ask.Resume():
                robot.resume()
            case ask.Step(ticks=ticks):
                robot.step(ticks)
            case ask.Reset():
                robot.reset()
            case ask.SetSpeed(factor=factor):
                robot.set_speed(factor)
            case ask.EmergencyStop(engaged=engaged):
                robot.emergency_stop(engaged)

    def close(self) -> None:
        self._watcher.close()

    def _scene_of(self, number: int, objects: Sequence[SceneObject]) -> Scene:
        self._files.have(objects)
        infos = [object_info(item, self._files) for item in objects]
        return Scene(number=number, objects=infos)

    def _gripper(self, name: str) -> Gripper:
        grippers = self._robot.grippers
        if name not in grippers:
            hint = did_you_mean(name, set(grippers))
            raise ControlError(f"unknown gripper '{name}'{hint}")
        return grippers[name]

    def _poses(self) -> list[PoseInfo]:
        robot = self._robot
        try:
            poses = robot.poses()
        except ConfigError as error:
            self._watcher.tell_once("warning", "log", str(error))
            return [
                PoseInfo(name=name, saved=False, positions=dict(positions))
                for name, positions in named_poses(robot.description).items()
            ]
        return [
            PoseInfo(name=pose.name, saved=pose.saved, positions=dict(pose.positions))
            for pose in poses.values()
        ]


def _frame_of(snapshot: Snapshot, scene: int) -> Frame:
    desired: dict[str, float] = {}
    for intent in snapshot.intents.values():
        positions = intent.state().desired.positions
        desired.update(zip(intent.joint_names, positions, strict=True))
    return Frame(
        time=_rounded(snapshot.time),
        position=[_rounded(value) for value in snapshot.position],
        velocity=[_rounded(value) for value in snapshot.velocity],
        effort=[_rounded(value) for value in snapshot.effort],
        desired=[
            _rounded(desired[name]) if name in desired else None
            for name in snapshot.joint_names
        ],
        objects=[
            (
                (_rounded(x), _rounded(y), _rounded(z)),
                (_rounded(qw), _rounded(qx), _rounded(qy), _rounded(qz)),
            )
            for (x, y, z), (qw, qx, qy, qz) in (
                (item.position, item.quat_wxyz) for item in snapshot.objects
            )
        ],
        scene=scene,
    )


def _gripper_state(
    name: str, detector: GraspDetector, snapshot: Snapshot
) -> GripperState:
    grasp = detector.observe(snapshot)
    return GripperState(
        name=name,
        opening=round(grasp.opening, 4),
        motion=grasp.motion,
        gobj=grasp.gobj,
        width=None if grasp.width is None else round(grasp.width, 4),
    )


def _rounded(value: float) -> float:
    return round(value, _DIGITS) + 0.0  # no minus zero
