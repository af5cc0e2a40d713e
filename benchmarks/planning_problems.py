"""Planning problems of a UR5 with a 2F-85, similar to the sets of MotionBenchMaker.

Each problem has a scene, a start posture and a target.  The target is a pose of the
point between the pads (Chamzas et al., "MotionBenchMaker", RA-L 2022).  The problems
are generated here and not copied.  A seed always gives the same problems.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box, Cylinder
from tool0.description.surroundings import Surroundings
from tool0.description.transform import Pose, to_transform
from tool0.kinematics.chain import Array, find_chains
from tool0.kinematics.inverse import InverseKinematics
from tool0.planning.planner import windings
from tool0.planning.world import CollisionWorld, PlanningGroup, Rules

ARM, GRIPPER = "ur5", "2f85"
GROUND = -0.6
"""Height of the ground [m].  The legs and shelves of the table do not reach the
ground."""
REACH = 0.14
"""Distance from the flange to the point between the pads [m]."""
HOME = (-1.57, -1.57, 1.57, -1.57, -1.57, 0.0)
MARGIN: Final = 0.006
"""Distance that start and target keep from obstacles [m].  The distance is slightly
larger than the clearance."""
_TRIES = 4000
Rng = np.random.Generator
Boxes = list[SceneObject]


@dataclass(frozen=True)
class Problem:
    """A start and a target among obstacles."""

    name: str
    objects: tuple[SceneObject, ...]
    start: Array
    """Joint positions at the start [rad], shape (6,)."""
    T_root_flange: Array
    """Target pose of the flange in the root, shape (4, 4)."""

    @property
    def scene(self) -> Scene:
        """The obstacles as a scene."""
        return Scene(self.objects)


class Workcell:
    """The robot, with its kinematics and its collision checks."""

    def __init__(self) -> None:
        self.model = assemble(ARM, gripper=GRIPPER).model
        (self.chain,) = find_chains(self.model).values()
        self.rest = {joint.name: 0.0 for joint in self.model.movable_joints}
        root = link_poses(self.model, self.rest)[self.chain.base]
        self._T_base_root = root.inverse().matrix

    @cached_property
    def kinematics(self) -> InverseKinematics:
        """The inverse kinematics of the arm."""
        return InverseKinematics(self.chain)

    def world(self) -> CollisionWorld:
        """Return a collision world in which no scene has been compiled."""
        usual = self.rest | dict(zip(self.chain.joint_names, HOME, strict=True))
        return CollisionWorld(self.model, GROUND, usual)

    def group(
        self, world: CollisionWorld, objects: tuple[SceneObject, ...], rules: Rules
    ) -> PlanningGroup:
        """Return the planning group of the arm among objects."""
        return world.group(
            self.chain.joint_names,
            Surroundings(
                positions=self.rest,
                objects=tuple((item, state_of(item)) for item in objects),
            ),
            rules,
        )

    def goals(self, T_root_flange: Array, start: Array) -> Array:
        """Return all postures of a target, with whole turns [rad], shape (n, 6)."""
        T_base_flange = self._T_base_root @ T_root_flange
        found = [
            windings(q, self.chain.joints, start)
            for q in self.kinematics.postures(T_base_flange, start)
        ]
        return np.concatenate([np.empty((0, 6)), *found])

    def retreats(
        self, q: Array, T_root_flange: Array, length: float, group: PlanningGroup
    ) -> bool:
        """Return whether the flange can retreat along its z axis from ``q``."""
        T, n = self._T_base_root @ T_root_flange, math.ceil(length / 0.02)
        for _ in range(n):
            T = T @ _at((0.0, 0.0, -0.02))
            postures = self.kinematics.postures(T, q)
            if not len(postures):
                return False
            after = postures[np.abs(postures - q).max(axis=1).argmin()]
            if np.abs(after - q).max() > 0.5:
                return False
            if group.clearances.along(np.array([q, after])) is not None:
                return False
            q = after
        return True


def state_of(item: SceneObject) -> ObjectState:
    """Return the state of an object at its start."""
    T = to_transform(item.pose)
    return ObjectState(item.name, T.position, T.quat_wxyz)


# ---- scenes: obstacles, and grasps as poses of the point between the pads ------------


@dataclass(frozen=True)
class Site:
    """A scene, and samplers of grasps in the scene."""

    objects: Boxes
    inside: Callable[[Rng], Array]
    """Function that returns a pose that is hard to reach: T_root_grasp, shape (4,
    4)."""
    outside: Callable[[Rng], Array] | None = None
    """Function that returns another start pose; None if the arm starts at home."""
    retreat: float = 0.0
    """Distance by which the grasp can be retracted in a straight line with the same
    posture [m].  The retraction guarantees that there is a way out."""


def bookshelf(rng: Rng) -> Site:
    """Return a shelf with nine compartments and objects.

    The grasps are inside the compartments.
    """
    depth, width, height = 0.28, rng.uniform(0.9, 1.1), rng.uniform(0.26, 0.32)
    front = rng.uniform(0.48, 0.58)
    turn, low = rng.uniform(-0.4, 0.4), rng.uniform(-0.2, -0.1)
    cells = width / 3.0
    boxes: Boxes = []
    T = _turned(turn)
    for k in range(4):
        size = (depth, width, 0.02)
        at = (front + depth / 2, 0.0, low + k * height)
        boxes.append(_box(f"board{k}", size, at, T))
    for k in range(4):
        size = (depth, 0.02, 3 * height)
        at = (front + depth / 2, -width / 2 + k * cells, low + 1.5 * height)
        boxes.append(_box(f"side{k}", size, at, T))
    boxes.append(
        _box(
            "back",
            (0.02, width, 3 * height),
            (front + depth, 0, low + 1.5 * height),
            T,
        )
    )
    places = []
    for row in range(3):
        for column in range(3):
            y = -width / 2 + (column + 0.5) * cells + rng.uniform(-0.03, 0.03)
            x = front + rng.uniform(0.10, 0.16)
            floor = low + row * height + 0.01
            tall = rng.uniform(0.16, 0.2)
            name = f"can{row}{column}"
            boxes.append(_can(name, 0.02, tall, (x, y, floor + tall / 2 + 0.001), T))
            places.append((x, y, floor + 0.6 * tall + 0.001))

    def inside(rng: Rng) -> Array:
        place = places[rng.integers(len(places))]
        return T @ _forward(place, rng.uniform(-0.3, 0.3))

    return Site(boxes, inside, inside)


def cage(rng: Rng) -> Site:
    """Return a cage of bars around a small block.

    The grasps are between the bars.
    """
    edge, bar = rng.uniform(0.38, 0.44), 0.02
    gap = rng.uniform(0.19, 0.22)
    x, y, z = rng.uniform(0.6, 0.68), rng.uniform(-0.2, 0.2), rng.uniform(0.15, 0.4)
    T = _turned(rng.uniform(-0.4, 0.4)) @ _at((x, y, z))
    boxes: Boxes = [_box("stone", (0.04, 0.04, 0.08), (0, 0, 0), T)]
    h = edge / 2
    for k, (i, m) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
        boxes += [
            _box(f"x{k}", (edge + bar, bar, bar), (0, i * h, m * h), T),
            _box(f"y{k}", (bar, edge + bar, bar), (i * h, 0, m * h), T),
            _box(f"z{k}", (bar, bar, edge + bar), (i * h, m * h, 0), T),
        ]
    for k, off in enumerate((-gap / 2, gap / 2)):
        boxes += [
            _box(f"front{k}", (bar, bar, edge), (-h, off, 0), T),
            _box(f"left{k}", (bar, bar, edge), (off, h, 0), T),
            _box(f"right{k}", (bar, bar, edge), (off, -h, 0), T),
            _box(f"top{k}", (edge, bar, bar), (0, off, h), T),
        ]

    def inside(rng: Rng) -> Array:
        side = rng.integers(4)
        if side == 3:  # from above, between the bars
            return T @ _downward((0, 0, 0.0), math.pi / 2 * rng.integers(2))
        yaw = (0.0, math.pi / 2, -math.pi / 2)[side]
        return T @ _turned(yaw) @ _forward((0.0, 0.0, 0.0), rng.uniform(-0.2, 0.2))

    return Site(boxes, inside, retreat=0.3)


def box(rng: Rng) -> Site:
    """Return a deep open box with an object in it.

    The grasps are inside the box, from above.
    """
    length, width = rng.uniform(0.4, 0.5), rng.uniform(0.3, 0.4)
    depth, wall = rng.uniform(0.22, 0.3), 0.015
    x, y = rng.uniform(0.45, 0.6), rng.uniform(-0.3, 0.3)
    tilt = rng.uniform(-0.25, 0.25)
    T = _at((x, y, rng.uniform(-0.15, 0.05))) @ _turned(rng.uniform(-1.5, 1.5))
    T = T @ _turned(tilt, axis="y")
    boxes: Boxes = [_box("floor", (length, width, wall), (0, 0, 0), T)]
    for k, sign in enumerate((-1, 1)):
        boxes += [
            _box(
                f"end{k}",
                (wall, width, depth),
                (sign * (length - wall) / 2, 0, depth / 2),
                T,
            ),
            _box(
                f"side{k}",
                (length, wall, depth),
                (0, sign * (width - wall) / 2, depth / 2),
                T,
            ),
        ]
    px, py = rng.uniform(-0.12, 0.12), rng.uniform(-0.06, 0.06)
    boxes.append(_box("thing", (0.04, 0.04, 0.08), (px, py, wall / 2 + 0.041), T))

    def inside(rng: Rng) -> Array:
        turn = math.pi / 2 * rng.integers(4)
        return T @ _downward((px, py, wall / 2 + 0.06), turn)

    def outside(rng: Rng) -> Array:
        side = 1 if rng.random() < 0.5 else -1
        place = (rng.uniform(0.3, 0.6), side * rng.uniform(0.35, 0.6), 0.1)
        return _downward(place, rng.uniform(-3.1, 3.1))

    return Site(boxes, inside, outside)


def table_pick(rng: Rng) -> Site:
    """Return a table with many objects.

    The grasps are between the objects, from above.
    """
    top = rng.uniform(-0.12, 0.0)
    x = 0.15 + 0.4 + rng.uniform(0.0, 0.05)
    still = np.eye(4)
    boxes: Boxes = [_box("table", (0.8, 1.2, 0.04), (x, 0.0, top - 0.02), still)]
    places: list[tuple[float, float, float]] = []
    while len(places) < 10:
        px, py = rng.uniform(x - 0.28, x + 0.25), rng.uniform(-0.5, 0.5)
        if any(math.hypot(px - qx, py - qy) < 0.17 for qx, qy, _ in places):
            continue
        k, tall = len(places), rng.uniform(0.1, 0.28)
        at = (px, py, top + tall / 2 + 0.001)
        if k % 2:
            boxes.append(_can(f"can{k}", rng.uniform(0.02, 0.03), tall, at, still))
        else:
            turn = _turned(rng.uniform(-1.5, 1.5))
            T = _at(at) @ turn
            boxes.append(_box(f"block{k}", (0.05, 0.05, tall), (0, 0, 0), T))
        places.append((px, py, tall))

    def inside(rng: Rng) -> Array:
        px, py, tall = places[1 + 2 * rng.integers(len(places) // 2)]
        height = top + rng.uniform(0.5, 0.8) * tall
        if rng.random() < 0.5:
            return _downward((px, py, height), rng.uniform(-math.pi, math.pi))
        yaw = math.atan2(py, px) + rng.uniform(-0.4, 0.4)
        return _at((px, py, height)) @ _turned(yaw) @ _forward((0, 0, 0), 0.2)

    return Site(boxes, inside, inside)


def table_under(rng: Rng) -> Site:
    """Return a table at the height of the arm.

    The grasps are below the table, and the arm starts above it.
    """
    top = rng.uniform(0.12, 0.22)
    near = rng.uniform(0.32, 0.38)
    still = np.eye(4)
    boxes: Boxes = [_box("table", (0.7, 1.1, 0.03), (near + 0.35, 0, top), still)]
    for k, (i, m) in enumerate(((0, -1), (0, 1), (1, -1), (1, 1))):
        at = (near + 0.04 + i * 0.62, m * 0.5, top / 2 - 0.31)
        boxes.append(_box(f"leg{k}", (0.05, 0.05, top + 0.57), at, still))
    px, py = near + rng.uniform(0.12, 0.25), rng.uniform(-0.25, 0.25)
    pz = top - rng.uniform(0.2, 0.3)
    boxes.append(_can("can", 0.025, 0.12, (px, py, pz), still))
    above = near + 0.25, rng.uniform(-0.3, 0.3)
    at = (*above, top + 0.015 + 0.061)
    boxes.append(_can("cup", 0.025, 0.12, at, still))

    def inside(rng: Rng) -> Array:
        yaw = math.atan2(py, px) + rng.uniform(-0.3, 0.3)
        return _at((px, py, pz)) @ _turned(yaw) @ _forward((0, 0, 0), 0.0)

    def outside(rng: Rng) -> Array:
        return _downward((*above, at[2] + 0.02), rng.uniform(-math.pi, math.pi))

    return Site(boxes, inside, outside)


SETS: dict[str, Callable[[Rng], Site]] = {
    "bookshelf": bookshelf,
    "cage": cage,
    "box": box,
    "table pick": table_pick,
    "table under pick": table_under,
}


def problems(name: str, n: int, seed: int = 0) -> Iterator[Problem]:
    """Yield ``n`` problems of a set whose start and target are free.

    The straight motion to the nearest posture is not free.  Half of the problems start
    at home, if home is free.  All other problems start at another grasp.
    """
    cell = Workcell()
    rng = np.random.default_rng([seed, list(SETS).index(name)])
    rules = Rules(clearance=MARGIN)
    count = 0
    for _ in range(_TRIES):
        site = SETS[name](rng)
        objects = tuple(site.objects)
        group = cell.group(cell.world(), objects, rules)

        def free(
            sample: Callable[[Rng], Array],
            site: Site = site,
            group: PlanningGroup = group,
        ) -> tuple[Array, Array] | None:
            for _ in range(20):
                T = sample(rng) @ _at((0.0, 0.0, -REACH))
                postures = cell.goals(T, np.array(HOME))
                for q in rng.permutation(postures):
                    if not group.why_not(q) and cell.retreats(
                        q, T, site.retreat, group
                    ):
                        return T, q
            return None

        start: Array | None = None
        if site.outside is not None and rng.random() < 0.5:
            begun = free(site.outside)
            start = None if begun is None else begun[1]
        elif not group.why_not(np.array(HOME)):
            start = np.array(HOME)
        found = free(site.inside)
        if start is None or found is None:
            continue
        goals = cell.goals(found[0], start)
        nearest = goals[np.abs(goals - start).max(axis=1).argsort()]
        straight = [q for q in nearest if not group.why_not(q)][:2]
        if any(group.clearances.along(np.array([start, q])) is None for q in straight):
            continue
        yield Problem(f"{name} {count}", objects, start, found[0])
        count += 1
        if count == n:
            return
    raise RuntimeError(f"{name}: {count} problems found, not {n}")


# ---- parts -----------------------------------------------------------------------


def _at(place: tuple[float, float, float]) -> Array:
    T = np.eye(4)
    T[:3, 3] = place
    return T


def _turned(angle: float, axis: str = "z") -> Array:
    rpy = tuple(angle if name == axis else 0.0 for name in "xyz")
    return np.array(to_transform(Pose(rpy=rpy)).matrix)  # type: ignore[arg-type]


def _forward(place: tuple[float, float, float], pitch: float) -> Array:
    """Return a grasp along x that is tilted down by ``pitch`` [rad].

    The fingers move along y.
    """
    T = _at(place)
    T[:3, :3] = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]])
    return T @ _turned(-pitch, axis="y")


def _downward(place: tuple[float, float, float], turn: float) -> Array:
    """Return a grasp from above, turned by ``turn`` [rad] about the vertical."""
    T = _at(place)
    T[:3, :3] = np.diag([1.0, -1.0, -1.0])
    return T @ _turned(turn)


def _box(
    name: str,
    size: tuple[float, float, float],
    at: tuple[float, float, float],
    T: Array,
) -> SceneObject:
    return _solid(name, Box(size=size), T @ _at(at))


def _can(
    name: str, radius: float, length: float, at: tuple[float, float, float], T: Array
) -> SceneObject:
    return _solid(name, Cylinder(radius=radius, length=length), T @ _at(at))


def _solid(name: str, shape: Box | Cylinder, T: Array) -> SceneObject:
    pitch = math.asin(max(-1.0, min(1.0, -T[2, 0])))
    rpy = (math.atan2(T[2, 1], T[2, 2]), pitch, math.atan2(T[1, 0], T[0, 0]))
    return SceneObject(
        name=name, geometry=shape, pose=Pose(xyz=tuple(T[:3, 3]), rpy=rpy)
    )
