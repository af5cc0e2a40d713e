"""Collisions that the robot would have in a pose, and on the straight way to it.

They are found by MuJoCo's shapes for every engine, from snapshots and in the thread of
the caller, so they cost the tick nothing.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, final

from tool0.description.forward_kinematics import joint_positions
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.scene import SceneObject
from tool0.description.transform import Transform, from_quaternion
from tool0.errors import ControlError
from tool0.hardware.engine import ObjectState
from tool0.sensing.grasp import pad_links
from tool0.sensing.grip_contacts import finger_links
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.engines.mujoco.overlaps import OverlapFinder, Pair

TOUCH = 0.0005
"""Depth from which shapes collide [m]: links that rest on each other are some 0.1 mm
into each other in the physics, too."""
STEP = 0.02
"""Largest motion of a joint between two looks at a path [rad | m]: 2 cm at the end of
an arm of 1 m."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Collision:
    """Two things that would be in each other, on a path or at its end."""

    first: str
    """A link of the robot, or an object that it holds."""
    second: str
    """Another link, an object, or ``ground``."""
    depth: float
    """Largest depth on the path [m]."""
    begins: float
    """Where on the path the collision begins: 0 at its start, 1 at its end."""
    depth_at_end: float
    """Depth at the end of the path [m]; 0 if they do not collide there."""


@final
class CollisionFinder:
    """Finds collisions of one robot in any pose.  Any thread may use it."""

    def __init__(self, model: RobotModel, ground: float | None) -> None:
        """Compile nothing until collisions are asked for.

        ``ground`` is its height in the robot's root [m]; None without ground.
        """
        self._model = model
        self._ground = ground
        self._lock = Lock()
        self._finder: OverlapFinder | None = None

    def on_way(
        self, state: Snapshot, positions: Mapping[str, float]
    ) -> tuple[Collision, ...]:
        """Return the collisions on the way from ``state`` to ``positions``.

        All joints move in proportion, on a straight line in joint space.  What a
        gripper holds is carried along.  Pairs that are as deep in each other now are
        left out.

        Args:
            state: Where everything is now.
            positions: Joint → target [rad | m]; other joints stay.

        Raises:
            ModelError: For an unknown joint, or an object that MuJoCo does not support.
            LimitsError: For a position beyond the joint's limits.
        """
        start = state.position
        end = self._moved(start, positions)
        largest = max((abs(b - a) for a, b in zip(start, end, strict=True)), default=0)
        n = max(1, math.ceil(largest / STEP))
        with self._lock:
            finder = self._fitting(state.scene)
            for item, at in zip(state.scene, state.objects, strict=True):
                finder.put_object(item, at)
            finder.put_joints(start)
            before = finder.depths()
            held = self._held(finder, state, before)
            moving = {*self._model.link_by_name, *held}
            found: dict[Pair, Collision] = {}
            for k in range(1, n + 1):
                share = k / n
                finder.put_joints(
                    [a + share * (b - a) for a, b in zip(start, end, strict=True)]
                )
                for load in held.values():
                    load.follow(finder)
                for pair, depth in finder.depths().items():
                    least = TOUCH + max(0.0, before.get(pair, 0.0))
                    if depth > least and not moving.isdisjoint(pair):
                        _note(found, _robot_first(pair, moving), depth, share)
        return tuple(found.values())

    def _fitting(self, objects: tuple[SceneObject, ...]) -> OverlapFinder:
        """Return the finder with these objects."""
        from tool0.engines.mujoco.gl import import_mujoco

        import_mujoco()
        from tool0.engines.mujoco.overlaps import OverlapFinder

        if self._finder is None:
            self._finder = OverlapFinder(self._model, self._ground)
        self._finder.use(objects)
        return self._finder

    def _moved(
        self, start: Sequence[float], positions: Mapping[str, float]
    ) -> list[float]:
        """Return ``start`` with ``positions``, and what mimics them."""
        end = joint_positions(self._model, positions, start)
        return [
            after
            if joint.name in positions
            or (joint.mimic is not None and joint.mimic.joint in positions)
            else before  # fingers give way a little: they do not follow to the digit
            for joint, before, after in zip(
                self._model.movable_joints, start, end, strict=True
            )
        ]

    def _held(
        self, finder: OverlapFinder, state: Snapshot, depths: Mapping[Pair, float]
    ) -> dict[str, _Load]:
        """Return the movable objects that both fingers of a gripper touch, by name."""
        movable = {
            item.name: (item, at)
            for item, at in zip(state.scene, state.objects, strict=True)
            if item.mass is not None
        }
        held = {}
        for gripper in self._model.grippers:
            fingers = _fingers(self._model, gripper)
            for name, (item, at) in movable.items():
                touching = {link for pair in depths if name in pair for link in pair}
                if fingers and not any(map(touching.isdisjoint, fingers)):
                    base = self._model.joint(gripper.joint).parent
                    T_base_root = finder.link_pose(base).inverse()
                    T_root_item = from_quaternion(at.position, at.quat_wxyz)
                    held[name] = _Load(item, base, T_base_root @ T_root_item)
        return held


@final
@dataclass(frozen=True, slots=True)
class _Load:
    """An object in a gripper."""

    item: SceneObject
    base: str
    """The gripper's link that carries the fingers."""
    T_base_item: Transform

    def follow(self, finder: OverlapFinder) -> None:
        """Put the object where the gripper carries it."""
        pose = finder.link_pose(self.base) @ self.T_base_item
        at = ObjectState(self.item.name, pose.position, pose.quat_wxyz)
        finder.put_object(self.item, at)


def _fingers(model: RobotModel, gripper: ParallelGripper) -> tuple[frozenset[str], ...]:
    """Return the links of each finger; none of a gripper without two pads."""
    try:
        pads = pad_links(model, gripper)
    except ControlError:
        return ()
    base = model.joint(gripper.joint).parent
    return tuple(finger_links(model, base, pad) for pad in pads)


def _robot_first(pair: Pair, moving: Collection[str]) -> Pair:
    """Return the pair with what the robot moves as its first."""
    first, second = pair
    return pair if first in moving else (second, first)


def _note(found: dict[Pair, Collision], pair: Pair, depth: float, share: float) -> None:
    """Add what was seen at ``share`` of the path."""
    known = found.get(pair)
    first, second = pair
    found[pair] = Collision(
        first=first,
        second=second,
        depth=depth if known is None else max(depth, known.depth),
        begins=share if known is None else known.begins,
        depth_at_end=depth if share == 1.0 else 0.0,
    )
