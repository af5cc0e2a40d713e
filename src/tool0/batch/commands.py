"""Starts motions of the copies, all together in the kernel or one by one in Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from tool0.batch.arguments import Arguments, Indices, chosen
from tool0.batch.backend import BatchBackend
from tool0.control.position_limits import check_position, position_range
from tool0.control.ros1.goal_check import check_names
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.drive_limits import DriveLimits
from tool0.description.model import Joint, ParallelGripper, RobotModel
from tool0.errors import ControlError
from tool0.kernel.memory import IntArray
from tool0.kernel.motions import JointGoal
from tool0.kinematics.chain import Array
from tool0.motion.gripper import direct_path
from tool0.protocol.controllers import Role, why_not_driven
from tool0.protocol.trajectories import TrajectoryPoint
from tool0.simulation.core import Core
from tool0.simulation.executor import Executor
from tool0.simulation.paths import trajectory_points


class ControllerJoints(NamedTuple):
    """The commanded joints of one running trajectory controller."""

    controller: str
    joints: tuple[str, ...]
    columns: list[int]
    """Columns of these joints in an array of all commanded joints."""
    number: int
    """The controller's number among the running controllers."""
    numbers: IntArray
    """Numbers of the joints in the controller."""
    lifts_limits: bool
    """Whether the drives of the joints may be limited by a gripper's goal."""

    def chosen(self, values: Array) -> Array:
        """Return the columns of ``values`` for these joints, shape (…, k)."""
        n = values.shape[-1]
        return values if self.columns == list(range(n)) else values[..., self.columns]


@final
class Commands:
    """Checks and starts motions; ``rows`` are the numbers of the chosen copies."""

    def __init__(self, model: RobotModel, copies: BatchBackend, first: Core) -> None:
        """Command ``copies``, which all have the controllers of the core ``first``."""
        self._model = model
        self._copies = copies
        self._first = Executor(first)
        self._manager = first.manager
        self._limits = first.hardware.limits
        self._period = first.control_period
        self._parts: dict[tuple[str, ...], list[ControllerJoints]] = {}
        self._position_ranges: dict[tuple[str, ...], Array] = {}
        """Cache of the position ranges; the keys are the joints of commands."""
        self._drive_limits: dict[tuple[str, float, float], DriveLimits] = {}
        """Drive limits of grips, cached by gripper, speed and force."""
        self._gripper_controllers: dict[str, tuple[str, Role]] = {}

    @cached_property
    def arm_joints(self) -> tuple[str, ...]:
        """The joints of all running trajectory controllers without a gripper."""
        return tuple(
            joint
            for joints in self._trajectory_controllers.values()
            if self._driven_by_grippers.isdisjoint(joints)
            for joint in joints
        )

    def parts(
        self, joints: Sequence[str] | None
    ) -> tuple[tuple[str, ...], list[ControllerJoints]]:
        """Return the names of all joints to move, and these joints by controller."""
        names = self.arm_joints if joints is None else tuple(joints)
        if names not in self._parts:
            self._parts[names] = self._found_parts(names)
        return names, self._parts[names]

    def _found_parts(self, names: tuple[str, ...]) -> list[ControllerJoints]:
        owners = {
            joint: name
            for name, its in self._trajectory_controllers.items()
            for joint in its
        }
        if not names:
            raise ControlError(
                "no running trajectory controller drives an arm's joints"
            )
        for joint in names:
            if joint not in owners:
                raise ControlError(why_not_driven(self._manager.list(), [joint]))
            if names.count(joint) > 1:
                raise ControlError(f"joint '{joint}' is named twice")
        parts = []
        for name in dict.fromkeys(owners[joint] for joint in names):
            columns = [k for k, joint in enumerate(names) if owners[joint] == name]
            joints = tuple(names[k] for k in columns)
            number, its = self._running[name]
            part = ControllerJoints(
                name,
                joints,
                columns,
                number,
                np.array([its.index(joint) for joint in joints], np.int32),
                not self._driven_by_grippers.isdisjoint(joints),
            )
            spec = self._first.trajectory_controller(name).spec
            check_names(
                TrajectoryGoal(points=(), joint_names=part.joints),
                spec.joints,
                allow_partial=spec.allow_partial_joints_goal,
            )
            parts.append(part)
        return parts

    def check_positions(
        self, names: Sequence[str], positions: Array, rows: Indices
    ) -> None:
        """Raise GoalRejectedError for positions (n, m, k) beyond the joints' limits."""
        low, high = self._ranges(tuple(names))
        given = chosen(positions, rows)
        is_beyond = (given < low) | (given > high)
        if np.count_nonzero(is_beyond):
            i, m, k = np.argwhere(is_beyond)[0].tolist()
            where = f"point {m} of copy {rows[i]}"
            joint = self._limited(names)[k]
            check_position(joint, float(given[i, m, k]), where)

    def _ranges(self, names: tuple[str, ...]) -> Array:
        """Return joints' lower and upper position limits [rad | m], shape (2, k)."""
        if names not in self._position_ranges:
            ranges = [position_range(joint) for joint in self._limited(names)]
            self._position_ranges[names] = np.array(ranges).T
        return self._position_ranges[names]

    def start(
        self,
        rows: Indices,
        parts: list[ControllerJoints],
        positions: Array,
        velocities: Array | None,
        times: Sequence[float],
    ) -> None:
        """Start trajectories through points (n, m, k)."""
        if not rows.size:
            return
        for part in parts:
            q = part.chosen(positions)
            qd = None if velocities is None else part.chosen(velocities)
            if self._start_native(rows, part, q, qd, times):
                continue
            for i in rows.tolist():
                points = [
                    TrajectoryPoint(
                        q[i, m].tolist(),
                        None if qd is None else qd[i, m].tolist(),
                        time_from_start=time,
                    )
                    for m, time in enumerate(times)
                ]
                goal = TrajectoryGoal(points=points, joint_names=part.joints)
                self._copies.executor(i).command_trajectory(part.controller, goal)

    def start_on_device(
        self,
        rows: Indices,
        parts: list[ControllerJoints],
        positions: object,
        velocities: object | None,
        duration: float,
    ) -> None:
        """Start motions to positions in the device's memory, shape (n, k)."""
        goals = {}
        for part in parts:
            limited = self._limited(part.joints)
            goals[part.number] = [
                JointGoal(column, number, *position_range(joint))
                for column, number, joint in zip(
                    part.columns, part.numbers.tolist(), limited, strict=True
                )
            ]
        self._copies.command(rows, goals, positions, velocities, duration)

    def checked_grip(
        self,
        gripper: ParallelGripper,
        rows: Indices,
        opening: ArrayLike,
        *,
        speed: ArrayLike | None,
        force: ArrayLike | None,
        check: Arguments,
    ) -> tuple[object, Sequence[float], Sequence[float]]:
        """Return the openings, speeds and forces for ``grip``.

        The arguments ``opening``, ``speed`` and ``force`` are as in
        ``Batch.move_gripper``.

        Raises:
            ModelError: If an opening is outside the gripper's range.
            ControlError: If a shape is wrong, or a number is not finite.
        """
        openings: object = opening
        if self._copies.holds(opening):
            check.on_device("opening", opening, (), "", is_held=True)
        else:
            openings = values = check.rows("opening", opening, (), rows)
            for end in values[rows].tolist():
                if not 0.0 <= end <= gripper.max_opening:
                    gripper.position(end)  # raises ModelError
        speeds, forces = (
            [most] * len(rows)
            if given is None
            else check.rows(name, given, (), rows)[rows].tolist()
            for name, given, most in (
                ("speed", speed, gripper.speed[1]),
                ("force", force, gripper.force[1]),
            )
        )
        return openings, speeds, forces

    def grip(
        self,
        gripper: ParallelGripper,
        rows: Indices,
        openings: object,
        speeds: Sequence[float],
        forces: Sequence[float],
        *,
        has_force: bool,
    ) -> None:
        """Move the pads, with a separate speed [m/s] and force [N] for each row.

        ``openings`` [m] has shape (n,) and may be in the device's memory.  If
        ``has_force`` is False, a GripperActionController applies its default effort.
        """
        old, bounds = self._drive_limits, []
        self._drive_limits = {}
        for speed, force in zip(speeds, forces, strict=True):
            key = gripper.name, speed, force
            limits = old.get(key) or DriveLimits(
                gripper=gripper, speed=speed, force=force
            )
            old[key] = self._drive_limits[key] = limits
            bounds.append(limits)
        name, role = self._gripper_controller(gripper)
        if not rows.size:
            return
        joint = gripper.joint
        number, joints = self._running[name]
        is_followed = role is Role.TRAJECTORY
        if is_followed and self._copies.grip(
            rows, number, joints.index(joint), openings, bounds
        ):
            return
        effort = self._limits[joint].effort if has_force else None
        ends = chosen(np.asarray(openings), rows).tolist()
        if not is_followed:
            self._drive(rows, name, list(map(gripper.position, ends)), effort, bounds)
            return
        for i, end, speed, bound in zip(
            rows.tolist(), ends, speeds, bounds, strict=True
        ):
            executor = self._copies.executor(i)
            controller = executor.trajectory_controller(name)
            column = controller.spec.joints.index(joint)
            here = controller.query_state(executor.core.time).positions[column]
            path = direct_path(gripper, here, end, speed, self._period)
            goal = TrajectoryGoal(points=trajectory_points(path), joint_names=[joint])
            executor.command_trajectory(name, goal, {joint: bound})

    def _drive(
        self,
        rows: Indices,
        name: str,
        targets: Sequence[float],
        effort: float | None,
        bounds: Sequence[DriveLimits],
    ) -> None:
        """Start goals of a GripperActionController, one per row."""
        number, (joint,) = self._running[name]
        (limited,) = self._limited([joint])
        for target in targets:
            check_position(limited, target, f"a goal of '{name}'")
        if self._copies.drive(rows, number, targets, effort, bounds):
            return
        for i, target, bound in zip(rows.tolist(), targets, bounds, strict=True):
            executor = self._copies.executor(i)
            executor.command_gripper(name, target, effort, bound)

    def _limited(self, names: Sequence[str]) -> list[Joint]:
        """Return the joints, with their limits replaced by the limits of the drives."""
        limits = self._limits
        return [
            replace(joint, limits=limits.get(joint.name, joint.limits))
            for joint in map(self._model.joint, names)
        ]

    def _start_native(
        self,
        rows: Indices,
        part: ControllerJoints,
        positions: Array,
        velocities: Array | None,
        times: Sequence[float],
    ) -> bool:
        """Start motions in the backend; return False if only Python can start them."""
        return self._copies.start(
            rows,
            part.number,
            part.numbers,
            times=np.array([times] * len(rows)),
            positions=chosen(positions, rows),
            velocities=None if velocities is None else chosen(velocities, rows),
            lifts_limits=part.lifts_limits,
        )

    @cached_property
    def _driven_by_grippers(self) -> frozenset[str]:
        return frozenset(gripper.joint for gripper in self._model.grippers)

    @cached_property
    def _trajectory_controllers(self) -> dict[str, tuple[str, ...]]:
        """The joints of each running trajectory controller."""
        return {
            status.name: self._manager.spec(status.name).joints
            for status in self._manager.list()
            if status.is_running and status.role is Role.TRAJECTORY
        }

    @cached_property
    def _running(self) -> dict[str, tuple[int, tuple[str, ...]]]:
        """The number and joints of each running controller, in load order."""
        names = [s.name for s in self._manager.list() if s.is_running]
        return {
            name: (number, self._manager.spec(name).joints)
            for number, name in enumerate(names)
        }

    def _gripper_controller(self, gripper: ParallelGripper) -> tuple[str, Role]:
        """Return the name and role of the running controller that drives a gripper."""
        if gripper.name not in self._gripper_controllers:
            self._gripper_controllers[gripper.name] = self._found_controller(gripper)
        return self._gripper_controllers[gripper.name]

    def _found_controller(self, gripper: ParallelGripper) -> tuple[str, Role]:
        statuses = self._manager.list()
        roles = (Role.TRAJECTORY, Role.GRIPPER)
        for status in statuses:
            is_owner = status.is_running and gripper.joint in status.joints
            if is_owner and status.role in roles:
                return status.name, status.role
        raise ControlError(why_not_driven(statuses, [gripper.joint], roles))
