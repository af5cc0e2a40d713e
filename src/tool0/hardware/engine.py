"""The interface of physics engines, and checks that are common to all engines."""

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

    Lists have shape (n_joints,), ordered as the engine's ``joint_names``.  This is a
    named tuple of plain lists because the tick creates one a thousand times a second,
    and plain floats are fastest in Python.
    """

    time: float
    """Simulated time [s]."""
    position: list[float]
    """Positions [rad], or [m] for a prismatic joint."""
    velocity: list[float]
    """Velocities [rad/s], or [m/s] for a prismatic joint."""
    effort: list[float]
    """Most recently applied efforts [N·m], or [N] for a prismatic joint."""


JointSelector = Callable[[list[float]], Sequence[float]]
"""Selects some joints from a list of all joints."""


def joint_selector(indices: Sequence[int]) -> JointSelector:
    """Return the function that selects ``indices`` from a list.

    The function runs in C; it is a slice if the joints are contiguous, as usual.
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
    """The states of objects at one instant, computed upon the first read.

    The result never changes, and any thread may read it.
    """

    __slots__ = ("_compute", "_states")

    def __init__(self, compute: Callable[[], tuple[ObjectState, ...]]) -> None:
        """``compute`` must depend only on data recorded at that instant."""
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
"""Force [N] at a body's centre of mass, and torque [N·m], in the root's axes."""


class World(Protocol):
    """The objects around the robot: state, spawning, attachments and contacts.

    An engine has a single world for its whole lifetime.  Only the thread that owns the
    tick may use the world.
    """

    @property
    def gravity(self) -> Vector3:
        """Acceleration of free fall [m/s²], in the axes of the robot's root."""

    @property
    def ground(self) -> float | None:
        """Height of the ground in the robot's root [m]; None if unknown."""

    def object_states(self) -> Sequence[ObjectState]:
        """Return a record of the current state of each object, spawned objects last."""

    def spawn(self, item: SceneObject) -> None:
        """Add an object at rest without changing the state of anything else.

        Nothing has changed if this fails.

        Raises:
            ModelError: If the engine does not support such an object.
            EngineError: If the name is taken, or the engine refuses.
        """

    def delete(self, name: str) -> None:
        """Remove an object, or raise EngineError if there is no such object."""

    def place(self, state: ObjectState) -> None:
        """Set the pose and velocity of an object; the quaternion must be normalised.

        A reset returns the object to its pose at the start, or where it was spawned.

        Raises:
            EngineError: If there is no such object, or a velocity is given for an
                object without mass.
        """

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts of the last step, one per pair of bodies.

        An attachment counts as a contact.  The result is empty before the first step
        after a reset.  An engine may start recording contacts upon the first call,
        whose result is then empty.
        """

    def is_touched(self, links: frozenset[str]) -> bool:
        """Return whether one of ``links`` touches anything, or is attached.

        Faster than ``contacts``; may also return True for links that only almost touch.
        """

    def center_of_mass(self, name: str) -> Vector3:
        """Return the centre of mass of the body of a link or object [m].

        It is in the robot's root.  Links that are fixed to each other are one body.

        Raises:
            EngineError: If there is no such link or object, or if it cannot move.
        """

    def hold_wrenches(self, wrenches: Mapping[str, Wrench]) -> None:
        """Replace all applied wrenches by these, by link or object.

        Wrenches on links of the same body add up.  A reset removes all wrenches.

        Raises:
            EngineError: As for ``center_of_mass``; nothing has changed then.
        """

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link at its current pose, until it is detached.

        This is not physical, and only for ``--grasp-assist``.  Resetting, deleting or
        placing the object detaches it.

        Raises:
            ModelError: If there is no such link.
            EngineError: If there is no such object, it has no mass, or it is already
                attached.
        """

    def detach(self, name: str) -> None:
        """Release an object, if it is attached."""


class Engine(Protocol):
    """Physics engine, as the control loop uses it: read, write and step, in this order.

    Every sequence has shape (n_joints,), ordered as ``joint_names``, which has all
    movable joints of the robot, including mimic joints.  ``world`` has everything else.
    """

    @property
    def name(self) -> str:
        """Name under which the engine is registered: ``mujoco`` or ``gazebo``."""

    @property
    def joint_names(self) -> tuple[str, ...]: ...

    @property
    def dt(self) -> float:
        """Length of one step [s]."""

    @property
    def world(self) -> World:
        """The objects around the robot."""

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        """Reset joints to ``position`` [rad | m], at rest, and objects to their start.

        Set simulated time to ``time`` [s].
        """

    def read(self) -> JointState:
        """Return a copy of the measured state, never a view into the engine.

        Raises:
            DivergenceError: If the state is not finite, or a velocity is absurd.
        """

    def write(self, effort: Sequence[float]) -> None:
        """Apply ``effort`` [N·m | N] until the next call.

        Raises:
            DivergenceError: If an effort is not finite.
        """

    def set_brakes(self, torques: Mapping[int, float]) -> None:
        """Engage the brakes of these joints, by number, and release all others.

        A brake acts as dry friction of at most this torque [N·m | N]: it slows the
        joint, and holds it at rest against any smaller load.  The joint's state does
        not change, and a reset does not affect the brakes.
        """

    @property
    def has_rotors(self) -> bool:
        """Whether the engine supports ``set_rotors``."""

    def set_rotors(self, inertias: Mapping[int, float]) -> None:
        """Set the added rotor inertia of these joints, by number; others get none.

        The inertia is reflected to the joint [kg·m² | kg].  The joint's state does not
        change, and a reset does not affect the rotors.
        """

    def step(self) -> None:
        """Advance simulated time by ``dt``."""

    @property
    def stepper(self) -> NativeStepper | None:
        """Addresses for compiled code; None if only ``step`` can step the engine.

        It is a new object whenever addresses change.
        """

    def close(self) -> None:
        """End the engine and its processes; closing twice is allowed."""


class NativeStepper(NamedTuple):
    """Addresses with which compiled code steps an engine in this process.

    The joints come first in ``position`` and ``velocity``, in the engine's order.
    """

    step: int
    """Address of a C function ``void step(const void *model, void *data)``."""
    on_error: int
    """Address of the variable that holds the C function ``void on_error(const char
    *)``, which the engine calls on an error; 0 if there is no such variable."""
    clock: int
    """Address of the variable that holds the C function ``double clock(void)``, with
    which the engine times its parts; 0 if there is no such variable.  It returns 0
    while compiled code steps the engine, which takes less time."""
    model: int
    data: int
    position: int
    """Address of the measured positions [rad | m]."""
    velocity: int
    """Address of the velocities, including those of objects [rad/s | m/s]."""
    n_velocities: int
    motors: int
    """Address of the efforts that the engine applies [N·m | N]."""
    motor_joints: tuple[int, ...]
    """The joint that each motor drives."""
    brakes: tuple[int, ...]
    """The joints with engaged brakes.  A joint that is slower than ``BRAKE_STANDSTILL``
    after a step is at rest: it keeps its position from before the step, with velocity
    0."""
    steps: Callable[[], int]
    """Returns the number of steps of the engine since its time was 0."""
    note_steps: Callable[[int, list[float]], None]
    """Tells the engine the number of steps since its time was 0, and the last
    efforts."""


BRAKE_STANDSTILL = 3e-4
"""Speed below which a joint with an engaged brake is at rest [rad/s | m/s].

Friction that a solver regularises creeps; in MuJoCo with rated payloads, at no more
than 1e-4 rad/s.  With steps of 1 ms, moving a joint from rest takes 0.3 rad/s² beyond
its friction.
"""
LARGEST_VELOCITY = 1e4
"""Speed above which a simulation counts as diverged [rad/s | m/s].  Drives and falling
objects stay far below it, and diverging values pass it some steps before they become
infinite."""


def has_diverged(velocity: Sequence[float]) -> bool:
    """Return whether a velocity is not finite, or absurdly large [rad/s | m/s]."""
    return not math.hypot(*velocity) < LARGEST_VELOCITY  # NaN, too


def fastest(velocity: Sequence[float]) -> int:
    """Return the index of the first non-finite velocity, or else of the largest."""
    sizes = [abs(v) if math.isfinite(v) else math.inf for v in velocity]
    return sizes.index(max(sizes))


def check_dt(dt: float) -> None:
    """Raise ConfigError unless ``dt`` [s] is a valid step length."""
    if not 0.0 < dt < math.inf:
        raise ConfigError(f"the step must be above 0 s and finite, got {dt}")


def effort_divergence(
    joint_names: Sequence[str], effort: Sequence[float], time: float
) -> DivergenceError:
    """Return the error for efforts with a non-finite sum [N·m | N]."""
    worst = next((i for i, u in enumerate(effort) if not math.isfinite(u)), 0)
    return DivergenceError(joint_names[worst], time, "effort")


def check_new_name(objects: Mapping[str, SceneObject], name: str) -> None:
    """Raise EngineError if an object ``name`` already exists."""
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
    """Raise EngineError unless the object ``name`` exists and can move."""
    if find_object(objects, name).mass is None:
        raise EngineError(
            f"object '{name}' has no mass and is static; only a movable object can be "
            "attached"
        )


def immovable(name: str) -> EngineError:
    """Return the error for a wrench on something immovable."""
    return EngineError(f"'{name}' is fixed: forces do not move it")


def check_placement(objects: Mapping[str, SceneObject], state: ObjectState) -> None:
    """Raise EngineError unless the object of ``state`` can have that velocity."""
    item = find_object(objects, state.name)
    if item.mass is None and any((*state.linear, *state.angular)):
        raise EngineError(
            f"object '{state.name}' has no mass and is static; "
            "place it without a velocity"
        )
