"""The context of a program: the arm, the surroundings, and the named poses."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol, final

import numpy as np

from tool0.description.drive_limits import DriveLimits
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import FLANGE, Joint, ParallelGripper, RobotModel
from tool0.description.transform import Pose, to_transform
from tool0.description.transform_arrays import matrix_of
from tool0.errors import ControlError, did_you_mean
from tool0.kinematics.chain import ArmChain, Array, fixed_transform
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.moves import Move, pose_numbers
from tool0.motion.path import Path
from tool0.motion.planner import MovePlanner
from tool0.protocol.planning import PlanTarget
from tool0.protocol.program import (
    GripperStep,
    MoveJointStep,
    MoveLinearStep,
    MoveStep,
    Program,
    ToolPose,
    UntilStep,
)


class FindWay(Protocol):
    """Function that plans paths around obstacles."""

    def __call__(
        self, target: PlanTarget, start: Sequence[float], joints: Sequence[Joint]
    ) -> Path:
        """Return a collision-free motion of the arm from ``start`` [rad].

        ``joints`` are the arm's joints with the limits for this motion.

        Raises:
            CollisionError: If the start or the target is in collision.
            PlanningError: If no path is found.
            UnreachableError: If no posture reaches the target.
        """


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RobotContext:
    """One arm with its surroundings, as the context of a program."""

    program: Program
    model: RobotModel
    arm: str
    tip: str
    """Link at the end of the arm."""
    joints: tuple[Joint, ...]
    """Joints of the arm from base to flange, with the effective limits."""
    positions: Mapping[str, float]
    """Present position of every joint of the robot [rad | m]."""
    find_pose: Callable[[str], Mapping[str, float]]
    """Function that returns the positions of a named pose, or raises ControlError."""
    find_way: FindWay
    gripper: str | None
    """Name of the arm's gripper; None if the arm has no gripper."""
    geometry: ParallelGripper | None
    """Geometry of the arm's gripper."""
    objects: Collection[str]
    """Names of the objects in the scene."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def chain(self) -> ArmChain:
        return ArmChain(self.model, self.tip, self.joints)

    @cached_property
    def T_tip_tool(self) -> Array:
        """Pose of the program's tool in the flange frame, shape (4, 4)."""
        tool = self.program.tool
        T = _transform(tool)
        if tool.relative_to is None:
            return T
        T_tip_link = fixed_transform(self.model, self.tip, tool.relative_to).matrix
        return np.asarray(T_tip_link @ T)

    @cached_property
    def T_root_base(self) -> Array:
        """Pose of the link that carries the arm, in the root frame, shape (4, 4)."""
        found = link_poses(self.model, self.positions)
        return np.asarray(found[self.chain.base].matrix)

    @cached_property
    def planner(self) -> MovePlanner:
        """Planner for moves with poses in the root frame.

        Raises:
            ControlError: If the arm does not have the kinematics of a UR.
        """
        T_base_root = np.linalg.inv(self.T_root_base)
        tcp = pose_numbers(self.T_tip_tool)
        return MovePlanner(InverseKinematics(self.chain), tcp, np.asarray(T_base_root))

    def tool(self, q: Array) -> Array:
        """Return the tool's poses in the root frame at joint positions ``q`` [rad].

        ``q`` has shape (n, 6), and the result has shape (n, 4, 4).
        """
        T_base_tip = self.chain.forward(q).T_base_tip
        return np.asarray(self.T_root_base @ T_base_tip @ self.T_tip_tool)

    # ---- steps as moves -------------------------------------------------------------

    def move(self, step: MoveStep) -> Move:
        """Return the move of a step; a wrong step raises ControlError or ModelError."""
        given = [step.joints, step.pose, step.named_pose]
        if sum(item is not None for item in given) != 1:
            raise ControlError(
                "a move needs one target: 'joints', 'pose' or 'named_pose'"
            )
        q: tuple[float, ...] | None = None
        pose: tuple[float, ...] | None = None
        if step.joints is not None:
            q = self._joint_target(step.joints)
        elif step.named_pose is not None:
            q = self._named(step.named_pose)
        elif step.pose is not None:
            pose = self._pose(step.pose)
        is_linear = isinstance(step, MoveLinearStep)
        return Move(
            kind="linear" if is_linear else "joint",
            q=q,
            pose=pose,
            a=step.acceleration,
            v=step.speed,
            r=step.blend,
        )

    def way(self, step: MoveJointStep, start: Sequence[float]) -> Path:
        """Return the path around obstacles for a planned step; see ``FindWay``."""
        move = self.move(step)
        pose: Any = None  # matrices
        if move.pose is not None:
            pose = tuple(map(tuple, matrix_of(move.pose).tolist()))
        tool: Any = tuple(map(tuple, self.T_tip_tool.tolist()))
        target = PlanTarget(
            arm=self.arm,
            positions={}
            if move.q is None
            else dict(zip(self.joint_names, move.q, strict=True)),
            pose=pose,
            tool=tool,
        )
        joints = [
            replace(
                joint,
                limits=replace(
                    joint.limits,
                    velocity=min(step.speed, joint.limits.velocity),
                    acceleration=min(step.acceleration, joint.limits.acceleration),
                ),
            )
            for joint in self.joints
        ]
        return self.find_way(target, start, joints)

    def search(self, step: UntilStep, start: Array) -> Move:
        """Return the longest move until contact from ``start`` [rad]."""
        T = self.tool(start[None])[0]
        T[:3, 3] += step.distance * self.direction(step, T)
        a, v = step.acceleration, step.speed
        return Move(kind="linear", pose=pose_numbers(T), a=a, v=v)

    def direction(self, step: UntilStep, T_root_tool: Array) -> Array:
        """Return the unit direction of a move until contact, in the root's axes."""
        given = np.array(step.direction)
        length = float(np.linalg.norm(given))
        if not length > 0.0:
            raise ControlError("'direction' must not be zero")
        if step.frame == "tool":
            given = T_root_tool[:3, :3] @ given
        return np.asarray(given / length)

    def _joint_target(self, joints: Mapping[str, float]) -> tuple[float, ...]:
        prefix, names = self.tip.removesuffix(FLANGE), self.joint_names
        target = {
            name if name in names else prefix + name: q for name, q in joints.items()
        }
        for given, name in zip(joints, target, strict=False):
            if name not in names:
                raise ControlError(
                    f"'{given}' is no joint of the arm{did_you_mean(given, names)}"
                )
        missing = [name for name in names if name not in target]
        if missing:
            raise ControlError(f"'joints' lacks {', '.join(missing)}")
        return tuple(target[name] for name in names)

    def _named(self, name: str) -> tuple[float, ...]:
        positions = self.find_pose(name)
        missing = [joint for joint in self.joint_names if joint not in positions]
        if missing:
            raise ControlError(
                f"the pose '{name}' has no position of {', '.join(missing)}"
            )
        return tuple(positions[joint] for joint in self.joint_names)

    def _pose(self, pose: ToolPose) -> tuple[float, ...]:
        """Return a tool pose in the root frame, as position and rotation vector."""
        T = _transform(pose)
        if pose.relative_to is not None:
            link = self.model.link(pose.relative_to).name
            if link in self.model.links_from(self.joints[0].child):
                raise ControlError(
                    f"a target cannot be relative to '{link}', which the arm moves"
                )
            T = link_poses(self.model, self.positions)[link].matrix @ T
        return pose_numbers(T)

    # ---- the gripper ----------------------------------------------------------------

    def opening(self, step: GripperStep) -> float:
        """Return a step's gripper opening [m], or raise ControlError or ModelError."""
        geometry = self.geometry
        if geometry is None:
            raise ControlError("the arm carries no gripper")
        DriveLimits(gripper=geometry, speed=step.speed, force=step.force)
        if step.opening == "open":
            return geometry.max_opening
        if step.opening == "closed":
            return 0.0
        geometry.position(step.opening)
        return step.opening


def _transform(pose: ToolPose) -> Array:
    return np.asarray(to_transform(Pose(xyz=pose.xyz, rpy=pose.rpy)).matrix)
