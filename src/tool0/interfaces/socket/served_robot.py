"""What the server asks of a robot: the façade of ``runtime/``, seen from here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from tool0.control.goal import GoalStatus, Result
from tool0.control.trajectory import TrajectoryPoint
from tool0.description.camera import Camera
from tool0.description.scene import RGBA, SceneObject
from tool0.description.shapes import Geometry
from tool0.description.transform import Pose, Transform
from tool0.hardware.engine import ObjectState
from tool0.sensing.cameras import CameraImage
from tool0.sensing.wrench import WrenchReading


class ServedJoints(Protocol):
    """The measured state, by joint name."""

    @property
    def position(self) -> Mapping[str, float]: ...
    @property
    def velocity(self) -> Mapping[str, float]: ...
    @property
    def effort(self) -> Mapping[str, float]: ...


class ServedSnapshot(Protocol):
    """How the simulation runs."""

    @property
    def is_paused(self) -> bool: ...
    @property
    def is_stopped(self) -> bool: ...
    @property
    def real_time_factor(self) -> float: ...
    @property
    def overruns(self) -> int: ...
    @property
    def fault(self) -> str | None: ...
    @property
    def scene(self) -> Sequence[SceneObject]: ...
    @property
    def objects(self) -> Sequence[ObjectState]:
        """Where what is around it is, in the order of ``scene``."""


class ServedStatus(Protocol):
    """One row of ``controllers list``."""

    @property
    def name(self) -> str: ...
    @property
    def type(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def claimed(self) -> Sequence[tuple[str, Sequence[str]]]:
        """Each hardware interface with the joints it claims there."""


class ServedGoal(Protocol):
    """A goal that was accepted; reading it is safe from any thread."""

    @property
    def status(self) -> GoalStatus: ...
    @property
    def result(self) -> Result | None: ...
    def cancel(self) -> None: ...


class ServedController(Protocol):
    """A handle on one controller."""

    def follow(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
        path_tolerance: Mapping[str, float] | None = None,
        goal_tolerance: Mapping[str, float] | None = None,
        goal_time_tolerance: float | None = None,
    ) -> ServedGoal: ...
    def query_state(self, time: float) -> TrajectoryPoint: ...


class ServedGeometry(Protocol):
    """How a gripper's opening follows from its joint."""

    @property
    def max_opening(self) -> float: ...
    def opening(self, position: float) -> float: ...
    def position(self, opening: float) -> float: ...


class ServedGrasp(Protocol):
    """What a gripper does: ``GraspState``."""

    @property
    def motion(self) -> str: ...
    @property
    def opening(self) -> float: ...
    @property
    def width(self) -> float | None: ...
    @property
    def gobj(self) -> int: ...


class ServedGripper(Protocol):
    """A gripper, by the opening between its pads."""

    @property
    def geometry(self) -> ServedGeometry: ...
    @property
    def state(self) -> ServedGrasp: ...
    def move(
        self,
        *,
        opening: float,
        speed: float | None = None,
        force: float | None = None,
        effort: float | None = None,
    ) -> ServedGoal: ...


class ServedArm(Protocol):
    """Six joints, by where their end is."""

    @property
    def tip(self) -> str: ...
    def pose(
        self, *, tip: str | None = None, relative_to: str | None = None
    ) -> Transform: ...
    def move_to(
        self,
        pose: Pose,
        *,
        speed: float = ...,
        tip: str | None = None,
        relative_to: str | None = None,
    ) -> ServedGoal: ...
    def move_linear(
        self,
        pose: Pose,
        *,
        speed: float = ...,
        acceleration: float = ...,
        angular_speed: float = ...,
        tip: str | None = None,
        relative_to: str | None = None,
    ) -> ServedGoal: ...


class ServedForceTorque(Protocol):
    """The wrench at the wrist."""

    @property
    def rate(self) -> float: ...
    def start(self, rate: float | None = None, cutoff: float = ...) -> None: ...
    def stop(self) -> None: ...
    def read(self) -> WrenchReading: ...
    def zero(self) -> None: ...
    def samples(
        self, since: int = ..., timeout: float | None = ...
    ) -> Sequence[WrenchReading]: ...


class ServedScene(Protocol):
    """What is around the robot."""

    def add(
        self,
        item: str,
        shape: Geometry,
        /,
        *,
        xyz: Sequence[float] = ...,
        rpy: Sequence[float] = ...,
        mass: float | None = ...,
        friction: float = ...,
        rgba: RGBA | None = ...,
    ) -> SceneObject: ...
    def remove(self, name: str) -> None: ...
    def place(
        self, name: str, position: Sequence[float], quat_wxyz: Sequence[float]
    ) -> None: ...


class ServedCamera(Protocol):
    """What looks at the robot."""

    @property
    def camera(self) -> Camera: ...
    def image(self) -> CameraImage: ...


class ServedRobot(Protocol):
    """A robot that runs in this process."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def snapshot(self) -> ServedSnapshot: ...
    @property
    def joint_state(self) -> ServedJoints: ...
    @property
    def gripper(self) -> ServedGripper: ...
    @property
    def grippers(self) -> Mapping[str, ServedGripper]: ...
    @property
    def arms(self) -> Mapping[str, ServedArm]: ...
    @property
    def arm(self) -> ServedArm: ...
    @property
    def scene(self) -> ServedScene: ...
    @property
    def force_torque(self) -> ServedForceTorque: ...
    @property
    def cameras(self) -> Mapping[str, ServedCamera]: ...
    def camera(self, name: str) -> ServedCamera: ...
    def controllers(self) -> Sequence[ServedStatus]: ...
    def controller(self, name: str) -> ServedController: ...
    def load(self, name: str) -> None: ...
    def unload(self, name: str) -> None: ...
    def switch(
        self,
        start: Sequence[str] = (),
        stop: Sequence[str] = (),
        *,
        strict: bool = True,
    ) -> None: ...
    def pause(self) -> None: ...
    def resume(self) -> None: ...
    def step(self, ticks: int = 1) -> None: ...
    def reset(self) -> None: ...
    def emergency_stop(self, engaged: bool = True) -> None: ...
    def summary(self) -> Mapping[str, object]: ...
