"""A robot without physics, which the pages of ``tool0 view`` show and pose."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Final, final

from tool0.description.model import Joint, JointType, RobotModel
from tool0.description.parts import find_grippers, joints_of_robot
from tool0.description.poses import PoseStore
from tool0.description.robot import RobotDescription
from tool0.errors import ControlError, ModelError
from tool0.panel.protocol import GripperState, Status, ViewInfo, ViewScene
from tool0.panel.robot_info import ONE_AXIS, RobotFiles, pose_infos, robot_info
from tool0.protocol.backend import missing_methods
from tool0.protocol.gripper import Grip
from tool0.protocol.motion import PoseJoints
from tool0.protocol.notifications import Notification
from tool0.protocol.poses import DeletePose, GoToPose, SavePose
from tool0.protocol.request import Request
from tool0.protocol.running import Reset
from tool0.protocol.state_message import StateMessage

_ROUNDING: Final = 1e-6
"""Tolerance for positions beyond a limit [rad | m]."""
_OFFERED: Final = (PoseJoints, GoToPose, Reset, SavePose, DeletePose, Grip)
_NO_PHYSICS: Final = (
    "`tool0 view` has no physics and no controllers; bring the robot up with "
    "`tool0 bringup`"
)
_NO_OBJECTS: Final = ViewScene(number=0, objects=[])


@final
class RobotView:
    """A robot without physics, with joint positions that pages set.

    This class is both the server's backend and the source of the view.
    """

    mode: Final = "view"
    states: Final = None
    cameras: Final = None

    def __init__(
        self, description: RobotDescription, ground: float | None = None
    ) -> None:
        self._model = description.model
        self._grippers = find_grippers(description.model)
        self._book = PoseStore(description)
        self._lock = threading.Lock()
        self._names = [
            joint.name
            for joint in description.model.movable_joints
            if joint.type in ONE_AXIS
        ]
        self._start = {
            name: self._model.joint(name).limits.clamp(0.0) for name in self._names
        }
        start = self._book.start()
        self._start |= {name: start[name] for name in self._names if name in start}
        self._position = _with_mimics(self._model, self._start)
        self._frame = self._frame_now()
        self._problem: str | None = None
        self._notifications: list[Notification] = []
        self.files = RobotFiles(description)
        self.info = ViewInfo(
            mode="view",
            engine=None,
            control_period=None,
            grasp_assist=False,
            robot=robot_info(description, self._names, ground, {}),
            cameras=[],
            notices=[],
            missing=missing_methods(self),
        )

    def scene(self) -> ViewScene:
        return _NO_OBJECTS

    def frame(self) -> StateMessage:
        return self._frame

    def need_forces(self, *, contacts: bool, wrenches: bool) -> None:
        """Do nothing, because frames contain no forces."""

    def status(self, clients: int) -> Status:
        position = self._position
        return Status(
            paused=False,
            stopped=False,
            fault=None,
            speed=None,
            real_time_factor=0.0,
            late_ticks=0,
            clients=clients,
            controllers=[],
            grippers=[
                GripperState(
                    name=name,
                    opening=round(
                        max(0.0, gripper.opening(position[gripper.joint])), 4
                    ),
                    motion="idle",
                    gobj=0,
                    width=None,
                )
                for name, gripper in self._grippers.items()
            ],
            poses=pose_infos(self._book, self._report),
            stalls=[],
            targets={},
            control_boxes=[],
            programs=[],
        )

    def notifications(self) -> Sequence[Notification]:
        found, self._notifications = self._notifications, []
        return found

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        """Do nothing: without a simulation, no tick processes streamed requests."""

    def check_setpoint(self, request: Request[Any]) -> None:
        assert isinstance(request, PoseJoints)  # the only supported stream
        self._checked(request.positions)

    def superseded(self, request: Request[Any]) -> Collection[str]:
        return ("",) if isinstance(request, GoToPose | Reset) else ()

    def why_missing(self, request: type[Request[Any]]) -> str:
        return "" if issubclass(request, _OFFERED) else _NO_PHYSICS

    def answer(self, request: Request[Any]) -> Any:
        match request:
            case PoseJoints(positions=positions):
                self._put(self._checked(positions))
            case GoToPose(name=name, robot=robot):
                self._put(self._book.goal(name, robot))
            case Reset():
                self._put(self._start)
            case SavePose(name=name, robot=robot):
                driven = joints_of_robot(self._model, self._driven(), robot)
                self._book.save(name, driven, update=robot is not None)
            case DeletePose(name=name):
                self._book.delete(name)
            case Grip(gripper=name, opening=opening):
                if opening is None:
                    raise ControlError("without physics, a gripper needs an 'opening'")
                self._grip(name, opening)
        return () if isinstance(request, GoToPose) else None

    def close(self) -> None:
        pass

    def _put(self, positions: Mapping[str, float]) -> None:
        with self._lock:
            self._position = _with_mimics(self._model, {**self._position, **positions})
            self._frame = self._frame_now()

    def _grip(self, name: str | None, opening: float) -> None:
        for known, gripper in self._grippers.items():
            if name in (None, known):
                self._put({gripper.joint: gripper.position(opening)})
                return
        names = ", ".join(self._grippers) or "none"
        raise ControlError(f"unknown gripper '{name}'; there are: {names}")

    def _driven(self) -> Mapping[str, float]:
        driven = [item.joint for item in self._model.transmissions]
        free = [name for name in self._names if self._model.joint(name).mimic is None]
        position = self._position
        return {name: position[name] for name in driven or free}

    def _checked(self, positions: Mapping[str, float]) -> Mapping[str, float]:
        """Return valid positions of the joints [rad | m], or raise Tool0Error."""
        return {
            name: _checked(self._model.joint(name), position)
            for name, position in positions.items()
        }

    def _frame_now(self) -> StateMessage:
        n_joints = len(self._names)
        return StateMessage(
            time=0.0,
            tick=0,
            position=tuple(self._position[name] for name in self._names),
            velocity=(0.0,) * n_joints,
            effort=(0.0,) * n_joints,
            desired=(None,) * n_joints,
            objects=(),
            scene_number=_NO_OBJECTS.number,
        )

    def _report(self, text: str) -> None:
        if text != self._problem:
            self._problem = text
            self._notifications.append(
                Notification(severity="warning", code="log", text=text)
            )


def _checked(joint: Joint, position: float) -> float:
    if joint.mimic is not None:
        raise ModelError(
            f"joint '{joint.name}' mimics '{joint.mimic.joint}'; pose that one"
        )
    if joint.type not in ONE_AXIS:
        raise ModelError(
            f"joint '{joint.name}' is {joint.type.value} and cannot be posed"
        )
    if joint.type is JointType.CONTINUOUS:
        return position
    limits = joint.limits
    if not limits.lower - _ROUNDING <= position <= limits.upper + _ROUNDING:
        raise ModelError(
            f"joint '{joint.name}' cannot be at {position:.6g}; its limits are "
            f"[{limits.lower:.6g}, {limits.upper:.6g}]"
        )
    return limits.clamp(position)


def _with_mimics(
    model: RobotModel, positions: Mapping[str, float]
) -> Mapping[str, float]:
    """Return ``positions`` with the positions of mimic joints added."""
    found = dict(positions)
    for name in positions:
        mimic = model.joint(name).mimic
        if mimic is not None:
            found[name] = mimic.multiplier * found.get(mimic.joint, 0.0) + mimic.offset
    return found
