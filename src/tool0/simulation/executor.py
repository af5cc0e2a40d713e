"""The executor, which starts and ends every motion of the robot.

Running controllers move the joints.  If a program has taken control of an arm, the
arm's motion controller moves the joints.  Clients, handlers and programs move the robot
only through the executor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, final

from tool0.control.arm.compliance import ComplianceTask
from tool0.control.arm.motion import ArmMotionController
from tool0.control.arm.path import ArmPath
from tool0.control.arm.torque import TorqueCommand
from tool0.control.controller import (
    CommandTaker,
    Controller,
    GripperDriver,
    SpeedScalable,
    TrajectoryFollower,
)
from tool0.control.position_limits import check_targets
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.drive_limits import DriveLimits
from tool0.errors import ControlError
from tool0.motion.joint import plan_cubic, plan_joints
from tool0.motion.path import Path
from tool0.protocol.controllers import KIND_OF, Role, why_not_driven
from tool0.protocol.goals import Goal
from tool0.simulation.core import Core
from tool0.simulation.paths import motion_plan, trajectory_points
from tool0.simulation.supervision.plan_watch import (
    ContactWatch,
    PlanWatch,
    links_moved_by,
)
from tool0.simulation.supervision.supervision import Supervision

if TYPE_CHECKING:
    from tool0.kinematics.chain import Array

STREAM_BRAKE = 4.0
"""Smallest deceleration of the leading joint at the end of a stream [rad/s²].  A stream
of velocities uses its own acceleration if it is larger."""


@final
class Executor:
    """Moves the robot of a core.

    Only the thread that executes the tick may use ``Executor``.
    """

    def __init__(self, core: Core) -> None:
        self.core = core
        self.supervision = Supervision(core)
        self.when_goal_starts: Callable[[Goal], None] = lambda goal: None
        self._manager = core.manager
        self._plan_watches: list[PlanWatch] = []

    # ---- goals of trajectory controllers --------------------------------------------

    def follow(
        self,
        controller: str,
        goal: TrajectoryGoal,
        bounds: Mapping[str, DriveLimits] | None = None,
    ) -> Goal:
        """Start a trajectory goal.

        ``bounds`` apply to the drive of a joint until the joint's next goal.
        """
        trajectory = self._follower(controller)
        accepted = trajectory.follow(goal, self._start([trajectory]))
        self._note_command(controller, goal.joint_names, bounds)
        return self._started(accepted)

    def command_trajectory(
        self,
        controller: str,
        goal: TrajectoryGoal,
        bounds: Mapping[str, DriveLimits] | None = None,
    ) -> None:
        """Follow a trajectory without a goal, as for a command from the ROS topic.

        A trajectory without points stops the motion.  ``bounds`` have the same meaning
        as for ``follow``.
        """
        trajectory = self._follower(controller)
        if goal.points:
            trajectory.command(goal, self.core.time)
        else:
            trajectory.stop_motion(self.core.time)
        self._note_command(controller, goal.joint_names, bounds)

    def follow_together(
        self,
        goals: Mapping[str, TrajectoryGoal],
        *,
        may_touch: frozenset[str],
        carried: frozenset[str],
    ) -> tuple[Goal, ...]:
        """Start goals of several controllers at the same time.

        If any goal is rejected, no goals are started.

        The motions stop at a new contact of a moved link or of an object in
        ``carried``, unless the contact is with a link or an object in ``may_touch``.
        """
        followers = {name: self._follower(name) for name in goals}
        accepted, start = [], self._start(list(followers.values()))
        try:
            for name, goal in goals.items():
                accepted.append(followers[name].follow(goal, start))
        except ControlError:
            for each in accepted:
                self.cancel(each)
            raise
        for name, goal in goals.items():
            self._note_command(name, goal.joint_names)
        started = tuple(map(self._started, accepted))
        joints = [name for goal in goals.values() for name in goal.joint_names or ()]
        watch = ContactWatch(
            links_moved_by(self.core.model, joints),
            self.core.engine.world.contacts(),
            carried=carried,
            may_touch=may_touch,
        )
        self._plan_watches.append(PlanWatch(started, watch))
        return started

    def scale_trajectory(self, controller: str, factor: float) -> None:
        """Scale the speed of a controller's trajectories by ``factor``."""
        running = self._manager.running(controller)
        if not isinstance(running, SpeedScalable):
            raise ControlError(
                f"the speed of '{controller}' cannot be scaled: only trajectory "
                "controllers of ROS 2 scale theirs"
            )
        running.scale_speed(factor)

    def move_joints(
        self, positions: Mapping[str, float], speed: float, controller: str | None
    ) -> tuple[Goal, ...]:
        """Start smooth motions of all involved controllers at the same time.

        All motions are planned before the first motion starts.

        If any motion is rejected, no motions are started.

        If ``controller`` is None, the controllers that claim the joints move them.
        """
        moves = self._moves(positions, controller)
        planned = []
        for name, targets in moves.items():
            trajectory = self._follower(name)
            path = self._planned(trajectory, targets, speed)
            planned.append((trajectory, motion_plan(path)))
        for name, targets in moves.items():
            self._note_command(name, targets)
        start = self._start([trajectory for trajectory, _ in planned])
        return tuple(
            self._started(trajectory.follow(plan, start))
            for trajectory, plan in planned
        )

    def move_joints_within(
        self, positions: Mapping[str, float], duration: float, controller: str | None
    ) -> tuple[Goal, ...]:
        """Start motions that take ``duration`` [s] of simulated time.

        The motions are cubic splines that end at rest.  The other joints of the
        controllers keep their setpoints.  The controllers are chosen in the same way as
        in ``move_joints``.
        """
        goals = {}
        for name, targets in self._moves(positions, controller).items():
            trajectory = self._follower(name)
            models = trajectory.spec.joint_models
            check_targets(trajectory.spec, targets, "the motion")
            start = trajectory.query_state(self.core.time)
            ends = [
                targets.get(joint.name, q)
                for joint, q in zip(models, start.positions, strict=True)
            ]
            path = plan_cubic(
                models, start, ends, max(duration, self.core.control_period)
            )
            goals[name] = TrajectoryGoal(
                points=trajectory_points(path), joint_names=path.joint_names
            )
        return tuple(self.follow(name, goal) for name, goal in goals.items())

    def steer(
        self, controller: str, positions: Mapping[str, float], speed: float
    ) -> None:
        """Replace a controller's motion with a smooth motion, without a goal."""
        trajectory = self._follower(controller)
        path = self._planned(trajectory, positions, speed)
        trajectory.command(motion_plan(path), self.core.time)
        self._note_command(controller, positions)

    def _start(self, followers: Sequence[TrajectoryFollower]) -> float:
        """Return the start time [s] of motions that are commanded now."""
        now = self.core.time
        if self.core.own_drives is None:
            return now
        motions = [follower.query_state(now) for follower in followers]
        return now + self._delay_from([v for one in motions for v in one.velocities])

    def _delay_from(self, velocities: Sequence[float]) -> float:
        """Return the start delay [s] of a motion that begins with ``velocities``.

        A real robot at rest should receive its motion before the motion starts, so that
        network delays do not affect it.
        """
        own_drives = self.core.own_drives
        if own_drives is None or any(velocities):
            return 0.0
        return own_drives.start_delay

    def trajectory_controller(self, name: str) -> TrajectoryFollower:
        """Return a running trajectory controller, or raise ControlError."""
        controller = self._manager.running(name)
        if not isinstance(controller, TrajectoryFollower):
            raise _wrong_role(name, controller, Role.TRAJECTORY)
        return controller

    # ---- other controllers ----------------------------------------------------------

    def command_gripper(
        self,
        controller: str,
        position: float,
        max_effort: float | None = None,
        bounds: DriveLimits | None = None,
        *,
        max_velocity: float | None = None,
    ) -> Goal:
        """Start a gripper goal in joint units: [rad | m] and [N·m | N].

        Without ``bounds``, the controller's limits for ``max_effort`` and
        ``max_velocity`` apply.
        """
        gripper = self._drivable(controller)
        if not isinstance(gripper, GripperDriver):
            raise _wrong_role(controller, gripper, Role.GRIPPER)
        bounds = bounds or gripper.limits(max_effort, max_velocity)
        goal = gripper.drive(position, max_effort, self.core.time, bounds)
        joint = gripper.joint.name
        self._note_command(controller, (joint,), {joint: bounds})
        return self._started(goal)

    def command_joints(self, controller: str, values: tuple[float, ...]) -> None:
        """Set the setpoints of a forwarding controller, in the order of its joints."""
        forward = self._drivable(controller)
        if not isinstance(forward, CommandTaker):
            raise _wrong_role(controller, forward, Role.COMMAND)
        forward.command_joints(values)
        self._note_command(controller)
        self._manager.release_brakes(controller, self.core.state)

    # ---- arms under program control -------------------------------------------------

    def take_arm(self, arm: str | None, by: str, *, protected: bool = False) -> None:
        """Give a program control of an arm; see ``Arm.take``."""
        found = self.core.arms.find(arm)
        found.take(by, self.core.state, protected=protected)
        self._note_command(found.motion.spec.name)

    def release_arm(self, arm: str | None, by: str | None = None) -> bool:
        """Stop an arm, and restart its controllers after it has come to rest.

        If ``by`` is given and a program with another name controls the arm, the
        function has no effect and returns False.
        """
        found = self.core.arms.find(arm)
        if by is not None and found.box.state.taken_by != by:
            return False
        found.release(self.core.state)
        return True

    def execute_path(
        self,
        arm: str | None,
        path: ArmPath,
        *,
        after: int | None = None,
        at: float | None = None,
    ) -> int:
        """Start a path of an arm, now or as a replacement of another path.

        The result is the number of the path; see ``ArmMotion.execute``.
        """
        self._mover(arm)
        found = self.core.arms.find(arm)
        start = self.core.time
        if after is None:
            speeds = found.motion.controller.motion(start).velocities
            start += self._delay_from(speeds)
        return found.motion.execute(path, start, after=after, at=at)

    def servo_joints(
        self,
        arm: str | None,
        positions: Sequence[float],
        *,
        lookahead_time: float,
        gain: float,
    ) -> None:
        """Follow ``positions`` [rad] as a target of a stream; see ``ServoStream``."""
        now, controller = self.core.time, self._mover(arm)
        controller.require_positions(positions, now)
        controller.servo(now).aim(positions, lookahead_time=lookahead_time, gain=gain)

    def speed_joints(
        self,
        arm: str | None,
        velocities: Sequence[float],
        acceleration: float,
        duration: float | None,
    ) -> None:
        """Move with ``velocities`` [rad/s] for ``duration`` [s], or until a stop."""
        now, controller = self.core.time, self._mover(arm)
        controller.require_velocities(velocities)
        until = now + (duration or math.inf)
        controller.speed(now).aim(velocities, acceleration, until=until)

    def speed_tool(
        self,
        arm: str | None,
        twist: Sequence[float],
        acceleration: float,
        duration: float | None,
        lever: Array,
    ) -> None:
        """Move a point with a twist [m/s, rad/s]; see also ``speed_joints``.

        ``lever`` is the position of the point in the flange frame [m].
        """
        now, controller = self.core.time, self._mover(arm)
        until = now + (duration or math.inf)
        controller.speed(now).aim(twist, acceleration, until=until, lever=lever)

    def drive(self, arm: str | None, command: TorqueCommand) -> None:
        """Drive the joints of an arm with torques; see ``Arm.drive``."""
        self.core.arms.find(arm).drive(command, self.core.state)

    def end_torques(self, arm: str | None) -> None:
        """Return an arm to position control; see ``Arm.end_torques``."""
        self.core.arms.find(arm).end_torques(self.core.state)

    def start_compliance(
        self, arm: str | None, task: ComplianceTask, controller: str | None = None
    ) -> None:
        """Start force mode or freedrive of an arm; see ``Arm.start_compliance``."""
        self.core.arms.find(arm).start_compliance(task, self.core.state, controller)
        if controller is not None:
            self._note_command(controller)

    def end_compliance(
        self, arm: str | None, controller: str | None = None, *, is_freedrive: bool
    ) -> None:
        """End force mode or freedrive; see ``Arm.end_compliance``."""
        found = self.core.arms.find(arm)
        found.end_compliance(self.core.state, controller, is_freedrive=is_freedrive)

    # ---- stops ----------------------------------------------------------------------

    def cancel(self, goal: Goal) -> None:
        """Stop the motion of an active goal; do nothing if the goal has ended."""
        if goal.status.is_terminal:
            return
        controller = self._manager.running(goal.controller)
        if isinstance(controller, TrajectoryFollower | GripperDriver):
            controller.cancel(goal, self.core.time)
        if isinstance(controller, GripperDriver):
            bounds = controller.limits(None, None)
            if bounds is not None:
                self.core.hardware.set_drive_limits(controller.joint.name, bounds)

    def stop_controllers(self) -> None:
        """Stop the joints that follow trajectories or single commands."""
        for status in self._manager.list():
            if not status.is_running:
                continue
            controller = self._manager.running(status.name)
            if isinstance(controller, CommandTaker):
                controller.stop_motion()
            elif isinstance(controller, TrajectoryFollower):
                now = controller.query_state(self.core.time)
                is_there = tuple(now.positions) == controller.setpoint().target()
                if any(now.velocities) or not is_there:
                    controller.stop_motion(self.core.time)

    def stop_arm(
        self, arm: str | None, deceleration: float, *, along_path: bool
    ) -> None:
        """Ramp an arm to rest; see ``ArmMotionController.stop_motion``."""
        found = self.core.arms.find(arm)
        controller = found.controller_to_stop()
        found.end_torques(self.core.state)
        controller.stop_motion(deceleration, self.core.time, along_path=along_path)

    def end_stream(self, arm: str | None) -> None:
        """Ramp an arm to rest if a stream of a program moves it."""
        controller = self.core.arms.find(arm).controller_to_move()
        if controller.mode in {"servo", "speed"}:
            rate = max(STREAM_BRAKE, controller.stream_deceleration())
            controller.stop_motion(rate, self.core.time, along_path=False)

    def supervise(self) -> None:
        """Stop the arms with a failed motion.

        ``supervise`` is called between two ticks.
        """
        for arm, reason, is_beyond_limits in self.supervision.failures():
            self.core.sync_from_kernel()
            stop = arm.stop_protectively if is_beyond_limits else arm.fail
            stop(reason, self.core.state)
        if self._plan_watches:
            self._watch_plans()

    def _watch_plans(self) -> None:
        """Stop planned motions that have unexpected contacts."""
        contacts = self.core.engine.world.contacts()
        for watch in self._plan_watches:
            reason = watch.contacts.unexpected(contacts)
            if reason and not watch.is_over:
                self.core.sync_from_kernel()
                watch.fail(reason)
                for goal in watch.goals:
                    self.cancel(goal)
        self._plan_watches = [one for one in self._plan_watches if not one.is_over]

    # ---- shared functions -----------------------------------------------------------

    def _mover(self, arm: str | None) -> ArmMotionController:
        """Return the motion controller of an arm, after ending its torque mode."""
        found = self.core.arms.find(arm)
        controller = found.controller_to_move()
        found.end_torques(self.core.state)
        return controller

    def _moves(
        self, positions: Mapping[str, float], controller: str | None
    ) -> Mapping[str, Mapping[str, float]]:
        """Return the positions, grouped by controller.

        If ``controller`` is None, each joint is assigned to the controller that claims
        it.
        """
        if controller is not None:
            return {controller: positions}
        return self._joints_by_controller(positions)

    def _joints_by_controller(
        self, positions: Mapping[str, float]
    ) -> Mapping[str, Mapping[str, float]]:
        """Return the positions, grouped by the joints' running trajectory controllers.

        Raises:
            ControlError: If no running trajectory controller drives a joint.
        """
        owners = {
            joint: status.name
            for status in self._manager.list()
            if status.is_running and status.role is Role.TRAJECTORY
            for joint in status.joints
        }
        found: dict[str, dict[str, float]] = {}
        for joint, position in positions.items():
            if joint not in owners:
                raise ControlError(why_not_driven(self._manager.list(), [joint]))
            found.setdefault(owners[joint], {})[joint] = position
        return found

    def _planned(
        self,
        controller: TrajectoryFollower,
        positions: Mapping[str, float],
        speed: float,
    ) -> Path:
        """Return a smooth motion from a controller's setpoint to ``positions``.

        The other joints of the controller continue their motion or keep their
        positions.  ``speed`` is a fraction of each joint's largest velocity.
        """
        joints = controller.spec.joint_models
        what = f"a motion of '{controller.spec.name}'"
        check_targets(controller.spec, positions, what)
        ends = controller.setpoint().target()
        # The current target of a joint that is not in ``positions`` may be beyond the
        # joint's limits.
        targets = [
            positions.get(joint.name, joint.limits.clamp(end))
            for joint, end in zip(joints, ends, strict=True)
        ]
        start = controller.query_state(self.core.time)
        return plan_joints(joints, start, targets, speed=speed)

    def _drivable(self, name: str) -> Controller:
        """Return a controller by name if it may currently move joints."""
        if self.core.hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before moving the robot"
            )
        return self._manager.running(name)

    def _follower(self, name: str) -> TrajectoryFollower:
        """Return a trajectory controller by name if it may currently move joints."""
        self._drivable(name)
        return self.trajectory_controller(name)

    def _note_command(
        self,
        controller: str,
        joints: Collection[str] | None = None,
        bounds: Mapping[str, DriveLimits | None] | None = None,
    ) -> None:
        """Record a command, and set the limits of the drives that it affects.

        ``joints`` are the joints that the goal lists; None stands for all joints of the
        controller.  Drives that have no entry in ``bounds`` are not limited.
        """
        for _, claimed in self._manager.status(controller).claimed:
            self.core.note_commanded(claimed)
            for joint in claimed:
                if joints is None or joint in joints:
                    bound = (bounds or {}).get(joint)
                    self.core.hardware.set_drive_limits(joint, bound)

    def _started(self, goal: Goal) -> Goal:
        goal.explain = partial(self.supervision.explained, goal)
        self.when_goal_starts(goal)
        return goal


def _wrong_role(name: str, controller: Controller, wanted: Role) -> ControlError:
    return ControlError(
        f"controller '{name}' is a {type(controller).__name__}; "
        f"this needs a {KIND_OF[wanted]}"
    )
