"""The interface to a physics engine, and the checks that every engine makes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import NamedTuple, Protocol, final

from tool0.description.scene import SceneObject
from tool0.description.transform import Vector3
from tool0.errors import ConfigError, DivergenceError, EngineError, did_you_mean


class JointState(NamedTuple):
    """The measured state of every movable joint at one instant.

    Lists have shape (n_joints,), ordered as the engine's ``joint_names``.  A named
    tuple of plain lists: the tick makes one a thousand times a second, and plain
    floats are what Python computes with fastest.
    """

    time: float
    """Simulated time [s]."""
    position: list[float]
    """[rad], or [m] for a prismatic joint."""
    velocity: list[float]
    """[rad/s] or [m/s]."""
    effort: list[float]
    """Last applied effort [N·m] or [N]."""


JointSelector = Callable[[list[float]], Sequence[float]]
"""Takes some joints out of a list of all joints."""


def joint_selector(indices: Sequence[int]) -> JointSelector:
    """Return the function that takes ``indices`` out of a list.

    It runs in C: a slice where the joints stand side by side, as they mostly do.
    """
    run = as_slice(indices)
    if run is not None:
        return itemgetter(run)
    return itemgetter(*indices)


def as_slice(indices: Sequence[int]) -> slice | None:
    """Return the slice that is ``indices``, or None if they do not stand in a row."""
    first = indices[0] if indices else 0
    if list(indices) == list(range(first, first + len(indices))):
        return slice(first, first + len(indices))
    return None


@final
@dataclass(frozen=True, slots=True)
class ObjectState:
    """Pose and velocity of a scene object, in the robot's root."""

    name: str
    position: tuple[float, float, float]
    """[m]"""
    quat_wxyz: tuple[float, float, float, float]
    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Velocity of its origin [m/s]."""
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """[rad/s]"""


@final
@dataclass(frozen=True, slots=True)
class Contact:
    """The resultant of all contact points between two things.

    Links and objects have their own names, also links that are fixed to others; the
    engine's own ground is ``ground``.  Vectors are in the axes of the robot's root.
    """

    first: str
    second: str
    point: tuple[float, float, float]
    """Mean of the contact points, weighted by their normal forces [m]."""
    force: tuple[float, float, float]
    """That ``first`` exerts on ``second`` [N]."""
    torque: tuple[float, float, float]
    """That ``first`` exerts on ``second``, about ``point`` [N·m]."""


class World(Protocol):
    """The objects around the robot: state, spawning, attachments and contacts.

    An engine keeps the same world for its whole life.  Only the thread that owns the
    tick may use it.
    """

    @property
    def gravity(self) -> Vector3:
        """Acceleration of free fall [m/s²], in the axes of the robot's root."""

    @property
    def ground(self) -> float | None:
        """Height of the ground [m], in the robot's root; None if it is not known."""

    def object_states(self) -> tuple[ObjectState, ...]:
        """Return the current state of each object, spawned ones last."""

    def spawn(self, item: SceneObject) -> None:
        """Add an object at rest; everything else keeps its state.

        If it is refused, nothing has changed.

        Raises:
            ModelError: If the engine cannot have such an object.
            EngineError: If the name is taken, or the engine refuses.
        """

    def delete(self, name: str) -> None:
        """Remove an object, or raise EngineError if there is none."""

    def place(self, state: ObjectState) -> None:
        """Set an object's pose and velocity; its quaternion has length one.

        A reset puts it back where it was spawned, or began.

        Raises:
            EngineError: If there is none, or it has no mass and a velocity is given.
        """

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts of the last step, one item for each pair.

        An attachment counts as a contact.  Empty before the first step after a reset.
        An engine may begin to record with the first call, which then returns none.
        """

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link at its current pose, until it is detached.

        No hand does this: it is for ``--grasp-assist`` only.  A reset, a deletion and
        a placement detach it.

        Raises:
            ModelError: If there is no such link.
            EngineError: If there is no such object, it has no mass, or it is attached
                already.
        """

    def detach(self, name: str) -> None:
        """Release an object; one that is not attached is left alone."""


class Engine(Protocol):
    """Physics, as the control loop sees it: read, write, step, in that order.

    Every sequence has shape (n_joints,), ordered as ``joint_names``: all movable
    joints of the robot, mimic joints included.  The rest is in ``world``.
    """

    @property
    def name(self) -> str:
        """The name that the engine is registered under: ``mujoco``, ``gazebo``."""

    @property
    def joint_names(self) -> tuple[str, ...]: ...

    @property
    def dt(self) -> float:
        """Length of one step [s]."""

    @property
    def world(self) -> World:
        """The objects around the robot."""

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        """Put joints at ``position`` [rad | m], at rest, and objects where they began.

        Simulated time is ``time`` [s] then.
        """

    def read(self) -> JointState:
        """Return the measured state: a copy, never a view into the engine.

        Raises:
            DivergenceError: If the state is not finite.
        """

    def write(self, effort: Sequence[float]) -> None:
        """Hold ``effort`` [N·m | N] until the next call.

        Raises:
            DivergenceError: If it is not finite.
        """

    def step(self) -> None:
        """Advance simulated time by ``dt``."""

    def close(self) -> None:
        """End the engine and what it started; closing twice is allowed."""


def check_dt(dt: float) -> None:
    """Raise ConfigError unless ``dt`` [s] can be the length of a step."""
    if not 0.0 < dt < math.inf:
        raise ConfigError(f"the step must be above 0 s and finite, got {dt}")


def effort_divergence(
    joint_names: Sequence[str], effort: Sequence[float], time: float
) -> DivergenceError:
    """Return the error for efforts [N·m | N] whose sum is not finite."""
    worst = next((i for i, u in enumerate(effort) if not math.isfinite(u)), 0)
    return DivergenceError(joint_names[worst], time, "effort")


def check_new_name(objects: Mapping[str, SceneObject], name: str) -> None:
    """Raise EngineError if there is an object ``name`` already."""
    if name in objects:
        raise EngineError(
            f"there is an object '{name}' already; "
            "remove it first, or take another name"
        )


def find_object(objects: Mapping[str, SceneObject], name: str) -> SceneObject:
    """Return the object ``name``, or raise EngineError if there is none."""
    if name not in objects:
        hint = did_you_mean(name, set(objects))
        raise EngineError(f"there is no object '{name}'{hint}")
    return objects[name]


def check_attachable(objects: Mapping[str, SceneObject], name: str) -> None:
    """Raise EngineError unless there is an object ``name`` that can move."""
    if find_object(objects, name).mass is None:
        raise EngineError(
            f"object '{name}' has no mass and is static; only a movable object can be "
            "attached"
        )


def check_placement(objects: Mapping[str, SceneObject], state: ObjectState) -> None:
    """Raise EngineError unless the object of ``state`` can have that velocity."""
    item = find_object(objects, state.name)
    if item.mass is None and any((*state.linear, *state.angular)):
        raise EngineError(
            f"object '{state.name}' has no mass and is static; "
            "place it without a velocity"
        )
