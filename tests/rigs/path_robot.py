"""A second backend: a robot that reports a state and follows joint paths, no more."""

import threading
import time
from typing import Final, final

import tool0
from tool0.description.loading import load_description
from tool0.protocol.bus import GoalFinished
from tool0.protocol.controllers import ControllerStatus, Role
from tool0.protocol.goals import Goal, GoalResult, GoalStarted, GoalStatus
from tool0.protocol.live_backend import LiveBackend, LiveStates
from tool0.protocol.motion import MoveJoints
from tool0.protocol.robot import LimitsInfo, ReadInfo, SimulationInfo
from tool0.protocol.state import Snapshot
from tool0.protocol.trajectories import FollowTrajectory

PERIOD: Final = 0.008  # [s]
REASON: Final = "this robot only follows joint paths"


@final
class PathRobot:
    """Its joints move in proportion, without dynamics."""

    def __init__(self) -> None:
        description = load_description(tool0.DescriptionConfig(arm="ur5e"))
        self._joints = description.model.movable_joints
        self._zeros = (0.0,) * len(self._joints)
        self._start, self._end = self._zeros, self._zeros
        self._since, self._duration = 0.0, 1.0
        self._goal: Goal | None = None
        self._closed = threading.Event()
        self.states = LiveStates(description, self._state(), self._closed.set)
        handlers = {
            ReadInfo: self._info,
            MoveJoints: self._move,
            FollowTrajectory: self._follow,
        }
        self.backend = LiveBackend(self.states, handlers, REASON)
        threading.Thread(target=self._run, daemon=True).start()

    def _info(self, _: ReadInfo) -> SimulationInfo:
        limits = {joint.name: LimitsInfo.of(joint.limits) for joint in self._joints}
        return SimulationInfo(control_period=PERIOD, joint_limits=limits)

    def _move(self, request: MoveJoints) -> tuple[GoalStarted]:
        here = self.states.snapshot.positions
        self._since, self._duration = time.monotonic(), request.duration or 0.5
        self._start = tuple(here.values())
        self._end = tuple({**here, **request.positions}.values())
        self._goal = goal = Goal("paths")
        return (GoalStarted(goal=self.states.goals.add(goal), controller="paths"),)

    def _follow(self, request: FollowTrajectory) -> GoalStarted:
        end = request.points[-1]
        places = dict(zip(request.joint_names or (), end.positions, strict=True))
        (goal,) = self._move(MoveJoints(positions=places, duration=end.time_from_start))
        return goal

    def _state(self) -> Snapshot:
        now = time.monotonic()
        done = min(1.0, (now - self._since) / self._duration)
        ways = zip(self._start, self._end, strict=True)
        names = tuple(joint.name for joint in self._joints)
        controller = ControllerStatus(
            name="paths",
            type="joint_trajectory_controller/JointTrajectoryController",
            role=Role.TRAJECTORY,
            state="active",
            is_running=True,
            claimed=(("position", names),),
        )
        return Snapshot(
            time=now,
            tick=int(now / PERIOD),
            joint_names=names,
            position=tuple(a + done * (b - a) for a, b in ways),
            velocity=self._zeros,
            effort=self._zeros,
            controllers=(controller,),
        )

    def _run(self) -> None:
        while not self._closed.wait(PERIOD):
            goal, state = self._goal, self._state()
            self.states.bus.publish(state)
            if goal is not None and state.position == self._end:
                self._goal = None
                goal.finish(GoalResult(status=GoalStatus.SUCCEEDED))
                self.states.bus.announce(GoalFinished(goal, state.time))
