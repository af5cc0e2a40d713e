"""A robot without physics: it notes what it is asked, and ends goals when told."""

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np

from tool0.control.goal import Goal, GoalResult, GoalStatus, GripperResult, Result
from tool0.control.trajectory import TrajectoryPoint
from tool0.description.camera import Camera
from tool0.description.model import ParallelGripper
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder, Geometry
from tool0.description.transform import Pose, Transform
from tool0.errors import (
    ControlError,
    EngineError,
    GoalRejectedError,
    RenderError,
    did_you_mean,
)
from tool0.hardware.engine import ObjectState
from tool0.sensing.cameras import CameraImage
from tool0.sensing.force_torque import WrenchReading
from tool0.sensing.grasp import GraspState

ARM = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint")
SUCCEEDED = GoalResult(status=GoalStatus.SUCCEEDED)
ABORTED = GoalResult(
    status=GoalStatus.ABORTED,
    error_code=GoalResult.PATH_TOLERANCE_VIOLATED,
    error_string="elbow_joint path error 0.200000",
)
GRIPPED = GripperResult(
    status=GoalStatus.SUCCEEDED,
    position=0.4,
    effort=5.0,
    stalled=True,
    reached_goal=False,
)


@dataclass(frozen=True)
class FakeStatus:
    name: str
    type: str
    state: str
    claimed: tuple[tuple[str, tuple[str, ...]], ...]


class FakeGoal:
    def __init__(self, controller: str) -> None:
        self.goal = Goal(controller)

    @property
    def status(self) -> GoalStatus:
        return self.goal.status

    @property
    def result(self) -> Result | None:
        return self.goal.result

    def cancel(self) -> None:
        self.goal.finish(GoalResult(status=GoalStatus.PREEMPTED))


class FakeController:
    def __init__(self, robot: "FakeRobot", name: str) -> None:
        self._robot = robot
        self._name = name

    def follow(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
        path_tolerance: Mapping[str, float] | None = None,
        goal_tolerance: Mapping[str, float] | None = None,
        goal_time_tolerance: float | None = None,
    ) -> FakeGoal:
        for name in joint_names or ():
            if name not in ARM:
                raise GoalRejectedError(
                    f"unknown joint '{name}'{did_you_mean(name, set(ARM))}",
                    GoalRejectedError.INVALID_JOINTS,
                )
        if any(math.isnan(q) for point in points for q in point.positions):
            raise GoalRejectedError("a position is NaN")
        asked = {
            "points": tuple(points),
            "joint_names": joint_names,
            "stamp": stamp,
            "path_tolerance": path_tolerance,
            "goal_tolerance": goal_tolerance,
            "goal_time_tolerance": goal_time_tolerance,
        }
        return self._robot.begin(self._name, asked)

    def query_state(self, time: float) -> TrajectoryPoint:
        return TrajectoryPoint([1.0, 2.0, 3.0], [0.0] * 3, [0.0] * 3)


class FakeArm:
    tip = "tool0"

    def __init__(self, robot: "FakeRobot") -> None:
        self._robot = robot

    def pose(
        self, *, tip: str | None = None, relative_to: str | None = None
    ) -> Transform:
        x = 0.5 if tip is None else 0.6
        return Transform(position=(x, 0.25, -1.0 if relative_to is None else 0.0))

    def move_to(self, pose: Pose, **asked: object) -> FakeGoal:
        return self._robot.begin("to", {"pose": pose, **asked})

    def move_linear(self, pose: Pose, **asked: object) -> FakeGoal:
        return self._robot.begin("linear", {"pose": pose, **asked})


class FakeGripper:
    geometry = ParallelGripper(
        name="jaw",
        joint="jaw_joint",
        pad_offset=0.0054057553,
        pad_cos=0.0376,
        pad_sin=-0.0430,
        max_opening=0.085,
        speed=(0.02, 0.15),
        force=(20.0, 235.0),
    )

    def __init__(self, robot: "FakeRobot") -> None:
        self._robot = robot

    def move(
        self,
        *,
        opening: float,
        speed: float | None = None,
        force: float | None = None,
        effort: float | None = None,
    ) -> FakeGoal:
        self.geometry.position(opening)
        asked = {"opening": opening, "speed": speed, "force": force, "effort": effort}
        return self._robot.begin("jaw_controller", asked)

    @property
    def state(self) -> GraspState:
        return GraspState(motion="holding_inside", opening=0.045, width=0.045)


class FakeForceTorque:
    """Samples come two at a time, whenever one waits for them."""

    def __init__(self, robot: "FakeRobot") -> None:
        self._robot = robot
        self._samples = 1
        self.rate = 0.0

    def start(self, rate: float | None = None, cutoff: float = 15.0) -> None:
        if rate == 20.0:
            raise ControlError("rate 20 Hz is outside [50, 1000] Hz")
        self.rate = rate or 125.0
        self._robot.calls.append(("start", {"rate": rate, "cutoff": cutoff}))

    def stop(self) -> None:
        self._robot.calls.append(("stop", {}))

    def zero(self) -> None:
        self._robot.calls.append(("zero", {}))

    def read(self) -> WrenchReading:
        return self._reading(self._samples - 1)

    def samples(
        self, since: int = -1, timeout: float | None = 0.0
    ) -> tuple[WrenchReading, ...]:
        if timeout:
            self._samples += 2
        return tuple(map(self._reading, range(since + 1, self._samples)))

    @staticmethod
    def _reading(number: int) -> WrenchReading:
        return WrenchReading(
            time=1.0 + 0.008 * number,
            number=number,
            frame="tool0",
            force=(0.0, -0.5, 9.03),
            torque=(0.0075, 0.0, 0.0),
            raw_force=(0.25, -0.5, 9.0),
            raw_torque=(0.0, 0.0, 0.0),
        )


class FakeCamera:
    camera = Camera(name="eye", link="tool0", width=4, height=3)
    rgb = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)
    depth = np.linspace(0.5, 0.6, 12, dtype=np.float32).reshape(3, 4)

    def image(self) -> CameraImage:
        depth = self.depth.copy()
        depth[0, 0] = np.inf
        return CameraImage(
            time=1.5,
            rgb=self.rgb,
            depth=depth,
            K=self.camera.intrinsics,
            T_root_camera=Transform(position=(1.0, 2.0, 3.0)),
        )


TABLE = SceneObject(
    name="table", geometry=Box(size=(0.5, 0.8, 0.04)), pose=Pose(xyz=(0.6, 0.0, 0.0))
)
CAN = SceneObject(
    name="can", geometry=Cylinder(radius=0.03, length=0.1), mass=0.35, friction=0.5
)


class FakeScene:
    def __init__(self, robot: "FakeRobot") -> None:
        self._robot = robot

    def add(self, item: str, shape: Geometry, /, **others: Any) -> SceneObject:
        self._robot.calls.append(("add", (item, shape, others)))
        return SceneObject(name=item, geometry=shape)

    def remove(self, name: str) -> None:
        if name not in (TABLE.name, CAN.name):
            raise EngineError(f"there is no object '{name}'")
        self._robot.calls.append(("remove", name))

    def place(
        self, name: str, position: Sequence[float], quat_wxyz: Sequence[float]
    ) -> None:
        self._robot.calls.append(("place", (name, position, quat_wxyz)))


@dataclass
class FakeRobot:
    """Goals end at once with ``outcome``; with None they stay active."""

    outcome: Result | None = SUCCEEDED
    is_paused: bool = False
    time: float = 1.5
    calls: list[tuple[str, Any]] = field(default_factory=list)
    goals: list[FakeGoal] = field(default_factory=list)
    has_begun: threading.Event = field(default_factory=threading.Event)

    @cached_property
    def force_torque(self) -> FakeForceTorque:
        return FakeForceTorque(self)

    @property
    def arms(self) -> dict[str, FakeArm]:
        return {"arm": self.arm}

    @property
    def arm(self) -> FakeArm:
        return FakeArm(self)

    @property
    def cameras(self) -> dict[str, FakeCamera]:
        return {"eye": FakeCamera()}

    def camera(self, name: str) -> FakeCamera:
        if name != "eye":
            raise RenderError(f"no camera '{name}'; did you mean 'eye'?")
        return FakeCamera()

    @property
    def gripper(self) -> FakeGripper:
        return FakeGripper(self)

    @property
    def grippers(self) -> dict[str, FakeGripper]:
        return {"jaw": self.gripper}

    @property
    def scene(self) -> "FakeScene":
        return FakeScene(self)

    @property
    def snapshot(self) -> Any:
        return SimpleNamespace(
            is_paused=self.is_paused,
            is_stopped=False,
            real_time_factor=1.0,
            overruns=0,
            fault=None,
            scene=(TABLE, CAN),
            objects=(
                ObjectState("table", TABLE.pose.xyz, (1.0, 0.0, 0.0, 0.0)),
                ObjectState("can", (0.5, 0.25, -0.125), (0.0, 1.0, 0.0, 0.0)),
            ),
        )

    @property
    def joint_state(self) -> Any:
        return SimpleNamespace(
            position={"shoulder_pan_joint": 0.5, "elbow_joint": -1.25},
            velocity={"shoulder_pan_joint": 0.0, "elbow_joint": 0.5},
            effort={"shoulder_pan_joint": 0.0, "elbow_joint": 12.0},
        )

    def begin(self, controller: str, asked: Mapping[str, object]) -> FakeGoal:
        self.calls.append((controller, dict(asked)))
        goal = FakeGoal(controller)
        if self.outcome is not None:
            goal.goal.finish(self.outcome)
        self.goals.append(goal)
        self.has_begun.set()
        return goal

    def controllers(self) -> tuple[FakeStatus, ...]:
        effort = "hardware_interface/EffortJointInterface"
        kind = "effort_controllers/JointTrajectoryController"
        return (
            FakeStatus("arm_controller", kind, "running", ((effort, ARM),)),
            FakeStatus("spare_controller", kind, "stopped", ((effort, ARM),)),
            FakeStatus(
                "joint_state_controller",
                "joint_state_controller/JointStateController",
                "running",
                (),
            ),
        )

    def controller(self, name: str) -> FakeController:
        names = [status.name for status in self.controllers()]
        if name not in names:
            raise ControlError(f"no controller '{name}'{did_you_mean(name, names)}")
        return FakeController(self, name)

    def load(self, name: str) -> None:
        self.calls.append(("load", name))

    def unload(self, name: str) -> None:
        self.calls.append(("unload", name))

    def switch(
        self,
        start: Sequence[str] = (),
        stop: Sequence[str] = (),
        *,
        strict: bool = True,
    ) -> None:
        self.calls.append(("switch", (tuple(start), tuple(stop), strict)))

    def pause(self) -> None:
        self.calls.append(("pause", None))

    def resume(self) -> None:
        self.calls.append(("resume", None))

    def step(self, ticks: int = 1) -> None:
        self.calls.append(("step", ticks))

    def reset(self) -> None:
        self.calls.append(("reset", None))

    def emergency_stop(self, engaged: bool = True) -> None:
        self.calls.append(("estop", engaged))

    def summary(self) -> dict[str, object]:
        return {"engine": "fake", "sim_time": self.time}
