"""Handle for an arm: the pose of its tool, inverse kinematics, and motions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, TypedDict, final

from tool0.api.arm_motion import ArmMotion
from tool0.api.control_box import ControlBox
from tool0.api.controller import GoalHandle
from tool0.api.sensors import ForceTorque
from tool0.description.posture import Branch, Solution
from tool0.description.transform import Pose, Transform
from tool0.errors import ControlError, RequestError
from tool0.protocol.arm import (
    ArmInfo,
    MoveLinear,
    MoveTo,
    ReadBranch,
    ReadToolPose,
    SolveInverseKinematics,
)
from tool0.protocol.channel import Channel
from tool0.protocol.planning import (
    Checked,
    CheckMotion,
    ExecutePlan,
    KeepOut,
    Plan,
    PlanMotion,
    PlanTarget,
    Upright,
)
from tool0.protocol.poses import GoToPose
from tool0.protocol.request import CollisionRule, JointPositions, checked_value, plain

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from tool0.kinematics.chain import ArmChain
    from tool0.kinematics.inverse import InverseKinematics

AnyPose = Transform | Pose | Iterable[Sequence[float]]
"""A pose: a ``Transform``, a ``Pose``, or a homogeneous matrix of shape (4, 4)."""


class PlanOptions(TypedDict, total=False):
    """Options for planning a collision-free motion."""

    speed: float
    """Fraction of each joint's maximum velocity, 0.01 … 1; the default is 0.5."""
    clearance: float
    """Minimum distance between bodies [m]; the default is 0.005."""
    may_touch: tuple[str, ...]
    """Links and objects that the robot is allowed to touch, such as the object to
    grip."""
    keep_out: tuple[KeepOut, ...]
    """Regions (boxes, or half-spaces below a plane) that the robot must not enter."""
    upright: Upright
    """Constraint that keeps a tool axis within an angle of its initial direction."""
    joint_ranges: dict[str, tuple[float, float]]
    """Joint → narrower position limits for this motion [rad]."""
    timeout: float
    """Wall time after which the search ends [s]; the default is 5."""
    seed: int
    """Seed of the search; the same seed gives the same plan unless the search times
    out."""


@final
class Arm:
    """An arm with six joints, with its tool pose, inverse kinematics and motions.

    A pose is a ``Pose`` (xyz [m], rpy [rad]), a ``Transform``, or a homogeneous matrix
    of shape (4, 4).  A pose describes the frame ``tool``, which is fixed to the link
    ``tip``, relative to the link ``relative_to``.  By default, ``tool`` is the frame of
    ``tip``, ``tip`` is the arm's flange, and ``relative_to`` is the robot's root.  A
    motion starts at the commanded posture, so that control errors do not accumulate
    over many motions.
    """

    def __init__(self, info: ArmInfo, channel: Channel) -> None:
        self._info = info
        self._channel = channel

    @property
    def name(self) -> str:
        """Name of the arm.

        The name is the prefix of the arm's links, or ``arm`` if the links have no
        prefix.  In a cell, it is the name of the robot.
        """
        return self._info.name

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the six joints, from base to tip."""
        return self._info.joint_names

    @property
    def tip(self) -> str:
        """Link at the end of the arm, and the default ``tip`` of poses."""
        return self._info.tip

    @property
    def joints(self) -> Mapping[str, float]:
        """Measured joint positions by name [rad], from base to tip."""
        position = self._channel.snapshot.positions
        return {name: position[name] for name in self.joint_names}

    @property
    def chain(self) -> ArmChain:
        """Kinematic chain of the arm's joints and links, for calculations."""
        return self._chain

    @cached_property
    def _chain(self) -> ArmChain:
        from tool0.kinematics.chain import find_chains

        return find_chains(self._channel.description.model)[self.name]

    @property
    def kinematics(self) -> InverseKinematics:
        """Inverse kinematics of the arm.

        Reading it raises ControlError if the arm does not have the kinematics of a UR.
        """
        return self._kinematics

    @cached_property
    def _kinematics(self) -> InverseKinematics:
        from tool0.kinematics.inverse import InverseKinematics

        return InverseKinematics(self.chain)

    @property
    def force_torque(self) -> ForceTorque:
        """The force-torque sensor at the end of the arm."""
        return ForceTorque(self.tip, self._channel)

    @property
    def control_box(self) -> ControlBox:
        """Control box of the arm: I/O pins, speed slider, payload and program."""
        return ControlBox(self.name, self._channel)

    @property
    def motion(self) -> ArmMotion:
        """Handle that moves the arm along paths or with streams of commands."""
        return ArmMotion(self.name, self._channel)

    def go_to_pose(
        self, name: str, *, speed: float = 0.5, collision: CollisionRule = "refuse"
    ) -> tuple[GoalHandle, ...]:
        """Move the arm to a named pose; the gripper does not move.

        A pose that contains only gripper joints, such as ``open``, moves the gripper.

        Args:
            name: A built-in or saved pose; joints of other robots in the pose do not
                move.
            speed: Fraction of each joint's maximum velocity, 0.01 … 1.
            collision: See ``move_to``.

        Raises:
            ControlError: If the pose does not exist, or if it cannot be reached.
        """
        request = GoToPose(name=name, robot=self.name, speed=speed, collision=collision)
        goals = self._channel.call(request)
        return tuple(GoalHandle(goal, self._channel) for goal in goals)

    @property
    def branch(self) -> Branch:
        """Current branch of the inverse kinematics, one of eight."""
        return self._channel.call(ReadBranch(arm=self.name))

    def pose(
        self,
        *,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
    ) -> Transform:
        """Return the measured pose of the tool.

        Args:
            tip: A link that is fixed to the flange; the default is the flange.
            tool: Pose of the tool relative to ``tip``; the default is the frame of
                ``tip``.
            relative_to: Link in whose frame the pose is given; the default is the
                robot's root.

        Raises:
            ModelError: If a link is unknown, or if ``tool`` is not a pose.
        """
        return self._channel.call(
            ReadToolPose(
                arm=self.name, tip=tip, tool=_sendable(tool), relative_to=relative_to
            )
        )

    def inverse_kinematics(
        self,
        pose: AnyPose,
        *,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
        near: Mapping[str, float] | None = None,
        branch: Branch | None = None,
    ) -> tuple[Solution, ...]:
        """Return the joint positions that reach ``pose``, nearest solution first.

        There is at most one solution per branch.  A multiple of 2π is added to each
        position to bring it within the joint's limits and as close as possible to
        ``near``.  Collisions are not checked.

        Args:
            pose: The pose of the tool.
            tip: A link that is fixed to the flange; the default is the flange.
            tool: Pose of the tool relative to ``tip``; the default is the frame of
                ``tip``.
            relative_to: Link in whose frame ``pose`` is given; the default is the
                robot's root.
            near: Joint → position [rad]; the default of each joint is its commanded
                position.
            branch: Branch of the returned solution; by default, all branches are
                returned.

        Raises:
            UnreachableError: If there is no solution; the message contains the reason.
            ModelError: If ``pose`` or ``tool`` is not a pose, or if a link is unknown.
            ControlError: If the arm does not have the kinematics of a UR.
        """
        return self._channel.call(
            SolveInverseKinematics(
                arm=self.name,
                pose=_sendable(pose),
                tip=tip,
                tool=_sendable(tool),
                relative_to=relative_to,
                near={} if near is None else near,  # type: ignore[arg-type]
                branch=branch,
            )
        )

    def move_to(
        self,
        pose: AnyPose,
        *,
        speed: float = 0.5,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
        near: Mapping[str, float] | None = None,
        branch: Branch | None = None,
        collision: CollisionRule = "refuse",
        plan: bool = False,
    ) -> GoalHandle:
        """Move the tool to ``pose`` in joint space, and return the goal.

        As with ``Robot.move_joints``, the motion is as fast as ``speed`` and the limits
        of joint velocity, acceleration and jerk allow.  The tool moves along a curve.
        The target is the nearest solution of ``inverse_kinematics``.

        Args:
            pose: The pose of the tool.
            speed: Fraction of each joint's maximum velocity, 0.01 … 1.
            tip: See ``inverse_kinematics``.
            tool: See ``inverse_kinematics``.
            relative_to: See ``inverse_kinematics``.
            near: See ``inverse_kinematics``.
            branch: See ``inverse_kinematics``.
            collision: ``refuse`` the motion if the arm would collide on the path (the
                error contains the bodies and the position on the path), or ``ignore``
                collisions.
            plan: Whether to plan a motion around obstacles, to any posture that reaches
                the pose.

        Raises:
            UnreachableError: If no posture reaches the pose.
            CollisionError: If the arm would collide on the straight path in joint
                space.
            PlanningError: If no path around the obstacles is found.
            ControlError: If no running JointTrajectoryController has the arm's joints,
                or if the controller refuses the goal; the robot then does not move.
        """
        if plan:
            if near or branch:
                raise ControlError("a planned motion has neither near nor branch")
            found = self.plan(
                pose, tip=tip, tool=tool, relative_to=relative_to, speed=speed
            )
            return self.execute(found)
        request = MoveTo(
            arm=self.name,
            pose=_sendable(pose),
            speed=speed,
            tip=tip,
            tool=_sendable(tool),
            relative_to=relative_to,
            near={} if near is None else near,  # type: ignore[arg-type]
            branch=branch,
            collision=collision,
        )
        return GoalHandle(self._channel.call(request), self._channel)

    def move_linear(
        self,
        pose: AnyPose,
        *,
        speed: float = 0.25,
        acceleration: float = 1.2,
        angular_speed: float = 1.0,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
        collision: CollisionRule = "refuse",
    ) -> GoalHandle:
        """Move the tool to ``pose`` along a straight line, and return the goal.

        The tool rotates about one fixed axis.  The tool decelerates where a joint would
        otherwise exceed its velocity or acceleration limit.  The whole line is checked
        before the motion starts.  The arm must be at rest.  The default speed and
        acceleration are the same as in URScript's ``movel``.  The rotation accelerates
        and decelerates for the same durations as the translation.

        Args:
            pose: The pose of the tool at the end.
            speed: Maximum speed of the tool [m/s].
            acceleration: Maximum acceleration of the tool [m/s²].
            angular_speed: Maximum angular speed of the tool [rad/s].
            tip: See ``inverse_kinematics``.
            tool: See ``inverse_kinematics``.
            relative_to: See ``inverse_kinematics``.
            collision: ``refuse`` the motion if the arm would collide on the line (the
                error contains the bodies and the position on the line), or ``ignore``
                collisions.

        Raises:
            CollisionError: If the arm would collide on the line.
            UnreachableError: If the arm cannot follow the line without a joint jump;
                the message contains the reason and the position on the line.
            ControlError: If the arm is moving or is already at ``pose``, if no running
                JointTrajectoryController has the arm's joints, or if the controller
                refuses the goal.
        """
        request = MoveLinear(
            arm=self.name,
            pose=_sendable(pose),
            speed=speed,
            acceleration=acceleration,
            angular_speed=angular_speed,
            tip=tip,
            tool=_sendable(tool),
            relative_to=relative_to,
            collision=collision,
        )
        return GoalHandle(self._channel.call(request), self._channel)

    # ---- around obstacles -----------------------------------------------------------

    def plan(
        self,
        target: AnyPose | Mapping[str, float],
        *,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
        free_axis: Literal["x", "y", "z"] | None = None,
        **options: Unpack[PlanOptions],
    ) -> Plan:
        """Plan a collision-free motion to a target, and return the plan.

        The robot does not move.  The planned motion starts at the commanded posture,
        and ends at rest.  An object in a gripper moves with it.  The clearance applies
        to all pairs of robots, objects, held objects and the ground, except for links
        that touch by construction.  Bodies that are closer at the start are allowed to
        remain closer.

        Args:
            target: A pose of the tool, or joint → position [rad].  For a pose, all
                postures that reach the pose are targets, including postures with
                additional full turns of a joint.
            tip: See ``inverse_kinematics``.
            tool: See ``inverse_kinematics``.
            relative_to: See ``inverse_kinematics``; if this link is ``tip``, the target
                is relative to the current pose of the tool.
            free_axis: An axis of the tool about which the rotation at the target is
                free.
            **options: Options of the search; see ``PlanOptions``.

        Raises:
            CollisionError: If the start or the target is in collision; the message
                contains the bodies.
            PlanningError: If no collision-free motion is found, or if the compiled
                kernel is missing.
            UnreachableError: If no posture reaches the target.
            ControlError: If the arm does not have the kinematics of a UR.
        """
        wanted = self.target(
            target, tip=tip, tool=tool, relative_to=relative_to, free_axis=free_axis
        )
        return self._channel.call(PlanMotion(targets=(wanted,), **options))

    def execute(self, plan: Plan) -> GoalHandle:
        """Follow a plan, and return the goal.

        A new contact that the plan does not allow stops the motion.  The goal then ends
        as ABORTED, and the result contains the bodies.

        Raises:
            ControlError: If the plan is for another arm or for several arms, if the arm
                or an object has moved since the planning, if no running
                JointTrajectoryController has the arm's joints, or if the controller
                refuses the goal.
        """
        if not isinstance(plan, Plan):
            raise RequestError("execute", f"'plan': need a Plan, got {plan!r:.80}")
        names = checked_value("execute", "plan", plan.joint_names, tuple[str, ...])
        if set(names) != set(self.joint_names):
            raise ControlError("the plan is of other arms: use robot.execute")
        (goal,) = self._channel.call(ExecutePlan(number=plan.number))
        return GoalHandle(goal, self._channel)

    def check(
        self,
        target: AnyPose | Mapping[str, float],
        *,
        linear: bool = False,
        clearance: float = 0.0,
        may_touch: Sequence[str] = (),
        keep_out: Sequence[KeepOut] = (),
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
    ) -> Checked:
        """Return whether a motion by ``move_to`` or ``move_linear`` is collision-free.

        Args:
            target: See ``plan``.
            linear: Whether the tool moves along a straight line.
            clearance: Minimum distance between bodies [m].
            may_touch: Links and objects that the robot is allowed to touch.
            keep_out: Regions that the robot must not enter; see ``PlanOptions``.
            tip: See ``inverse_kinematics``.
            tool: See ``inverse_kinematics``.
            relative_to: See ``inverse_kinematics``.

        Raises:
            UnreachableError: If no posture reaches the target, or if the arm cannot
                follow the line.
        """
        return self._channel.call(
            CheckMotion(
                target=self.target(target, tip=tip, tool=tool, relative_to=relative_to),
                linear=linear,
                clearance=clearance,
                may_touch=may_touch,  # type: ignore[arg-type]  # any sequence
                keep_out=keep_out,  # type: ignore[arg-type]
            )
        )

    def target(
        self,
        target: AnyPose | Mapping[str, float],
        *,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
        free_axis: Literal["x", "y", "z"] | None = None,
    ) -> PlanTarget:
        """Return a target for ``Robot.plan``, from the same arguments as ``plan``."""
        positions, pose = {}, None
        if isinstance(target, Mapping):
            positions = checked_value("target", "target", target, JointPositions)
        else:
            pose = _sendable(target)
        return PlanTarget(
            arm=self.name,
            positions=positions,
            pose=pose,
            tip=tip,
            tool=_sendable(tool),
            relative_to=relative_to,
            free_axis=free_axis,
        )


def _sendable(pose: AnyPose | None) -> Any:
    """Return a pose in the form that requests use: a Pose, or the rows of a matrix."""
    if pose is None or isinstance(pose, Pose):
        return pose
    if isinstance(pose, Transform):
        rows = zip(pose.rotation, pose.position, strict=True)
        return (*((*row, p) for row, p in rows), (0.0, 0.0, 0.0, 1.0))
    try:
        return plain(pose)
    except ValueError:  # a value is not finite: the handler reports this
        return pose
