"""The interface to a physics engine, and the checks that every engine makes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import itemgetter
from typing import NamedTuple, Protocol, final, overload

from tool0.description.scene import SceneObject
from tool0.description.scene_state import Contact, ObjectState
from tool0.description.transform import Vector3
from tool0.errors import ConfigError, DivergenceError, EngineError, did_you_mean


class JointState(NamedTuple):
    """The measured state of every movable joint at one instant.

    Lists have shape (n_joints,), ordered as the engine's ``joint_names``.  A named
    tuple of plain lists: the tick creates one a thousand times a second, and plain
    floats are the fastest in Python.
    """

    time: float
    """Simulated time [s]."""
    position: list[float]
    """Positions [rad], or [m] for a prismatic joint."""
    velocity: list[float]
    """Velocities [rad/s], or [m/s] for a prismatic joint."""
    effort: list[float]
    """Last applied effort [N·m] or [N]."""


JointSelector = Callable[[list[float]], Sequence[float]]
"""Selects some joints from a list of all joints."""


def joint_selector(indices: Sequence[int]) -> JointSelector:
    """Return the function that selects ``indices`` from a list.

    It runs in C: a slice if the joints are contiguous, as they mostly are.
    """
    run = as_slice(indices)
    if run is not None:
        return itemgetter(run)
    return itemgetter(*indices)


def as_slice(indices: Sequence[int]) -> slice | None:
    """Return the slice of ``indices``, or None if they are not contiguous."""
    first = indices[0] if indices else 0
    if list(indices) == list(range(first, first + len(indices))):
        return slice(first, first + len(indices))
    return None


@final
class RecordedObjects(Sequence[ObjectState]):
    """The states of objects at one instant, computed when they are first read.

    It never changes, and any thread may read it.
    """

    __slots__ = ("_compute", "_states")

    def __init__(self, compute: Callable[[], tuple[ObjectState, ...]]) -> None:
        """``compute`` must depend only on what was recorded at that instant."""
        self._compute = compute
        self._states: tuple[ObjectState, ...] | None = None

    @property
    def states(self) -> tuple[ObjectState, ...]:
        """The states, as a tuple."""
        if self._states is None:
            self._states = self._compute()  # two threads compute the same
        return self._states

    @overload
    def __getitem__(self, index: int) -> ObjectState: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[ObjectState, ...]: ...
    def __getitem__(self, index: int | slice) -> ObjectState | tuple[ObjectState, ...]:
        return self.states[index]

    def __len__(self) -> int:
        return len(self.states)

    def __iter__(self) -> Iterator[ObjectState]:
        return iter(self.states)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, RecordedObjects):
            other = other.states
        return self.states == other

    def __hash__(self) -> int:
        return hash(self.states)

    def __repr__(self) -> str:
        return repr(self.states)


Wrench = tuple[Vector3, Vector3]
"""A force [N] at a body's centre of mass and a torque [N·m], in the root's axes."""


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

    def object_states(self) -> Sequence[ObjectState]:
        """Return the current state of each object, spawned ones last: a record."""

    def spawn(self, item: SceneObject) -> None:
        """Add an object at rest; everything else keeps its state.

        If that fails, nothing has changed.

        Raises:
            ModelError: If the engine does not support such an object.
            EngineError: If the name is taken, or the engine refuses.
        """

    def delete(self, name: str) -> None:
        """Remove an object, or raise EngineError if there is none."""

    def place(self, state: ObjectState) -> None:
        """Set the pose and velocity of an object; the quaternion must have length one.

        A reset returns it to where it was at the start, or was spawned.

        Raises:
            EngineError: If there is none, or it has no mass and a velocity is given.
        """

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts of the last step, one per pair.

        An attachment counts as a contact.  Empty before the first step after a reset.
        An engine may start recording with the first call, which then returns none.
        """

    def is_touched(self, links: frozenset[str]) -> bool:
        """Return whether one of ``links`` touches anything, or is attached.

        Quicker than ``contacts``; True may also mean: almost.
        """

    def center_of_mass(self, name: str) -> Vector3:
        """Return where the body of a link or object has its centre of mass [m].

        In the robot's root; links that are fixed to each other are one body.

        Raises:
            EngineError: If there is no such link or object, or it cannot move.
        """

    def hold_wrenches(self, wrenches: Mapping[str, Wrench]) -> None:
        """Apply these wrenches, by link or object, from now on, and no others.

        Those on links of one body add up.  A reset removes all.

        Raises:
            EngineError: As ``center_of_mass``; then nothing has changed.
        """

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link at its current pose, until it is detached.

        No real hand does this: it is for ``--grasp-assist`` only.  Resetting, deleting
        and placing the object detach it.

        Raises:
            ModelError: If there is no such link.
            EngineError: If there is no such object, it has no mass, or it is attached
                already.
        """

    def detach(self, name: str) -> None:
        """Release an object, if it is attached."""


class Engine(Protocol):
    """Physics, as the control loop sees it: read, write, step, in that order.

    Every sequence has shape (n_joints,), ordered as ``joint_names``: all movable
    joints of the robot, including mimic joints.  ``world`` has everything else.
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
        """Put joints at ``position`` [rad | m], at rest, and objects at their start.

        Set simulated time to ``time`` [s].
        """

    def read(self) -> JointState:
        """Return the measured state: a copy, never a view into the engine.

        Raises:
            DivergenceError: If the state is not finite, or a velocity is absurd.
        """

    def write(self, effort: Sequence[float]) -> None:
        """Apply ``effort`` [N·m | N] until the next call.

        Raises:
            DivergenceError: If it is not finite.
        """

    def set_brakes(self, torques: Mapping[int, float]) -> None:
        """Engage the brakes of these joints, by number, and release all others.

        A brake is dry friction of at most that torque [N·m | N] in the joint: it slows
        the joint, and holds it at rest against any load that is smaller.  The state
        does not change, and a reset leaves the brakes as they are.
        """

    @property
    def has_rotors(self) -> bool:
        """Whether ``set_rotors`` is possible."""

    def set_rotors(self, inertias: Mapping[int, float]) -> None:
        """Add the inertia of rotors to these joints, by number, and none to others.

        It is reflected to the joint [kg·m² | kg].  The state does not change, and a
        reset leaves the rotors as they are.
        """

    def step(self) -> None:
        """Advance simulated time by ``dt``."""

    @property
    def stepper(self) -> NativeStepper | None:
        """Addresses for compiled code; None if only ``step`` steps the engine.

        Another one whenever addresses change.
        """

    def close(self) -> None:
        """End the engine and its processes; closing twice is allowed."""


class NativeStepper(NamedTuple):
    """Addresses by which compiled code steps an engine in this process.

    The joints come first in ``position`` and ``velocity``, in the engine's order.
    """

    step: int
    """Address of a C function ``void step(const void *model, void *data)``."""
    on_error: int
    """Address of the variable with the C function ``void on_error(const char *)``,
    which the engine calls on an error; 0 if there is none."""
    model: int
    data: int
    position: int
    """Address of the measured positions [rad | m]."""
    velocity: int
    """Address of the velocities, those of objects included [rad/s | m/s]."""
    n_velocities: int
    motors: int
    """Address of the efforts that the engine applies [N·m | N]."""
    motor_joints: tuple[int, ...]
    """The joint that each motor drives."""
    brakes: tuple[int, ...]
    """The joints with engaged brakes.  One that is slower than ``BRAKE_STANDSTILL``
    after a step stands: it keeps its position from before the step, with velocity 0."""
    steps: Callable[[], int]
    """Returns the steps of the engine since its time was 0."""
    note_steps: Callable[[int, list[float]], None]
    """Tells the engine the steps since its time was 0, and the last effort."""


BRAKE_STANDSTILL = 3e-4
"""Speed below which a joint with an engaged brake stands [rad/s | m/s].

Friction that a solver regularises creeps: in MuJoCo with rated payloads at 1e-4 rad/s
at most.  To move a joint that stands takes 0.3 rad/s² beyond its friction, in steps of
1 ms.
"""
LARGEST_VELOCITY = 1e4
"""Speed from which a simulation counts as diverged [rad/s | m/s].  No drive and no fall
gets near it, and growing numbers pass it some steps before infinity."""


def has_diverged(velocity: Sequence[float]) -> bool:
    """Return whether a velocity is not finite or absurd [rad/s | m/s]."""
    return not math.hypot(*velocity) < LARGEST_VELOCITY  # NaN, too


def fastest(velocity: Sequence[float]) -> int:
    """Return the number of the first velocity that is not finite, or the largest."""
    sizes = [abs(v) if math.isfinite(v) else math.inf for v in velocity]
    return sizes.index(max(sizes))


def check_dt(dt: float) -> None:
    """Raise ConfigError unless ``dt`` [s] is a valid step length."""
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
            f"there is already an object '{name}'; remove it first, or use another name"
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


def immovable(name: str) -> EngineError:
    """Return the error for a wrench on something immovable."""
    return EngineError(f"'{name}' stands still: no force moves it")


def check_placement(objects: Mapping[str, SceneObject], state: ObjectState) -> None:
    """Raise EngineError unless the object of ``state`` can have that velocity."""
    item = find_object(objects, state.name)
    if item.mass is None and any((*state.linear, *state.angular)):
        raise EngineError(
            f"object '{state.name}' has no mass and is static; "
            "place it without a velocity"
        )
