"""The visitor's end of the socket: a robot that runs in another process.

A connection belongs to one thread.  Times to wait are wall seconds, since the other
side's clock may be paused.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final, final

from tool0.control.trajectory import TrajectoryPoint
from tool0.description.camera import Camera
from tool0.errors import TransportError
from tool0.interfaces.socket.address import (
    DEFAULT_NAME,
    check_supported,
    folders,
    running_names,
    socket_path,
)
from tool0.interfaces.socket.remote_arm import RemoteArm
from tool0.interfaces.socket.remote_camera import RemoteCamera, list_cameras
from tool0.interfaces.socket.remote_force_torque import RemoteForceTorque
from tool0.interfaces.socket.remote_gripper import RemoteGrasp, RemoteGripper
from tool0.interfaces.socket.remote_scene import RemoteScene
from tool0.interfaces.socket.requests import ANSWER_TIMEOUT, RemoteGoal, Requests
from tool0.interfaces.socket.wire import PROTOCOL, Json


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RemoteStatus:
    """One row of ``controllers list``."""

    name: str
    type: str
    state: str
    claimed: tuple[tuple[str, tuple[str, ...]], ...]
    """Each hardware interface with the joints it claims there."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RemoteState:
    """The measured state at ``time`` [s], by joint name, and how the time runs."""

    time: float
    is_paused: bool
    is_stopped: bool
    real_time_factor: float
    overruns: int
    fault: str | None
    position: Mapping[str, float]
    velocity: Mapping[str, float]
    effort: Mapping[str, float]
    grippers: Mapping[str, RemoteGrasp]


@final
class RemoteRobot:
    """A bringup in another process, with the verbs of the one in this process."""

    def __init__(self, name: str = DEFAULT_NAME) -> None:
        self._requests = Requests(_connect(name))
        try:
            hello = self._requests.call("hello", protocol=PROTOCOL)
        except BaseException:
            self._requests.close()
            raise
        self.name = name
        self.pid = int(hello["pid"])
        self.gripper: Final = RemoteGripper(self._requests.call, self._requests.start)
        self.arm: Final = RemoteArm(self._requests.call, self._requests.start)
        self.scene: Final = RemoteScene(self._requests.call)
        self.force_torque: Final = RemoteForceTorque(self._requests.call)

    def __enter__(self) -> RemoteRobot:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Hang up; the robot runs on."""
        self._requests.close()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.joint_state.time

    @property
    def joint_state(self) -> RemoteState:
        answer = self._requests.call("state")
        grippers = {
            name: RemoteGrasp(**state) for name, state in answer["grippers"].items()
        }
        return RemoteState(**{**answer, "grippers": grippers})

    def summary(self) -> Mapping[str, object]:
        return self._requests.call("summary")

    def cameras(self) -> Mapping[str, Camera]:
        """Return the cameras by name."""
        return list_cameras(self._requests.call)

    def camera(self, name: str) -> RemoteCamera:
        return RemoteCamera(self._requests.call, name)

    def controllers(self) -> tuple[RemoteStatus, ...]:
        rows = self._requests.call("controllers.list")["controllers"]
        return tuple(_status_from_json(row) for row in rows)

    def controller(self, name: str) -> RemoteController:
        return RemoteController(self._requests, name)

    def load(self, name: str) -> None:
        self._requests.call("controllers.load", name=name)

    def unload(self, name: str) -> None:
        self._requests.call("controllers.unload", name=name)

    def switch(
        self,
        start: Sequence[str] = (),
        stop: Sequence[str] = (),
        *,
        strict: bool = True,
    ) -> None:
        self._requests.call(
            "controllers.switch", start=list(start), stop=list(stop), strict=strict
        )

    def pause(self) -> None:
        self._requests.call("sim.pause")

    def resume(self) -> None:
        self._requests.call("sim.resume")

    def step(self, ticks: int = 1) -> None:
        """Run ``ticks`` control periods while paused."""
        self._requests.receive(self._requests.send("sim.step", ticks=ticks), None)

    def reset(self) -> None:
        self._requests.call("sim.reset")

    def emergency_stop(self, engaged: bool = True) -> None:
        self._requests.call("sim.estop", engaged=engaged)


@final
class RemoteController:
    """A handle on one controller of another process."""

    def __init__(self, requests: Requests, name: str) -> None:
        self._requests = requests
        self.name = name

    def follow(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
        path_tolerance: Mapping[str, float] | None = None,
        goal_tolerance: Mapping[str, float] | None = None,
        goal_time_tolerance: float | None = None,
    ) -> RemoteGoal:
        return self._requests.start(
            "controller.follow",
            controller=self.name,
            points=[_point_to_json(point) for point in points],
            joint_names=None if joint_names is None else list(joint_names),
            stamp=stamp,
            path_tolerance=path_tolerance,
            goal_tolerance=goal_tolerance,
            goal_time_tolerance=goal_time_tolerance,
        )

    def query_state(self, time: float | None = None) -> TrajectoryPoint:
        """Return what the trajectory wants at ``time``; None means now."""
        answer = self._requests.call(
            "controller.query_state", controller=self.name, time=time
        )
        return TrajectoryPoint(**answer)


def _status_from_json(row: Json) -> RemoteStatus:
    claimed = tuple((kind, tuple(joints)) for kind, joints in row["claimed"])
    return RemoteStatus(**{**row, "claimed": claimed})


def _point_to_json(point: TrajectoryPoint) -> Json:
    return {field.name: getattr(point, field.name) for field in fields(point)}


def _connect(name: str) -> socket.socket:
    check_supported()
    paths = [socket_path(folder, name) for folder in folders()]
    for path in paths:
        peer = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        peer.settimeout(ANSWER_TIMEOUT)
        try:
            peer.connect(str(path))
        except (FileNotFoundError, ConnectionRefusedError):
            peer.close()  # never started, or died without cleaning up
        except OSError as error:
            peer.close()
            raise TransportError(f"cannot reach {path}: {error}") from None
        else:
            return peer
    raise TransportError(_nobody_there(name, paths))


def _nobody_there(name: str, paths: Sequence[Path]) -> str:
    others = [other for other in running_names() if other != name]
    hint = (
        f"running: {', '.join(others)} (use --name)"
        if others
        else "start one with `tool0 bringup`"
    )
    return f"no bringup named '{name}' is running ({paths[0]}); {hint}"
