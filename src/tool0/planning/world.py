"""The obstacles of a motion, and the clearances that the motion maintains.

With every engine, the distances are computed between MuJoCo's shapes in a separate
model.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple, final

import numpy as np

from tool0.description.model import RobotModel
from tool0.description.surroundings import Surroundings
from tool0.errors import CollisionError, PlanningError
from tool0.kernel import library
from tool0.kernel.clearance import FREE, TILTED, Clearances, Joints, Pairs, Upright
from tool0.kinematics.chain import Array

if TYPE_CHECKING:
    from tool0.engines.mujoco.distances import DistanceModel, Shape

CLEARANCE: Final = 0.005
"""Default clearance of motions [m]."""
OWN_CLEARANCE: Final = 0.005
"""Maximum clearance between links of the same robot [m]. The base and the upper arm of
a UR5 are never more than 8.2 mm apart."""
SLACK: Final = 0.0005
"""Distance that the search keeps in addition to the clearance [m]. Between two checks
along a motion, the distance of two shapes decreases by at most the slack."""
TOUCH: Final = 0.0005
"""Depth above which shapes are considered to collide [m]. In the physics engines,
shapes that rest on each other also overlap by about 0.1 mm."""
PRESSED: Final = 0.002
"""Maximum depth by which bodies may overlap at the start [m]. For example, the
commanded position of a tool that presses on a table is inside the table."""
MOST_GROUPS: Final = 16
"""Maximum number of groups that are cached for later requests."""
_ROUNDING: Final = 1e-4
"""Distance by which bodies that are close at the start may approach each other [m]."""
_FAR: Final = 1.0


class UprightTool(NamedTuple):
    """Constraint that keeps a tool upright."""

    link: str
    axis: tuple[float, float, float]
    """Axis to keep upright, as a unit vector in the link's frame."""
    tilt: float
    """Maximum angle between the axis and its direction at the start [rad]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """Constraints of a motion."""

    clearance: float = CLEARANCE
    """Minimum distance between shapes [m]."""
    may_touch: frozenset[str] = frozenset()
    """Links and objects that the motion may touch."""
    upright: UprightTool | None = None


@final
class CollisionWorld:
    """The shapes of a robot and its surroundings, for use by one thread at a time."""

    def __init__(
        self,
        model: RobotModel,
        ground: float | None,
        usual: Mapping[str, float],
        apart: Collection[frozenset[str]] = (),
    ) -> None:
        """Use a robot; its shapes are compiled when they are needed for the first time.

        Args:
            model: The robot.
            ground: Height of the ground in the frame of the robot's root [m]; None if
                there is no ground.
            usual: Joint → position in the default pose [rad | m]. Links that overlap in
                the default pose are assumed to touch by construction.
            apart: Pairs of links that need no collision check, such as the pairs of an
                SRDF.
        """
        self._model, self._ground = model, ground
        self._usual, self._apart = dict(usual), frozenset(apart)
        self._compiled: tuple[object, DistanceModel] | None = None
        self._groups: dict[object, PlanningGroup] = {}
        self._ignored: frozenset[frozenset[str]] | None = None

    def group(
        self, joints: Sequence[str], around: Surroundings, rules: Rules
    ) -> PlanningGroup:
        """Return the collision checks for motions of some joints.

        The other joints are at rest. The result is valid until the next call of this
        method.

        Raises:
            ModelError: If MuJoCo does not support a shape.
            PlanningError: If there is no compiled kernel.
        """
        compiled = library.load()
        if compiled is None:
            raise PlanningError(
                "planning needs tool0's compiled kernel, and there is none: "
                f"{library.kernel_status().reason}; compile it: "
                f"{library.COMPILE_COMMAND}"
            )
        distances = self._fitting(around)
        distances.place(state for _, state in around.objects)
        distances.put(around.positions)
        key = tuple(joints), rules
        if rules.upright is None and key in self._groups:
            return self._groups[key]
        pairs = tuple(self._pairs(distances, joints, around, rules))
        bounds = [pair.bound for pair in pairs]
        least = np.array(bounds, dtype=np.float64) + SLACK
        shared = least.copy()
        upright = None
        if rules.upright is not None:
            upright = _upright(distances, joints, rules.upright)
        found = PlanningGroup(
            names=tuple((pair.first.owner, pair.second.owner) for pair in pairs),
            least=least,
            clearances=Clearances(
                compiled,
                distances.memory(),
                _joints(distances, joints),
                Pairs(
                    np.array([pair.first.geom for pair in pairs], dtype=np.int32),
                    np.array([pair.second.geom for pair in pairs], dtype=np.int32),
                    least=shared,
                    reach=np.array([pair.reach for pair in pairs]).reshape(
                        -1, len(joints)
                    ),
                ),
                slack=SLACK,
                upright=upright,
            ),
            shared=shared,
            owner=distances,
        )
        if len(self._groups) == MOST_GROUPS:
            self._groups.clear()
        self._groups[key] = found
        return found

    def _fitting(self, around: Surroundings) -> DistanceModel:
        """Return the compiled shapes; reuse the shapes of the last call if they fit."""
        from tool0.engines.mujoco.gl import import_mujoco

        import_mujoco()
        from tool0.engines.mujoco.distances import DistanceModel

        objects = tuple(item for item, _ in around.objects)
        wanted = objects, around.held, around.planes
        if self._compiled is None or wanted != self._compiled[0]:
            distances = DistanceModel(
                self._model,
                self._ground,
                objects=objects,
                held=around.held,
                planes=around.planes,
            )
            self._compiled = wanted, distances
            self._groups.clear()
        return self._compiled[1]

    def _pairs(
        self,
        distances: DistanceModel,
        joints: Sequence[str],
        around: Surroundings,
        rules: Rules,
    ) -> Iterator[_Pair]:
        """Yield the pairs of shapes between which a motion can change the distance."""
        from tool0.engines.mujoco.link_collisions import robot_of

        shapes: dict[int, list[Shape]] = {}
        for shape in distances.shapes:
            shapes.setdefault(shape.body, []).append(shape)
        above = {body: dict(distances.joints_above(body)) for body in shapes}
        levers = {
            body: np.array([found.get(name, np.nan) for name in joints])
            for body, found in above.items()
        }
        sizes = {shape: distances.size(shape) for shape in distances.shapes}
        extents = {shape: distances.extent(shape) for shape in distances.shapes}
        slides = np.array([distances.slides(name) for name in joints])
        turning = _turns_about_normals(distances, joints, above)
        robots = {
            link: robot_of(self._model, link) for link in self._model.link_by_name
        }
        apart = self._links_that_touch(distances) | self._grips(around)
        for a, b in itertools.combinations(shapes, 2):
            if distances.parent(a) == b != 0 or distances.parent(b) == a != 0:
                continue
            moves_a = ~np.isnan(levers[a]) & np.isnan(levers[b])
            moves_b = ~np.isnan(levers[b]) & np.isnan(levers[a])
            if not (moves_a.any() or moves_b.any()):
                continue
            for one, two in itertools.product(shapes[a], shapes[b]):
                if frozenset((one.owner, two.owner)) in apart:
                    continue
                reach = np.where(
                    moves_a, np.where(slides, 1.0, levers[a] + extents[one]), 0.0
                ) + np.where(
                    moves_b, np.where(slides, 1.0, levers[b] + extents[two]), 0.0
                )
                for shape in (one, two):
                    if shape in turning:
                        reach[turning[shape]] = 0.0
                if not reach.any():
                    continue
                first, second = (one, two) if sizes[one] <= sizes[two] else (two, one)
                bound = rules.clearance
                if not rules.may_touch.isdisjoint((one.owner, two.owner)):
                    bound = -TOUCH
                elif robots.get(one.owner, 1) == robots.get(two.owner, 2):
                    bound = min(bound, OWN_CLEARANCE)
                yield _Pair(first, second, reach, bound)

    def _grips(self, around: Surroundings) -> frozenset[frozenset[str]]:
        """Return all pairs of a held object and a link that holds it."""
        return frozenset(
            frozenset((load.item.name, link))
            for load in around.held
            for link in self._model.links_from(load.link)
        )

    def _links_that_touch(self, distances: DistanceModel) -> frozenset[frozenset[str]]:
        """Return the pairs of links that are allowed to touch."""
        if self._ignored is None:
            from tool0.engines.mujoco.link_collisions import (
                adjacent_links,
                mechanism_of,
            )

            model = self._model
            links = [link.name for link in model.links if link.collisions]
            masters = {name: mechanism_of(model, name) for name in links}
            self._ignored = frozenset(
                {
                    *map(frozenset, adjacent_links(model)),
                    *(
                        frozenset(pair)
                        for pair in itertools.combinations(links, 2)
                        if masters[pair[0]] is not None
                        and masters[pair[0]] == masters[pair[1]]
                    ),
                    *distances.overlapping(links, self._usual),
                    *self._apart,
                }
            )
        return self._ignored


class _Pair(NamedTuple):
    first: Shape
    second: Shape
    reach: Array
    bound: float
    """Minimum distance of the pair [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningGroup:
    """Collision checks for motions of some joints, with the pairs of their shapes."""

    names: tuple[tuple[str, str], ...]
    """Names of the two bodies to which each pair of shapes belongs."""
    least: Array
    """Minimum distance of each pair, including SLACK [m]."""
    clearances: Clearances
    shared: Array
    """Minimum distances in the memory that ``clearances`` reads [m]."""
    owner: DistanceModel = field(repr=False)
    """Owner of the memory that ``clearances`` uses. The reference keeps the memory
    alive."""

    def begin(self, start: Array, *, is_check: bool = False) -> None:
        """Allow bodies that are close at the start to remain equally close.

        A search also keeps a distance of SLACK. A check does not, and is therefore as
        exact as the steps along the motion.

        Raises:
            CollisionError: If bodies collide at the start (except in a check), or if
                the tool is tilted too much.
        """
        self.shared[:] = self.least - SLACK if is_check else self.least
        if self.clearances.at(start) == TILTED:
            raise CollisionError(
                "the tool is tilted at the start, by more than the motion allows"
            )
        found = self.clearances.distances(start, float(self.least.max(initial=0.0)))
        deepest = int(found.argmin()) if len(found) else FREE
        if not is_check and deepest >= 0 and found[deepest] < -PRESSED:
            first, second = self.names[deepest]
            raise CollisionError(
                f"the start is in collision: '{first}' is "
                f"{-1e3 * found[deepest]:.1f} mm in '{second}'"
            )
        np.minimum(self.shared, found - _ROUNDING, out=self.shared)

    def why_not(self, q: Array) -> str:
        """Return the reason why a pose is not free; empty if it is free."""
        found = self.clearances.at(q)
        if found == FREE:
            return ""
        return self.explained(found, q)

    def explained(self, pair: int, q: Array) -> str:
        """Return a message that explains why a pair makes a pose invalid."""
        if pair == TILTED:
            return "the tool is tilted more than it may be"
        first, second = self.names[pair]
        distance = float(self.clearances.distances(q, _FAR)[pair])
        if distance < 0.0:
            return f"'{first}' would be {-1e3 * distance:.1f} mm in '{second}'"
        return (
            f"'{first}' would be {1e3 * distance:.1f} mm from '{second}', nearer than "
            f"{1e3 * (self.least[pair] - SLACK):.1f} mm"
        )

    def clearance(self, poses: Array) -> tuple[float, str]:
        """Return the minimum distance in poses [m], up to 1 m, and the two bodies.

        Pairs that are allowed to touch are ignored.
        """
        least, names = _FAR, ""
        counted = np.where(self.least > 0.0, 0.0, np.inf)
        for q in poses if len(self.names) else ():
            found = self.clearances.distances(q, least) + counted
            pair = int(found.argmin())
            if found[pair] < least:
                least, names = float(found[pair]), " and ".join(self.names[pair])
        return least, names


def _turns_about_normals(
    distances: DistanceModel,
    joints: Sequence[str],
    above: Mapping[int, Mapping[str, float]],
) -> dict[Shape, list[int]]:
    """Return the indices of the joints that turn about each plane's normal.

    Such joints are at the base of an arm and do not move any body closer to the plane.
    """
    steady = {list(found)[-1] for found in above.values() if found}
    found: dict[Shape, list[int]] = {}
    for shape in distances.shapes:
        if distances.is_plane(shape):
            found[shape] = [
                k
                for k, name in enumerate(joints)
                if name in steady and distances.is_parallel(name, shape)
            ]
    return found


def _upright(
    distances: DistanceModel, joints: Sequence[str], tool: UprightTool
) -> Upright:
    body = distances.body_of(tool.link)
    axis = distances.rotation_in_body(tool.link) @ np.array(tool.axis)
    axis /= np.linalg.norm(axis)
    rotation = distances.data.xmat[body].reshape(3, 3)
    above = dict(distances.joints_above(body))
    tilting = _bits(joints, lambda name: name in above and not distances.slides(name))
    return Upright(
        body=body,
        axis=axis,
        up=rotation @ axis,
        tilt=tool.tilt,
        tilting=tilting,
    )


def _joints(distances: DistanceModel, joints: Sequence[str]) -> Joints:
    moved_by = []
    for shape in distances.shapes:
        above = dict(distances.joints_above(shape.body))
        moved_by.append(_bits(joints, above.__contains__))
    return Joints(
        addresses=distances.addresses(joints),
        axis_rows=distances.axis_rows(joints),
        sliding=_bits(joints, distances.slides),
        moved_by=np.array(moved_by, dtype=np.uint32),
    )


def _bits(joints: Sequence[str], has: Callable[[str], bool]) -> int:
    return sum(1 << k for k, name in enumerate(joints) if has(name))
