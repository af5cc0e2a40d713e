"""Collision-free motions of a simulation: checks, planning, and storage of plans.

All computations use snapshots and run in the caller's thread, so they do not block the
tick.
"""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, Final, final

import numpy as np

from tool0.description.model import Joint, JointType
from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box
from tool0.description.surroundings import Plane, Surroundings
from tool0.description.transform import (
    Pose,
    to_transform,
)
from tool0.errors import (
    CollisionError,
    ConfigError,
    ControlError,
    ModelError,
    PlanningError,
)
from tool0.kernel.clearance import Cancelled
from tool0.kinematics.chain import ArmChain, Array
from tool0.motion.path import Path
from tool0.motion.waypoints import SmoothWay, time_way
from tool0.planning.planner import (
    FreeMotion,
    SearchOptions,
    check_way,
    plan_free_motion,
)
from tool0.planning.world import CollisionWorld, PlanningGroup, Rules, UprightTool
from tool0.protocol.planning import (
    Checked,
    CheckMotion,
    KeepOut,
    Plan,
    PlanMotion,
    PlanTarget,
)
from tool0.simulation.motion_targets import combined, goals_of, within
from tool0.simulation.simulation import Simulation

if TYPE_CHECKING:
    from tool0.protocol.state import Snapshot

logger = logging.getLogger(__name__)

PRESSING: Final = 0.002
"""Penetration depth up to which an unplanned motion is accepted [m].  The controller is
responsible for stopping the motion at the contact."""
MOST_PLANS: Final = 100
"""Largest number of plans that are stored; the oldest plans are discarded."""
MOVED: Final = 1e-3
"""Distance by which joints and objects may move between planning and execution [rad |
m]."""
_ROWS: Final = 200
"""Number of poses at which the clearance of a plan is measured."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class KeptPlan:
    """A stored plan, with data from its request."""

    plan: Plan
    may_touch: frozenset[str]
    start: Mapping[str, float]
    """Joint → commanded position at the time of planning [rad]."""
    objects: Mapping[str, ObjectState]
    carried: frozenset[str]
    """Names of the objects that grippers held at the time of planning."""
    arms: tuple[str, ...]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class _Moving:
    """The arms of a motion, and the positions of all joints."""

    chains: tuple[ArmChain, ...]
    """Kinematic chains of the arms, with the applicable limits."""
    positions: Mapping[str, float]
    """Positions of all joints [rad | m]; commanded positions are used where they are
    available."""

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Joints of all arms, from the base to the tip of each arm."""
        return tuple(joint for chain in self.chains for joint in chain.joints)

    @property
    def fastest(self) -> Array:
        """Largest velocities of the joints [rad/s]."""
        return np.array([joint.max_velocity for joint in self.joints])

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)

    @property
    def start(self) -> Array:
        return np.array([self.positions[name] for name in self.names])


@final
class MotionPlans:
    """Checks and plans motions of one simulation.

    Any thread may use ``MotionPlans``.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._lock = Lock()
        self._world: CollisionWorld | None = None
        self._searches: set[Cancelled] = set()
        self._plans: dict[int, KeptPlan] = {}
        self._count = itertools.count(1)
        self._unchecked = ""
        """Logged reason why motions are not checked."""

    def close(self) -> None:
        self.cancel()

    # ---- requests -------------------------------------------------------------------

    def plan(self, request: PlanMotion, positions: Mapping[str, float]) -> Plan:
        """Plan a motion from commanded ``positions`` [rad | m]; see ``PlanMotion``.

        Raises:
            CollisionError: If the start or the target is in collision.
            PlanningError: If no path is found.
            UnreachableError: If no posture reaches a target pose.
        """
        moving = self._moving(request.targets, positions, request.joint_ranges)
        snapshot = self._simulation.snapshot
        with self._found(request, moving, snapshot) as (found, group):
            plan = _described(next(self._count), found, group)
        self._plans[plan.number] = KeptPlan(
            plan=plan,
            may_touch=frozenset(request.may_touch),
            start={name: positions[name] for name in moving.names},
            objects={state.name: state for state in snapshot.objects},
            carried=self.carried(snapshot),
            arms=tuple(chain.tip for chain in moving.chains),
        )
        for number in list(self._plans)[:-MOST_PLANS]:
            del self._plans[number]
        return plan

    def way_around(
        self,
        target: PlanTarget,
        positions: Mapping[str, float],
        joints: Sequence[Joint],
    ) -> Path:
        """Return a collision-free motion of one arm, without storing a plan.

        Args:
            target: Target of the motion.
            positions: Commanded positions of all joints [rad | m].
            joints: Joints of the arm from the base to the flange, with the applicable
                limits.

        Raises:
            Tool0Error: If there is an error that ``plan`` describes.
        """
        chain = self._simulation.arm(target.arm)
        moving = _Moving(chains=(chain.with_joints(joints),), positions=positions)
        request = PlanMotion(targets=(target,), speed=1.0)
        with self._found(request, moving, self._simulation.snapshot) as (found, _):
            return found.path

    def cancel(self) -> None:
        """Cancel the searches that are in progress."""
        for search in tuple(self._searches):
            search.set()

    def arms_of(self, number: int) -> tuple[str, ...]:
        """Return the flanges of the arms that a plan moves.

        Raises:
            ControlError: If the plan is unknown.
        """
        kept = self._plans.get(number)
        if kept is None:
            raise ControlError(f"there is no plan {number}, or it is too old")
        return kept.arms

    def to_execute(self, number: int, positions: Mapping[str, float]) -> KeptPlan:
        """Return a stored plan that can be executed from commanded ``positions``.

        Raises:
            ControlError: If the plan is unknown, or the start or the scene has changed.
        """
        self.arms_of(number)
        kept = self._plans[number]
        for name, planned in kept.start.items():
            if not abs(off := positions[name] - planned) <= MOVED:
                raise ControlError(
                    f"plan {number} starts elsewhere: joint '{name}' has moved by "
                    f"{off:.4g} rad since; plan again"
                )
        now = {state.name: state for state in self._simulation.snapshot.objects}
        for name in kept.objects.keys() ^ now.keys():
            what = "removed" if name in kept.objects else "added"
            raise ControlError(
                f"the scene has changed since plan {number} was made: object '{name}' "
                f"was {what}; plan again"
            )
        carried = self.carried(self._simulation.snapshot)
        if carried != kept.carried:
            names = ", ".join(sorted(carried)) or "nothing"
            raise ControlError(
                f"since plan {number} was made, another object is held: {names}; plan "
                "again"
            )
        for name, state in now.items():
            before = kept.objects[name]
            moved = math.dist(state.position, before.position)
            turned = 2.0 * math.acos(min(1.0, abs(_dot(state, before))))
            if moved > MOVED or turned > 10.0 * MOVED:
                raise ControlError(
                    f"the scene has changed since plan {number} was made: object "
                    f"'{name}' has moved by {1e3 * moved:.1f} mm and turned by "
                    f"{math.degrees(turned):.1f} degrees; plan again"
                )
        return kept

    def check(
        self,
        request: CheckMotion,
        positions: Mapping[str, float],
        line: Path | None,
    ) -> Checked:
        """Return whether a motion is free of collisions.

        ``line`` is the path of the joints if the tool moves in a straight line; None
        for other motions.
        """
        moving = self._moving((request.target,), positions, {})
        path = line
        if path is None:
            (chain,) = moving.chains
            model = self._simulation.description.model
            goals = goals_of(model, chain, request.target, positions)
            # the posture that ``MoveTo`` chooses
            ways = np.linalg.norm((goals - moving.start) / moving.fastest, axis=1)
            path = _straight(moving, goals[ways.argmin()])
        rules = Rules(
            clearance=request.clearance, may_touch=frozenset(request.may_touch)
        )
        return self._checked(moving, path, rules, request.keep_out)

    def require_free(
        self, targets: Mapping[str, float], positions: Mapping[str, float]
    ) -> None:
        """Raise CollisionError for collisions on a straight path in joint space.

        Args:
            targets: Joint → position [rad | m]; joints that are not part of an arm are
                ignored.
            positions: Commanded positions of all joints.
        """
        chains = self._arms_with(targets)
        moving = _Moving(chains=chains, positions=positions)
        end = np.array([targets.get(name, positions[name]) for name in moving.names])
        if any(
            not joint.limits.lower <= q <= joint.limits.upper
            for joint, q in zip(moving.joints, end, strict=True)
            if joint.type is not JointType.CONTINUOUS
        ):
            return  # the controller rejects it with more details
        if chains and np.abs(end - moving.start).max() > 0.0:
            self.require_free_path(_straight(moving, end), positions)

    def require_free_path(self, path: Path, positions: Mapping[str, float]) -> None:
        """Raise CollisionError if arms would collide on a path of their joints.

        The path is not checked if MuJoCo cannot read the robot's shapes, or if there is
        no compiled kernel.  If the path is not checked, a warning is logged once.
        """
        try:
            found = self.check_path(path, positions)
        except (ModelError, PlanningError) as error:
            if self._unchecked != str(error):
                self._unchecked = str(error)
                logger.warning("motions are not checked for collisions: %s", error)
            return
        if not found.is_free:
            raise CollisionError(
                f"the motion would collide after {found.time:.2f} s, at "
                f"{found.part:.0%} of its way: {found.reason}; plan a way around, or "
                "move with collision='ignore'"
            )

    def check_path(self, path: Path, positions: Mapping[str, float]) -> Checked:
        """Return whether arms would collide on a path of their joints.

        Raises:
            ModelError: If MuJoCo does not support a shape.
            PlanningError: If there is no compiled kernel.
        """
        chains = self._arms_with(path.joint_names)
        moving = _Moving(chains=chains, positions=positions)
        return self._checked(moving, path, Rules(clearance=-PRESSING), ())

    # ---- helper functions -----------------------------------------------------------

    @contextmanager
    def _found(
        self, request: PlanMotion, moving: _Moving, snapshot: Snapshot
    ) -> Iterator[tuple[FreeMotion, PlanningGroup]]:
        """Plan a motion; the yielded checker is valid within the context."""
        model = self._simulation.description.model
        goals = combined(
            [
                goals_of(model, chain, target, moving.positions)
                for chain, target in zip(moving.chains, request.targets, strict=True)
            ],
            moving.start,
        )
        rules = Rules(
            clearance=request.clearance,
            may_touch=frozenset(request.may_touch),
            upright=self._upright(request, moving),
        )
        with self._searching() as cancelled:
            group = self._group(moving, snapshot, rules, request.keep_out)
            found = plan_free_motion(
                group,
                moving.joints,
                moving.start,
                goals,
                options=SearchOptions(
                    speed=request.speed, timeout=request.timeout, seed=request.seed
                ),
                cancelled=cancelled,
            )
            yield found, group

    def _checked(
        self,
        moving: _Moving,
        path: Path,
        rules: Rules,
        keep_out: Sequence[KeepOut],
    ) -> Checked:
        columns = [path.joint_names.index(name) for name in moving.names]
        poses = path.positions[:, columns]
        with self._lock:
            snapshot = self._simulation.snapshot
            group = self._group(moving, snapshot, rules, keep_out)
            found = check_way(group, poses)
        if found is None:
            return Checked(is_free=True)
        row, part, reason = found
        way = np.concatenate(
            [np.zeros(1), np.cumsum(np.abs(np.diff(poses, axis=0)).max(axis=1))]
        )
        here = way[row] + part * (way[row + 1] - way[row])
        return Checked(
            is_free=False,
            reason=reason,
            part=float(here / way[-1]) if way[-1] > 0.0 else 0.0,
            time=float(np.interp(here, way, path.times)),
        )

    def _arms_with(self, joints: Iterable[str]) -> tuple[ArmChain, ...]:
        """Return the arms that contain any of ``joints``."""
        names = set(joints)
        return tuple(
            chain
            for chain in self._simulation.arms.values()
            if not names.isdisjoint(chain.joint_names)
        )

    def _moving(
        self,
        targets: Sequence[PlanTarget],
        positions: Mapping[str, float],
        ranges: Mapping[str, tuple[float, float]],
    ) -> _Moving:
        chains = [self._simulation.arm(target.arm) for target in targets]
        if len({chain.tip for chain in chains}) < len(chains):
            raise ControlError("two targets are for one arm")
        names = {name for chain in chains for name in chain.joint_names}
        for name in ranges.keys() - names:
            raise ControlError(
                f"joint_ranges: '{name}' is not a joint that moves: "
                f"{', '.join(sorted(names))}"
            )
        limited = (
            chain.with_joints(
                [within(joint, ranges.get(joint.name)) for joint in chain.joints]
            )
            for chain in chains
        )
        return _Moving(chains=tuple(limited), positions=positions)

    def carried(self, snapshot: Snapshot) -> frozenset[str]:
        """Return the names of the objects that grippers hold."""
        held = self._simulation.collisions.held(snapshot)
        return frozenset(load.item.name for load in held)

    def _upright(self, request: PlanMotion, moving: _Moving) -> UprightTool | None:
        wanted = request.upright
        if wanted is None:
            return None
        if not math.hypot(*wanted.axis) > 0.0:
            raise ControlError("upright: the axis must not be zero")
        link = moving.chains[0].tip if wanted.tip is None else wanted.tip
        name = self._simulation.description.model.link(link).name
        return UprightTool(name, wanted.axis, wanted.tilt)

    def _group(
        self,
        moving: _Moving,
        snapshot: Snapshot,
        rules: Rules,
        keep_out: Sequence[KeepOut],
    ) -> PlanningGroup:
        """Return the collision checker of motions.

        The caller must hold the lock.
        """
        simulation = self._simulation
        model = simulation.description.model
        if self._world is None:
            usual = model.joint_by_name.keys() & simulation.poses.start().keys()
            start = simulation.poses.start()
            self._world = CollisionWorld(
                model,
                simulation.ground,
                {name: start[name] for name in usual},
                simulation.description.disabled_collisions,
            )
        held = simulation.collisions.held(snapshot)
        carried = {load.item.name for load in held}
        around = [
            (item, state)
            for item, state in zip(snapshot.scene, snapshot.objects, strict=True)
            if item.name not in carried
        ]
        boxes, planes = _bounds(keep_out)
        return self._world.group(
            moving.names,
            Surroundings(
                positions={**snapshot.positions, **moving.positions},
                objects=(*around, *boxes),
                held=held,
                planes=planes,
            ),
            rules,
        )

    @contextmanager
    def _searching(self) -> Iterator[Cancelled]:
        """Hold the lock for a search.

        The search can be canceled, even while it waits for the lock.
        """
        cancelled = Cancelled()
        self._searches.add(cancelled)
        try:
            with self._lock:
                yield cancelled
        finally:
            self._searches.discard(cancelled)


def _bounds(
    keep_out: Sequence[KeepOut],
) -> tuple[list[tuple[SceneObject, ObjectState]], tuple[Plane, ...]]:
    boxes, planes = [], []
    for number, item in enumerate(keep_out, 1):
        name = f"{item.name}#{number}" if len(keep_out) > 1 else item.name
        if (item.size is None) == (item.normal is None):
            raise ConfigError(f"'{item.name}' needs either a size or a normal")
        if item.size is not None:
            box = SceneObject(
                name=name,
                geometry=Box(size=item.size),
                pose=Pose(xyz=item.xyz, rpy=item.rpy),
                mass=None,
            )
            T = to_transform(box.pose)
            boxes.append((box, ObjectState(name, T.position, T.quat_wxyz)))
        elif item.normal is not None:
            if not math.hypot(*item.normal) > 0.0:
                raise ConfigError(f"'{item.name}': the normal must not be zero")
            planes.append(Plane(name, item.xyz, item.normal))
    return boxes, tuple(planes)


def _straight(moving: _Moving, end: Array) -> Path:
    """Return a straight motion in joint space, at half of the largest speed."""
    way = SmoothWay(np.array([moving.start, end]), [])
    return time_way(moving.joints, way, speed=0.5)


def _described(number: int, found: FreeMotion, group: PlanningGroup) -> Plan:
    path = found.path
    times = np.linspace(0.0, path.duration, _ROWS)
    clearance, nearest = group.clearance(path.at(times).positions)
    accelerations = path.accelerations
    assert accelerations is not None
    return Plan(
        number=number,
        joint_names=path.joint_names,
        times=tuple(path.times.tolist()),
        positions=_rows(path.positions),
        velocities=_rows(path.velocities),
        accelerations=_rows(accelerations),
        waypoints=_rows(found.waypoints),
        clearance=clearance,
        nearest=nearest,
        is_direct=found.is_direct,
        samples=found.samples,
        poses=found.poses,
        planning_time=found.planning_time,
    )


def _rows(values: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, values.tolist()))


def _dot(one: ObjectState, other: ObjectState) -> float:
    return sum(a * b for a, b in zip(one.quat_wxyz, other.quat_wxyz, strict=True))
