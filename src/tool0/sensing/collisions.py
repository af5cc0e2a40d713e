"""Collisions of the robot in a pose and on the straight path to it.

For every engine, MuJoCo's shapes are used to detect collisions. Collisions are computed
from snapshots in the caller's thread, so they do not slow down the tick.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from threading import Lock
from typing import TYPE_CHECKING, final

from tool0.description.forward_kinematics import joint_positions
from tool0.description.grasp_frames import pad_links
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.surroundings import HeldObject
from tool0.description.transform import from_quaternion, to_transform
from tool0.errors import ControlError, ModelError, PenetrationError
from tool0.protocol.objects import Collision
from tool0.protocol.state import Snapshot
from tool0.sensing.grip_contacts import finger_links

if TYPE_CHECKING:
    from tool0.engines.mujoco.overlaps import OverlapFinder, Pair

TOUCH = 0.0005
"""Depth above which shapes are considered to collide [m]. Links that rest on each other
also overlap by about 0.1 mm in the physics engines."""
STEP = 0.02
"""Maximum motion of a joint between two checked points of a path [rad | m]. The value
corresponds to 2 cm at the end of an arm with a length of 1 m."""
MAX_PENETRATION = 0.002
"""Maximum depth by which links may overlap a body when a user places the robot or an
object [m]. The physics engine separates the bodies without a jerk."""


@final
class CollisionFinder:
    """Detects collisions of one robot in any pose. Any thread may use the finder."""

    def __init__(self, model: RobotModel, ground: float | None) -> None:
        """Prepare the finder; shapes are not compiled before collisions are requested.

        ``ground`` is the height of the ground in the robot's root frame [m], or None if
        there is no ground.
        """
        self._model = model
        self._ground = ground
        self._lock = Lock()
        self._finder: OverlapFinder | None = None
        self._beside_lock = Lock()
        self._beside: OverlapFinder | None = None
        """Finder for single objects in the thread of the tick. With a separate finder,
        the thread of the tick does not wait for path checks and does not recompile the
        scene for each object."""

    def on_way(
        self, state: Snapshot, positions: Mapping[str, float]
    ) -> tuple[Collision, ...]:
        """Return the collisions on the path from ``state`` to ``positions``.

        All joints move synchronously along a straight line in joint space. Gripped
        objects move with the gripper. A pair is omitted if its overlap is not deeper
        than at the start.

        Args:
            state: Current state of the robot and the objects.
            positions: Joint → target [rad | m]. The other joints do not move.

        Raises:
            ModelError: If a joint is unknown, or MuJoCo does not support an object.
            LimitsError: If a position exceeds the joint's limits.
        """
        start = state.position
        end = self._moved(start, positions)
        largest = max((abs(b - a) for a, b in zip(start, end, strict=True)), default=0)
        n = max(1, math.ceil(largest / STEP))
        with self._lock:
            finder = self._finder = self._fitting(self._finder, state.scene)
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
                    _carry(finder, load)
                for pair, depth in finder.depths().items():
                    least = TOUCH + max(0.0, before.get(pair, 0.0))
                    if depth > least and not moving.isdisjoint(pair):
                        _note(found, _robot_first(pair, moving), depth, share)
        return tuple(found.values())

    def held(self, state: Snapshot) -> tuple[HeldObject, ...]:
        """Return the movable objects that both fingers of a gripper touch.

        Raises:
            ModelError: If MuJoCo does not support an object.
        """
        if not any(item.mass is not None for item in state.scene):
            return ()
        with self._lock:
            finder = self._finder = self._fitting(self._finder, state.scene)
            for item, at in zip(state.scene, state.objects, strict=True):
                finder.put_object(item, at)
            finder.put_joints(state.position)
            return tuple(self._held(finder, state, finder.depths()).values())

    def require_pose(
        self,
        position: Sequence[float],
        usual: Sequence[float],
        objects: tuple[SceneObject, ...],
    ) -> None:
        """Raise PenetrationError if the robot would overlap another body.

        Links that overlap each other or the ground in the ``usual`` pose are ignored,
        because the links of some descriptions always overlap. A robot with shapes that
        MuJoCo cannot read is not checked.

        Args:
            position: Pose to check [rad | m], shape (n_joints,), in the model's order.
            usual: Another pose that was accepted before, with the same shape.
            objects: Objects around the robot with their start poses.
        """
        with self._lock, contextlib.suppress(ModelError):
            finder = self._finder = self._fitting(self._finder, objects)
            for item in objects:
                finder.put_object(item, _at_start(item))
            finder.put_joints(usual)
            names = {item.name for item in objects}
            before = {
                pair: depth
                for pair, depth in finder.depths().items()
                if names.isdisjoint(pair)
            }
            finder.put_joints(position)
            after = finder.depths()
            links = self._model.link_by_name
            _require_apart(
                (
                    (*_robot_first(pair, links), depth)
                    for pair, depth in after.items()
                    if not links.keys().isdisjoint(pair)
                    and depth > MAX_PENETRATION + max(0.0, before.get(pair, 0.0))
                ),
                "the pose puts '{0}' {2:.1f} mm into '{1}'",
            )

    def prepare(self, item: SceneObject) -> None:
        """Compile the shapes for ``require_outside`` in advance, outside the tick."""
        with self._beside_lock, contextlib.suppress(ModelError):
            self._beside = self._fitting(self._beside, (item,))

    def require_outside(
        self,
        position: Sequence[float],
        item: SceneObject,
        at: ObjectState | None = None,
    ) -> None:
        """Raise PenetrationError if an object would be inside a link of the robot.

        Args:
            position: Joint positions [rad | m], shape (n_joints,), in the model's
                order.
            item: Object to check.
            at: Pose of the object; by default, the object's start pose.
        """
        with self._beside_lock, contextlib.suppress(ModelError):
            finder = self._beside = self._fitting(self._beside, (item,))
            finder.put_object(item, at or _at_start(item))
            finder.put_joints(position)
            links = self._model.link_by_name
            _require_apart(
                (
                    (*_robot_first(pair, links)[::-1], depth)
                    for pair, depth in finder.depths().items()
                    if item.name in pair
                    and not links.keys().isdisjoint(pair)
                    and depth > MAX_PENETRATION
                ),
                "object '{0}' would be {2:.1f} mm in '{1}'",
            )

    def _fitting(
        self, finder: OverlapFinder | None, objects: tuple[SceneObject, ...]
    ) -> OverlapFinder:
        """Return ``finder`` or a new finder, prepared for the given objects."""
        from tool0.engines.mujoco.gl import import_mujoco

        import_mujoco()
        from tool0.engines.mujoco.overlaps import OverlapFinder

        if finder is None:
            finder = OverlapFinder(self._model, self._ground)
        finder.use(objects)
        return finder

    def _moved(
        self, start: Sequence[float], positions: Mapping[str, float]
    ) -> list[float]:
        """Return ``start`` with the values of ``positions`` and of mimic joints."""
        end = joint_positions(self._model, positions, start)
        return [
            after
            if joint.name in positions
            or (joint.mimic is not None and joint.mimic.joint in positions)
            else before  # fingers yield slightly and do not follow exactly
            for joint, before, after in zip(
                self._model.movable_joints, start, end, strict=True
            )
        ]

    def _held(
        self, finder: OverlapFinder, state: Snapshot, depths: Mapping[Pair, float]
    ) -> dict[str, HeldObject]:
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
                    held[name] = HeldObject(item, base, T_base_root @ T_root_item)
        return held


def _carry(finder: OverlapFinder, load: HeldObject) -> None:
    """Move a held object to its pose in the gripper."""
    pose = finder.link_pose(load.link) @ load.T_link_item
    at = ObjectState(load.item.name, pose.position, pose.quat_wxyz)
    finder.put_object(load.item, at)


def _fingers(model: RobotModel, gripper: ParallelGripper) -> tuple[frozenset[str], ...]:
    """Return the links of each finger; empty if the gripper does not have two pads."""
    try:
        pads = pad_links(model, gripper)
    except ControlError:
        return ()
    base = model.joint(gripper.joint).parent
    return tuple(finger_links(model, base, pad) for pad in pads)


def _at_start(item: SceneObject) -> ObjectState:
    T_root_item = to_transform(item.pose)
    return ObjectState(item.name, T_root_item.position, T_root_item.quat_wxyz)


def _require_apart(found: Iterable[tuple[str, str, float]], text: str) -> None:
    """Raise PenetrationError for the deepest overlap in ``found``, if there is one."""
    deepest = sorted(found, key=lambda each: -each[2])
    if not deepest:
        return
    first, second, depth = deepest[0]
    others = "" if len(deepest) == 1 else f", and {len(deepest) - 1} more such contacts"
    raise PenetrationError(
        text.format(first, second, 1000.0 * depth)
        + f"{others}; up to {1000.0 * MAX_PENETRATION:g} mm are accepted. "
        "allow_penetration accepts it; the physics then pushes them apart"
    )


def _robot_first(pair: Pair, moving: Collection[str]) -> Pair:
    """Return the pair, starting with the element that the robot moves."""
    first, second = pair
    return pair if first in moving else (second, first)


def _note(found: dict[Pair, Collision], pair: Pair, depth: float, share: float) -> None:
    """Add an overlap at the fraction ``share`` of the path."""
    known = found.get(pair)
    first, second = pair
    found[pair] = Collision(
        first=first,
        second=second,
        depth=depth if known is None else max(depth, known.depth),
        begins=share if known is None else known.begins,
        depth_at_end=depth if share == 1.0 else 0.0,
    )
