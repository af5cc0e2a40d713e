"""The handle on an arm: where its tool is, and how to move it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

from tool0.api.channel import Channel
from tool0.api.controller import GoalHandle
from tool0.description.transform import Pose, Transform
from tool0.kinematics.inverse import Branch, Solution
from tool0.requests import arm
from tool0.requests.table import plain

if TYPE_CHECKING:
    from tool0.kinematics.chain import ArmChain
    from tool0.kinematics.inverse import InverseKinematics

AnyPose = Transform | Pose | Iterable[Sequence[float]]
"""A pose; anything else is a homogeneous matrix, shape (4, 4)."""


@final
class Arm:
    """Moves six joints so that a tool gets where it should.

    Poses are those of ``tool`` in link ``tip`` (of ``tip`` itself, if left out; of the
    arm's flange, if that is left out too) in the frame of link ``relative_to`` (of the
    robot's root, if left out).  Motions start from the commanded posture: errors of
    the controller do not add up over many motions.
    """

    def __init__(self, info: arm.ArmInfo, channel: Channel) -> None:
        self.name = info.name
        self.joint_names: tuple[str, ...] = info.joint_names
        """Its six joints, from the base on."""
        self.tip = info.tip
        """The link at its end, which poses are of if no other is named."""
        self._channel = channel

    @property
    def joints(self) -> Mapping[str, float]:
        """Measured positions [rad], from the base on."""
        position = self._channel.snapshot.positions
        return {name: position[name] for name in self.joint_names}

    @cached_property
    def chain(self) -> ArmChain:
        """Its joints and links, for computations of your own."""
        from tool0.kinematics.chain import find_chains

        return find_chains(self._channel.description.model)[self.name]

    @cached_property
    def kinematics(self) -> InverseKinematics:
        """Its inverse kinematics, or ControlError if it is not built like a UR."""
        from tool0.kinematics.inverse import InverseKinematics

        return InverseKinematics(self.chain)

    @property
    def branch(self) -> Branch:
        """The kind of posture in which it stands, of eight."""
        return self._channel.call(arm.ReadBranch(arm=self.name))

    def pose(
        self,
        *,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
    ) -> Transform:
        """Return the measured pose of the tool."""
        return self._channel.call(
            arm.ReadToolPose(
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
        """Return the postures that put the tool at ``pose``, the nearest first.

        One for each branch, with the whole turns that bring every joint nearest to
        ``near`` within its limits.  Collisions are not considered.

        Args:
            pose: The pose of the tool.
            tip: A link that is fixed to the flange.
            tool: The tool's pose in that link.
            relative_to: The link in whose frame ``pose`` is.
            near: Joint → position [rad]; joints left out count as they stand.
            branch: Only postures of this kind.

        Raises:
            UnreachableError: If there is none, with the reason.
            ModelError: If the pose is not a pose, or a link is unknown.
            ControlError: If the arm is not built like a UR.
        """
        return self._channel.call(
            arm.SolveInverseKinematics(
                arm=self.name,
                pose=_sendable(pose),
                tip=tip,
                tool=_sendable(tool),
                relative_to=relative_to,
                near=dict(near or {}),
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
    ) -> GoalHandle:
        """Move the tool to ``pose``, the joints as fast as allowed; return the goal.

        The motion is the shortest within the joints' velocities, accelerations and
        jerks, as that of ``Robot.move_joints``; the tool's path is a curve.

        ``speed`` is a fraction of each joint's largest velocity, 0.01 … 1.  The other
        arguments are those of ``inverse_kinematics``; its nearest solution is taken.

        Raises:
            UnreachableError: If no posture reaches the pose.
            ControlError: If no running JointTrajectoryController has the arm's joints,
                or it refuses; nothing moves then.
        """
        request = arm.MoveTo(
            arm=self.name,
            pose=_sendable(pose),
            speed=speed,
            tip=tip,
            tool=_sendable(tool),
            relative_to=relative_to,
            near=dict(near or {}),
            branch=branch,
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
    ) -> GoalHandle:
        """Move the tool to ``pose`` along a straight line, and return the goal.

        It rotates about one axis meanwhile, and slows down where a joint would exceed
        its velocity or acceleration.  The whole line is checked before anything moves.
        The arm must be at rest.

        ``speed`` [m/s], ``acceleration`` [m/s²] and ``angular_speed`` [rad/s] are those
        of the tool; the first two default to those of UR's movel, and the rotation
        gets a ramp of the same duration.  The other arguments are those of
        ``inverse_kinematics``.

        Raises:
            UnreachableError: If the arm cannot follow the line without a jump of its
                joints, with the reason and the place on the line.
            ControlError: If the arm is moving, if it is there already, if no running
                JointTrajectoryController has the arm's joints, or it refuses.
        """
        request = arm.MoveLinear(
            arm=self.name,
            pose=_sendable(pose),
            speed=speed,
            acceleration=acceleration,
            angular_speed=angular_speed,
            tip=tip,
            tool=_sendable(tool),
            relative_to=relative_to,
        )
        return GoalHandle(self._channel.call(request), self._channel)


def _sendable(pose: AnyPose | None) -> Any:
    """Return a pose as a request has it: a Pose, or the rows of a matrix."""
    if pose is None or isinstance(pose, Pose):
        return pose
    if isinstance(pose, Transform):
        rows = zip(pose.rotation, pose.position, strict=True)
        return (*((*row, p) for row, p in rows), (0.0, 0.0, 0.0, 1.0))
    try:
        return plain(pose)
    except ValueError:  # not finite: the handler says so
        return pose
