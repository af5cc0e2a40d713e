"""The arm as a person thinks of it: by where its tool is."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from tool0.control.trajectory import TrajectoryPoint
from tool0.description.forward_kinematics import link_poses
from tool0.description.transform import AnyPose, Transform, as_matrix, from_matrix
from tool0.errors import ControlError
from tool0.kinematics.chain import ArmChain, Array, fixed_transform
from tool0.kinematics.inverse import Branch, InverseKinematics, Solution
from tool0.kinematics.line import LinePath
from tool0.runtime.linear_motion import LinearLimits, LinearMotion

if TYPE_CHECKING:
    from tool0.runtime.handles import ControllerHandle, GoalHandle
    from tool0.runtime.robot import Robot

_LATER = 1e6
"""After so long every motion is over [s]."""
AT_REST = 1e-6
"""Slower than this counts as standing still [rad/s, rad/s²]."""


@final
class Arm:
    """Moves six joints so that a tool gets where it should.

    Poses are those of ``tool`` in link ``tip`` (of ``tip`` itself, if left out; of the
    arm's flange, if that is left out too) in the frame of link ``relative_to`` (of the
    robot's root, if left out).  The arm counts as standing where its controller wants
    it: what it droops below that adds up to nothing, however many motions there are.
    """

    def __init__(self, name: str, chain: ArmChain, robot: Robot) -> None:
        self.name = name
        self.chain = chain
        self._robot = robot

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Its six joints, from the base on."""
        return self.chain.joint_names

    @property
    def tip(self) -> str:
        """The link at its end, which poses are of if no other is named."""
        return self.chain.tip

    @property
    def joints(self) -> Mapping[str, float]:
        """Measured positions [rad], from the base on."""
        position = self._robot.joint_state.position
        return {name: position[name] for name in self.joint_names}

    @cached_property
    def kinematics(self) -> InverseKinematics:
        """Its inverse kinematics, or ControlError if it is not built like a UR."""
        return InverseKinematics(self.chain)

    @property
    def branch(self) -> Branch:
        """Which of the eight kinds of postures it is in."""
        return self.kinematics.branch(np.array(list(self.joints.values())))

    def pose(
        self,
        *,
        tip: str | None = None,
        tool: AnyPose | None = None,
        relative_to: str | None = None,
    ) -> Transform:
        """Return where the tool is, as measured."""
        model = self._robot.description.model
        found = link_poses(model, self._robot.joint_state.position)
        T_root_tool = found[self.chain.tip] @ from_matrix(self._tool(tip, tool))
        if relative_to is None:
            return T_root_tool
        return found[model.link(relative_to).name].inverse() @ T_root_tool

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
        ``near`` within its limits.  Collisions are not looked at.

        Args:
            pose: Where the tool is to be.
            tip: A link that is fixed to the flange.
            tool: The tool's pose in that link.
            relative_to: The link in whose frame ``pose`` is.
            near: Joint → position [rad]; joints left out count as where they stand.
            branch: Only postures of this kind.

        Raises:
            UnreachableError: If there is none; it says why.
            ModelError: If the pose is none, or a link is unknown.
            ControlError: If the arm is not built like a UR.
        """
        standing = self._standing()
        reference = np.array([standing[name] for name in self.joint_names])
        for joint, position in (near or {}).items():
            if joint not in self.joint_names:
                names = ", ".join(self.joint_names)
                raise ControlError(f"near: '{joint}' is none of the arm's: {names}")
            reference[self.joint_names.index(joint)] = position
        if not np.isfinite(reference).all():
            raise ControlError(f"near: positions must be finite, got {near}")
        T_base_tool = self._in_base(pose, relative_to, standing)
        T_base_tip = T_base_tool @ np.linalg.inv(self._tool(tip, tool))
        return self.kinematics.solutions(T_base_tip, reference, branch)

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
        """Send the tool to ``pose``, the joints by their fastest way; return the goal.

        The motion is the shortest within the joints' velocities, accelerations and
        jerks, as that of ``Robot.move_joints``; the tool's path is a curve.

        Args:
            pose: As for ``inverse_kinematics``, whose nearest solution is taken.
            speed: Part of each joint's largest velocity, 0.01 … 1.
            tip: As there.
            tool: As there.
            relative_to: As there.
            near: As there.
            branch: As there.

        Raises:
            UnreachableError: If no posture reaches the pose.
            ControlError: If no running JointTrajectoryController has the arm's joints,
                or it refuses; nothing moves then.
        """
        controller = self._controller()
        solution = self.inverse_kinematics(
            pose, tip=tip, tool=tool, relative_to=relative_to, near=near, branch=branch
        )[0]
        return controller.move(solution.positions, speed=speed)

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
        """Send the tool to ``pose`` along a straight line, and return the goal.

        It turns about one axis meanwhile, and is slower where a joint would exceed its
        velocity or acceleration.  The whole line is looked at before anything moves.
        The arm must be at rest.

        Args:
            pose: As for ``inverse_kinematics``.
            speed: Of the tool [m/s]; it and ``acceleration`` are what a UR's own movel
                takes if they are left out.
            acceleration: Of the tool [m/s²]; turning gets as long a ramp.
            angular_speed: Of the tool [rad/s].
            tip: As for ``inverse_kinematics``.
            tool: As there.
            relative_to: As there.

        Raises:
            UnreachableError: If the arm cannot follow the line without a jump of its
                joints; it says why, and where on the line.
            ControlError: If the arm is moving, if it is there already, if no running
                JointTrajectoryController has the arm's joints, or it refuses.
        """
        limits = LinearLimits(
            speed=speed, acceleration=acceleration, angular_speed=angular_speed
        )
        controller = self._controller()
        standing = self._at_rest(controller)
        start = np.array([standing[name] for name in self.joint_names])
        T_tip_tool = self._tool(tip, tool)
        T_base_tip = self.chain.forward(start[None]).T_base_tip[0]
        everywhere = {**self._robot.joint_state.position, **standing}
        end = self._in_base(pose, relative_to, everywhere)
        found = link_poses(self._robot.description.model, everywhere)
        T_root_base = found[self.chain.base].matrix
        line = LinePath(T_base_tip @ T_tip_tool, end, T_tip_tool, T_root_base)
        points = LinearMotion(self.kinematics, line, start, limits).points()
        if self._at_rest(controller) != standing:
            raise ControlError("the arm was moved while its line was planned")
        return controller.follow(
            [self._with_others(point, standing) for point in points],
            joint_names=list(standing),
        )

    def _controller(self) -> ControllerHandle:
        """Return the trajectory controller that has the arm's joints."""
        for status in self._robot.controllers():
            claimed = {joint for _, joints in status.claimed for joint in joints}
            if (
                status.state == "running"
                and status.type.endswith("/JointTrajectoryController")
                and claimed.issuperset(self.joint_names)
            ):
                return self._robot.controller(status.name)
        raise ControlError(
            f"no running JointTrajectoryController claims the joints of '{self.name}', "
            f"so nothing moves; start one that does: {', '.join(self.joint_names)}"
        )

    def _standing(self) -> Mapping[str, float]:
        """Return the positions of all joints: the arm's as wanted, if anybody does."""
        position = self._robot.joint_state.position
        try:
            state = self._controller().state
        except ControlError:
            return position
        wanted = zip(state.joint_names, state.desired.positions, strict=True)
        return {**position, **dict(wanted)}

    def _at_rest(self, controller: ControllerHandle) -> Mapping[str, float]:
        """Return where a controller's joints stand, or raise ControlError."""
        state = controller.state
        now = state.desired
        end = controller.query_state(state.time + _LATER)
        still = max(map(abs, (*now.velocities, *now.accelerations))) < AT_REST
        there = zip(now.positions, end.positions, strict=True)
        if not still or max(abs(q - last) for q, last in there) > AT_REST:
            raise ControlError(
                f"move_linear starts at rest, and '{controller.name}' is moving; wait "
                "for its goal, or cancel that"
            )
        return dict(zip(state.joint_names, now.positions, strict=True))

    def _with_others(
        self, point: TrajectoryPoint, standing: Mapping[str, float]
    ) -> TrajectoryPoint:
        """Return a point of the arm's joints as one of all that ``standing`` names."""
        names = self.joint_names
        if tuple(standing) == names:
            return point
        positions = {**standing, **dict(zip(names, point.positions, strict=True))}
        columns = [
            dict(zip(names, values or (), strict=True))
            for values in (point.velocities, point.accelerations)
        ]
        velocities, accelerations = (
            [column.get(name, 0.0) for name in standing] for column in columns
        )
        return TrajectoryPoint(
            list(positions.values()), velocities, accelerations, point.time_from_start
        )

    def _tool(self, tip: str | None, tool: AnyPose | None) -> Array:
        """Return the tool's pose in the flange, shape (4, 4)."""
        T = np.eye(4) if tool is None else as_matrix(tool)
        if tip is None or tip == self.chain.tip:
            return T
        model = self._robot.description.model
        T_tip_tool: Array = fixed_transform(model, self.chain.tip, tip).matrix @ T
        return T_tip_tool

    def _in_base(
        self, pose: AnyPose, relative_to: str | None, position: Mapping[str, float]
    ) -> Array:
        """Return a pose in the link that carries the arm, shape (4, 4)."""
        model = self._robot.description.model
        found = link_poses(model, position)
        T = as_matrix(pose)
        if relative_to is not None:
            T = found[model.link(relative_to).name].matrix @ T
        T_base_tool: Array = found[self.chain.base].inverse().matrix @ T
        return T_base_tool
