"""Search for pairs of links that a motion planner need not check for collisions.

MuJoCo's collision detection checks the description's collision shapes in random poses.
The check has no dynamics: every link is a separate body that is placed by forward
kinematics.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, final

import mujoco
import numpy as np

from tool0.description.joint_tree import LinkFrames
from tool0.description.model import Joint, RobotModel
from tool0.engines.mujoco.model import add_geom, collision_name, compile_spec
from tool0.errors import ModelError

N_SAMPLES: Final = 10_000
"""Number of random poses."""
SEED: Final = 0
CLEARANCE: Final = 0.002
"""Distance below which a pair is not classified as never colliding [m].  A rare
collision may occur between two samples."""
ALWAYS: Final = 0.95
"""Fraction of colliding samples above which two links are classified as always
colliding.  MoveIt's setup assistant uses the same fraction."""
_CHUNK: Final = 1000
"""Number of samples per batch of forward kinematics."""
_ARENA: Final = 2**26
"""Size of the memory for contacts [bytes]."""

LinkPair = tuple[str, str]
"""The names of two links, in alphabetical order."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SampledCollisions:
    """Numbers of random poses in which pairs of links collided."""

    n_samples: int
    collided: Mapping[LinkPair, int]
    """Number of samples in which the shapes of two links overlapped."""
    near: frozenset[LinkPair]
    """Pairs that came closer than ``CLEARANCE`` at least once."""


def disabled_collisions(
    model: RobotModel,
    default: Mapping[str, float],
    *,
    n_samples: int = N_SAMPLES,
    seed: int = SEED,
) -> dict[LinkPair, str]:
    """Return the pairs of links to exclude from collision checks, and the reasons.

    The reasons have MoveIt's names.  ``Adjacent``: a joint connects the links, possibly
    through links without shapes.  ``Default``: the links collide in the default pose.
    ``Always``: the links collide in nearly all samples.  ``User``: the links are parts
    of one mechanism, such as the pads of a gripper, which touch by design.  ``Never``:
    the links do not collide in any sample.

    Links of different robots are classified as never colliding only if their swept
    volumes do not overlap, since there are too many combinations of poses to sample.

    Args:
        model: The robot, or several robots below one root.
        default: Joint positions of the default pose, by joint name [rad | m].
        n_samples: Number of random poses within the limits of the joints.
        seed: Seed of the random poses.
    """
    shapes = LinkShapes(model)
    sampled = shapes.sample(n_samples, seed)
    at_default = shapes.colliding_at(default)
    adjacent = set(adjacent_links(model))
    robot = {link: robot_of(model, link) for link in shapes.links}
    masters = {link: mechanism_of(model, link) for link in shapes.links}
    reasons = {}
    for pair in itertools.combinations(sorted(shapes.links), 2):
        first, second = pair
        is_one_robot = robot[first] == robot[second]
        collided = sampled.collided.get(pair, 0)
        if pair in adjacent:
            reasons[pair] = "Adjacent"
        elif pair in at_default and is_one_robot:
            reasons[pair] = "Default"
        elif collided > ALWAYS * n_samples:
            reasons[pair] = "Always"
        elif pair in sampled.near:
            if masters[first] is not None and masters[first] == masters[second]:
                reasons[pair] = "User"
        elif is_one_robot or shapes.are_apart(pair):
            reasons[pair] = "Never"
    return reasons


@final
class LinkShapes:
    """Links with collision shapes, each of which is a free body in MuJoCo."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self.links = tuple(link.name for link in model.links if link.collisions)
        self._frames = LinkFrames(model, self.links)
        spec = mujoco.MjSpec()
        spec.memory = _ARENA
        for name in self.links:
            body = spec.worldbody.add_body(name=name)
            body.add_freejoint()
            for number, shape in enumerate(model.link(name).collisions):
                geom = add_geom(spec, body, shape, np.eye(4))
                geom.name = collision_name(model.link(name), number)
                geom.margin = CLEARANCE
        self._mjmodel = compile_spec(spec)
        self._data = mujoco.MjData(self._mjmodel)
        bodies = [self._mjmodel.body(name).id for name in self.links]
        self._order = {body: index for index, body in enumerate(bodies)}
        self._link_of_geom = np.array(
            [self._order[body] for body in self._mjmodel.geom_bodyid]
        )
        n_geoms = int(self._mjmodel.ngeom)
        self._swept = np.full((n_geoms, 3), np.inf), np.full((n_geoms, 3), -np.inf)

    def sample(self, n_samples: int, seed: int) -> SampledCollisions:
        """Return how often links collide in random poses within the joints' limits."""
        rng = np.random.default_rng(seed)
        free = [joint for joint in self._model.movable_joints if joint.mimic is None]
        limits = np.array([_range(joint) for joint in free]).reshape(-1, 2)
        n_links = len(self.links)
        counts = np.zeros(n_links * n_links, dtype=int)
        near = np.zeros(n_links * n_links, dtype=bool)
        for start in range(0, n_samples, _CHUNK):
            n = min(_CHUNK, n_samples - start)
            positions = rng.uniform(limits[:, 0], limits[:, 1], size=(n, len(free)))
            given = dict(zip((j.name for j in free), positions.T, strict=True))
            for contacts in self._contacts(given, n):
                codes, depths = contacts
                near[codes] = True
                counts[np.unique(codes[depths < 0.0])] += 1
        return SampledCollisions(
            n_samples=n_samples,
            collided={
                self._pair(code): int(counts[code])
                for code in np.flatnonzero(counts).tolist()
            },
            near=frozenset(map(self._pair, np.flatnonzero(near).tolist())),
        )

    def colliding_at(self, pose: Mapping[str, float]) -> frozenset[LinkPair]:
        """Return the pairs of links that collide in a pose.

        ``pose`` contains the positions of the joints by name [rad | m].
        """
        given = {name: np.array([position]) for name, position in pose.items()}
        ((codes, depths),) = self._contacts(given, 1)
        return frozenset(self._pair(code) for code in codes[depths < 0.0])

    def are_apart(self, pair: LinkPair) -> bool:
        """Return whether the swept bounding boxes of two links do not overlap."""
        lower, upper = self._swept
        boxes = []
        for name in pair:
            mine = self._link_of_geom == self.links.index(name)
            boxes.append((lower[mine].min(axis=0), upper[mine].max(axis=0)))
        (lower_1, upper_1), (lower_2, upper_2) = boxes
        return bool(np.any(lower_1 > upper_2) or np.any(lower_2 > upper_1))

    def _contacts(self, given: Mapping[str, Any], n: int) -> Iterator[tuple[Any, Any]]:
        """Yield the codes of link pairs and the pairs' distances [m] in each pose."""
        frames = self._frames.poses(given, n)
        data, n_links = self._data, len(self.links)
        placed = np.empty((n, n_links, 7))
        for index, name in enumerate(self.links):
            placed[:, index, :3] = frames[name].position
            placed[:, index, 3:] = frames[name].quat_wxyz
        radius = self._mjmodel.geom_rbound[:, None]
        lower, upper = self._swept
        for qpos in placed.reshape(n, -1):
            data.qpos[:] = qpos
            mujoco.mj_kinematics(self._mjmodel, data)
            mujoco.mj_collision(self._mjmodel, data)
            np.minimum(lower, data.geom_xpos - radius, out=lower)
            np.maximum(upper, data.geom_xpos + radius, out=upper)
            links = np.sort(self._link_of_geom[data.contact.geom], axis=1)
            yield links[:, 0] * n_links + links[:, 1], data.contact.dist.copy()
        if data.warning[int(mujoco.mjtWarning.mjWARN_CONTACTFULL)].number:
            raise ModelError("MuJoCo has no memory for all contacts between the links")

    def _pair(self, code: int) -> LinkPair:
        first, second = sorted(self.links[i] for i in divmod(code, len(self.links)))
        return first, second


def adjacent_links(model: RobotModel) -> Iterator[LinkPair]:
    """Yield the pairs of adjacent links that have shapes.

    Two links with shapes are adjacent if they are connected by joints and links without
    shapes.
    """
    # A link without shapes represents itself and the links without shapes below it.
    node: dict[str, str] = {}
    neighbours: dict[str, set[str]] = defaultdict(set)
    edges = [(joint.parent, joint.child) for joint in model.joints]
    edges += [loop.links for loop in model.loops]
    has_shape = {link.name for link in model.links if link.collisions}
    for parent, child in edges:
        above = node.setdefault(parent, parent)
        if child not in node:
            is_joined = not {above, child} & has_shape and above != model.root
            node[child] = above if is_joined else child
        if above != node[child]:
            neighbours[above].add(node[child])
            neighbours[node[child]].add(above)
    for name, others in neighbours.items():
        if name in has_shape:
            yield from (_ordered(name, other) for other in others & has_shape)
        elif name != model.root:
            joined = sorted(others & has_shape)
            yield from itertools.combinations(joined, 2)


def _ordered(first: str, second: str) -> LinkPair:
    return (first, second) if first < second else (second, first)


def robot_of(model: RobotModel, link: str) -> str:
    """Return the child of the root above a link, which identifies the link's robot."""
    while link in model.parent_joint and model.parent_joint[link].parent != model.root:
        link = model.parent_joint[link].parent
    return link


def mechanism_of(model: RobotModel, link: str) -> str | None:
    """Return the joint that drives the mechanism of a link; None if there is none."""
    masters = {j.mimic.joint for j in model.joints if j.mimic is not None}
    while link in model.parent_joint:
        joint = model.parent_joint[link]
        if joint.mimic is not None:
            return joint.mimic.joint
        if joint.name in masters:
            return joint.name
        link = joint.parent
    return None


def _range(joint: Joint) -> tuple[float, float]:
    """Return a joint's sampled range [rad | m]: one turn if the joint is unlimited."""
    lower, upper = joint.limits.lower, joint.limits.upper
    is_limited = math.isfinite(lower) and math.isfinite(upper)
    return (lower, upper) if is_limited else (-math.pi, math.pi)
