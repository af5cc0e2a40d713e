"""The visitor's end of the socket: a robot that runs in another process.

A connection belongs to one thread.  Times to wait are wall seconds, since the other
side's clock may be paused.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final, final

from tool0.control.goal import GoalStatus, Result
from tool0.control.trajectory import TrajectoryPoint
from tool0.description.camera import Camera
from tool0.errors import GoalTimeoutError, TransportError
from tool0.remote.address import (
    DEFAULT_NAME,
    check_supported,
    folders,
    running_names,
    socket_path,
)
from tool0.remote.remote_arm import RemoteArm
from tool0.remote.remote_camera import RemoteCamera, list_cameras
from tool0.remote.remote_force_torque import RemoteForceTorque
from tool0.remote.remote_scene import RemoteScene
from tool0.remote.wire import (
    MAX_ANSWER,
    PROTOCOL,
    Json,
    LineReader,
    decode,
    encode,
    error_from_json,
    result_from_json,
)

_ANSWER_TIMEOUT: Final = 30.0
"""Longest wait for an answer that should come at once [wall s]."""
_GLANCE: Final = 0.02
"""Time between looks at a gripper that moves [wall s]."""


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
class RemoteGrasp:
    """What a gripper does: ``tool0.runtime.grasp.GraspState``."""

    motion: str
    opening: float
    width: float | None
    gobj: int


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
        self._wire = _Wire(_connect(name))
        try:
            hello = self._wire.call("hello", protocol=PROTOCOL)
        except BaseException:
            self._wire.close()
            raise
        self.name = name
        self.pid = int(hello["pid"])
        self.gripper: Final = RemoteGripper(self._wire)
        self.arm: Final = RemoteArm(self._wire.call, self._wire.start)
        self.scene: Final = RemoteScene(self._wire.call)
        self.force_torque: Final = RemoteForceTorque(self._wire.call)

    def __enter__(self) -> RemoteRobot:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Hang up; the robot runs on."""
        self._wire.close()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.joint_state.time

    @property
    def joint_state(self) -> RemoteState:
        answer = self._wire.call("state")
        grippers = {
            name: RemoteGrasp(**state) for name, state in answer["grippers"].items()
        }
        return RemoteState(**{**answer, "grippers": grippers})

    def summary(self) -> Mapping[str, object]:
        return self._wire.call("summary")

    def cameras(self) -> Mapping[str, Camera]:
        """Return the cameras by name."""
        return list_cameras(self._wire.call)

    def camera(self, name: str) -> RemoteCamera:
        return RemoteCamera(self._wire.call, name)

    def controllers(self) -> tuple[RemoteStatus, ...]:
        rows = self._wire.call("controllers.list")["controllers"]
        return tuple(_status_from_json(row) for row in rows)

    def controller(self, name: str) -> RemoteController:
        return RemoteController(self._wire, name)

    def load(self, name: str) -> None:
        self._wire.call("controllers.load", name=name)

    def unload(self, name: str) -> None:
        self._wire.call("controllers.unload", name=name)

    def switch(
        self,
        start: Sequence[str] = (),
        stop: Sequence[str] = (),
        *,
        strict: bool = True,
    ) -> None:
        self._wire.call(
            "controllers.switch", start=list(start), stop=list(stop), strict=strict
        )

    def pause(self) -> None:
        self._wire.call("sim.pause")

    def resume(self) -> None:
        self._wire.call("sim.resume")

    def step(self, ticks: int = 1) -> None:
        """Run ``ticks`` control periods while paused."""
        self._wire.receive(self._wire.send("sim.step", ticks=ticks), None)

    def reset(self) -> None:
        self._wire.call("sim.reset")

    def emergency_stop(self, engaged: bool = True) -> None:
        self._wire.call("sim.estop", engaged=engaged)


@final
class RemoteController:
    """A handle on one controller of another process."""

    def __init__(self, wire: _Wire, name: str) -> None:
        self._wire = wire
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
        return self._wire.start(
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
        answer = self._wire.call(
            "controller.query_state", controller=self.name, time=time
        )
        return TrajectoryPoint(**answer)


@final
class RemoteGripper:
    """The gripper of another process."""

    def __init__(self, wire: _Wire) -> None:
        self._wire = wire

    def move(
        self,
        *,
        opening: float | None = None,
        position: float | None = None,
        speed: float | None = None,
        force: float | None = None,
        effort: float | None = None,
    ) -> RemoteGoal:
        return self._wire.start(
            "gripper.move",
            opening=opening,
            position=position,
            speed=speed,
            force=force,
            effort=effort,
        )

    @property
    def state(self) -> RemoteGrasp:
        return RemoteGrasp(**self._wire.call("gripper.state"))

    def wait(self, timeout: float) -> RemoteGrasp:
        """Return what it does once it moves no longer, or after ``timeout`` wall s."""
        end = time.monotonic() + timeout
        while (state := self.state).motion == "moving" and time.monotonic() < end:
            time.sleep(_GLANCE)
        return state


@final
class RemoteGoal:
    """A goal that a controller of another process accepted."""

    def __init__(self, wire: _Wire, number: int) -> None:
        self._wire = wire
        self._number = number
        self._request: int | None = None
        self._result: Result | None = None

    @property
    def status(self) -> GoalStatus:
        answer = self._wire.call("goal.status", goal=self._number)
        return GoalStatus(answer["status"])

    @property
    def result(self) -> Result | None:
        """How it ended; None while it is active."""
        if self._result is None and self.status.is_terminal:
            return self.wait(_ANSWER_TIMEOUT)
        return self._result

    def wait(self, timeout: float | None = None) -> Result:
        """Return how it ended, or raise GoalTimeoutError after ``timeout`` wall s.

        The goal goes on after a timeout, and may be waited for again.
        """
        if self._result is None:
            if self._request is None:
                self._request = self._wire.send("goal.wait", goal=self._number)
            try:
                answer = self._wire.receive(self._request, timeout)
            except TimeoutError:
                raise GoalTimeoutError(
                    f"the goal is still active after {timeout} s"
                ) from None
            self._result = result_from_json(answer)
        return self._result

    def cancel(self) -> None:
        """Stop the motion, as the controller stops on a canceled goal."""
        self._wire.call("goal.cancel", goal=self._number)


@final
class _Wire:
    """Requests out, answers in, matched by id."""

    def __init__(self, peer: socket.socket) -> None:
        self._peer = peer
        self._reader = LineReader(peer, MAX_ANSWER)
        self._last_id = 0
        self._early: dict[int, Json] = {}

    def close(self) -> None:
        self._peer.close()

    def call(self, method: str, **params: object) -> Json:
        """Return the result of ``method``, or raise what it raised over there."""
        try:
            return self.receive(self.send(method, **params), _ANSWER_TIMEOUT)
        except TimeoutError:
            raise TransportError(
                f"the bringup did not answer '{method}' within {_ANSWER_TIMEOUT:g} s"
            ) from None

    def start(self, method: str, **params: object) -> RemoteGoal:
        return RemoteGoal(self, int(self.call(method, **params)["goal"]))

    def send(self, method: str, **params: object) -> int:
        """Send a request and return its id."""
        self._last_id += 1
        request = {"id": self._last_id, "method": method, "params": params}
        line = encode(request)
        try:
            self._peer.settimeout(_ANSWER_TIMEOUT)
            self._peer.sendall(line)
        except TimeoutError:
            raise TransportError("the bringup does not read its requests") from None
        except OSError as error:
            raise TransportError(f"the bringup has gone: {error}") from None
        return self._last_id

    def receive(self, ident: int, timeout: float | None) -> Json:
        """Return the result of request ``ident``; keep those of others for later."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while ident not in self._early:
            try:
                self._peer.settimeout(
                    None if deadline is None else max(deadline - time.monotonic(), 1e-6)
                )
                line = self._reader.next_line()
            except TimeoutError:
                raise TimeoutError(f"no answer within {timeout} s") from None
            except OSError as error:
                raise TransportError(f"the bringup has gone: {error}") from None
            if line is None:
                raise TransportError("the bringup has ended")
            answer = decode(line)
            if answer.get("id") is None:
                raise error_from_json(answer.get("error"))
            self._early[answer["id"]] = answer
        answer = self._early.pop(ident)
        if "error" in answer:
            raise error_from_json(answer["error"])
        result = answer.get("result")
        if not isinstance(result, dict):
            raise TransportError(f"the bringup answered without a result: {answer!r}")
        return result


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
        peer.settimeout(_ANSWER_TIMEOUT)
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
