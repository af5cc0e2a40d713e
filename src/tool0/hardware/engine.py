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
    """Measured state of all movable joints at one instant.

    The lists have shape (n_joints,) and are in the order of the engine's
    ``joint_names``.  This class is a named tuple of plain lists, because the tick
    creates an instance a thousand times a second, and plain floats are fastest in
    Python.
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
"""Function that selects the values of some joints from a list for all joints."""


def joint_selector(indices: Sequence[int]) -> JointSelector:
    """Return the function that selects ``indices`` from a list.

    The function runs in C.  The function takes a slice if the indices are contiguous,
    which is the usual case.
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
    """The states of objects at one instant, which are computed on the first read.

    The states never change, and any thread may read them.
    """

    __slots__ = ("_compute", "_states")

    def __init__(self, compute: Callable[[], tuple[ObjectState, ...]]) -> None:
        """Prepare a record of the states that ``compute`` returns.

        ``compute`` must depend only on data recorded at that instant.
        """
        self._compute = compute
        self._states: tuple[ObjectState, ...] | None = None

    @property
    def states(self) -> tuple[ObjectState, ...]:
        """The states as a tuple."""
        if self._states is None:
            self._states = self._compute()  # two threads compute the same value
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
"""Force [N] at a body's center of mass and torque [N·m], in the axes of the robot's
root."""


class World(Protocol):
    """The objects around the robot: their states, spawning, attachments and contacts.

    An engine has a single world for its whole lifetime.  Only the thread that owns the
    tick may use the world.
    """

    @property
    def gravity(self) -> Vector3:
        """Acceleration of free fall [m/s²], in the axes of the robot's root."""

    @property
    def ground(self) -> float | None:
        """Height of the ground in the root's frame [m]; None if it is unknown."""

    def object_states(self) -> Sequence[ObjectState]:
        """Return a record of the current state of each object.

        Spawned objects are last.
        """

    def spawn(self, item: SceneObject) -> None:
        """Add an object at rest without changing the state of any other object.

        If the call fails, the world is unchanged.

        Raises:
            ModelError: If the engine does not support objects of this kind.
            EngineError: If the name is taken, or if the engine refuses the object.
        """

    def delete(self, name: str) -> None:
        """Remove the object named ``name``, or raise EngineError if there is none."""

    def place(self, state: ObjectState) -> None:
        """Set the pose and velocity of an object; the quaternion must be normalized.

        A reset returns the object to its pose at the start of the simulation, or to the
        pose where it was spawned.

        Raises:
            EngineError: If there is no object of this name, or if a velocity is given
                for an object without mass.
        """

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts of the last step, one for each pair of bodies in contact.

        An attachment is reported as a contact.  The result is empty before the first
        step after a reset.  An engine may start to record contacts only when this
        method is called for the first time; the result of that call is then empty.
        """

    def is_touched(self, links: frozenset[str]) -> bool:
        """Return whether one of ``links`` touches anything or is attached to an object.

        This method is faster than ``contacts``.  The result may also be True for links
        that nearly touch another body.
        """

    def center_of_mass(self, name: str) -> Vector3:
        """Return the center of mass of the body that contains a link or object [m].

        The point is given in the frame of the robot's root.  Links that are fixed to
        each other form one body.

        Raises:
            EngineError: If there is no link or object of this name, or if the link or
                object cannot move.
        """

    def hold_wrenches(self, wrenches: Mapping[str, Wrench]) -> None:
        """Replace all applied wrenches with ``wrenches``, given by link or object.

        Wrenches on links of the same body are added.  A reset removes all wrenches.

        Raises:
            EngineError: If ``center_of_mass`` raises an error for one of the links or
                objects.  The applied wrenches are then unchanged.
        """

    def attach(self, name: str, link: str) -> None:
        """Fix a movable object to a link at its current pose, until it is detached.

        An attachment is not physical; it is used only for ``--grasp-assist``.
        Resetting, deleting or placing the object detaches it.

        Raises:
            ModelError: If the robot has no link of this name.
            EngineError: If there is no object of this name, if the object has no mass,
                or if the object is already attached.
        """

    def detach(self, name: str) -> None:
        """Release an object if it is attached."""


class Engine(Protocol):
    """Interface through which the control loop uses a physics engine.

    The loop reads, writes and steps, in this order.

    Every sequence has shape (n_joints,) and is in the order of ``joint_names``, which
    contains all movable joints of the robot, including mimic joints.  ``world``
    contains the objects.
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
        """Reset joints to rest at ``position`` [rad | m], and objects to start poses.

        Set simulated time to ``time`` [s].
        """

    def read(self) -> JointState:
        """Return a copy of the measured state.

        The copy never refers to the engine's memory.

        Raises:
            DivergenceError: If the state is not finite, or if a velocity is absurdly
                large.
        """

    def write(self, effort: Sequence[float]) -> None:
        """Apply ``effort`` [N·m | N] until the next call.

        Raises:
            DivergenceError: If an effort is not finite.
        """

    def set_brakes(self, torques: Mapping[int, float]) -> None:
        """Engage the brakes of the given joints, and release all other brakes.

        ``torques`` maps the index of a joint to the largest torque of its brake
        [N·m | N].  A brake acts as dry friction of at most its largest torque.  The
        brake slows the joint, and holds it at rest against any smaller load.  This call
        does not change the state of a joint, and a reset does not affect the brakes.
        """

    @property
    def has_rotors(self) -> bool:
        """Whether the engine supports ``set_rotors``."""

    def set_rotors(self, inertias: Mapping[int, float]) -> None:
        """Set the rotor inertia of the given joints, by index; other joints have none.

        The inertia is reflected to the joint [kg·m² | kg], and it is added to the
        joint's own inertia.  This call does not change the state of a joint, and a
        reset does not affect the rotors.
        """

    def step(self) -> None:
        """Advance simulated time by ``dt``."""

    @property
    def stepper(self) -> NativeStepper | None:
        """Addresses for compiled code; None if only ``step`` can step the engine.

        The result is a new object whenever an address has changed.
        """

    def close(self) -> None:
        """Shut down the engine and its processes.  A second call has no effect."""


class NativeStepper(NamedTuple):
    """Addresses with which compiled code steps an engine in the same process.

    In ``position`` and ``velocity``, the joints come first, in the engine's order.
    """

    step: int
    """Address of a C function ``void step(const void *model, void *data)``."""
    on_error: int
    """Address of the variable that holds the C function ``void on_error(const char
    *)``.  The engine calls this function when an error occurs.  The address is 0 if the
    engine has no variable for this function."""
    clock: int
    """Address of the variable that holds the C function ``double clock(void)``, with
    which the engine times the parts of a step.  Compiled code that steps the engine
    replaces this function with a function that returns 0.  The address is 0 if the
    engine has no variable for this function."""
    model: int
    data: int
    position: int
    """Address of the measured positions [rad | m]."""
    velocity: int
    """Address of the velocities, including the velocities of objects [rad/s | m/s]."""
    n_velocities: int
    motors: int
    """Address of the efforts that the engine applies [N·m | N]."""
    motor_joints: tuple[int, ...]
    """Index of the joint that each motor drives."""
    brakes: tuple[int, ...]
    """Indices of the joints with engaged brakes.  A joint that is slower than
    ``BRAKE_STANDSTILL`` after a step is at rest: it keeps its position from before the
    step, and its velocity is 0."""
    steps: Callable[[], int]
    """Function that returns the number of engine steps since the engine's time was
    0."""
    note_steps: Callable[[int, list[float]], None]
    """Function that sets the number of steps since the engine's time was 0, and the
    last efforts."""


BRAKE_STANDSTILL = 3e-4
"""Speed below which a joint with an engaged brake is considered to be at rest
[rad/s | m/s].

A solver regularizes friction, so that a braked joint creeps.  In MuJoCo with rated
payloads, the speed of a braked joint is at most 1e-4 rad/s.  With steps of 1 ms, a
joint starts to move from rest only if the load beyond its friction accelerates it by
0.3 rad/s² or more.
"""
LARGEST_VELOCITY = 1e4
"""Speed above which a simulation is considered to have diverged [rad/s | m/s].  Drives
and falling objects remain far below this speed.  Diverging values exceed this speed
some steps before they become infinite."""


def has_diverged(velocity: Sequence[float]) -> bool:
    """Return whether a velocity is not finite or is absurdly large [rad/s | m/s]."""
    return not math.hypot(*velocity) < LARGEST_VELOCITY  # also true for NaN


def fastest(velocity: Sequence[float]) -> int:
    """Return the index of a non-finite velocity, if any, or of the largest velocity."""
    sizes = [abs(v) if math.isfinite(v) else math.inf for v in velocity]
    return sizes.index(max(sizes))


def check_dt(dt: float) -> None:
    """Raise ConfigError unless ``dt`` [s] is a valid step length."""
    if not 0.0 < dt < math.inf:
        raise ConfigError(f"the step must be above 0 s and finite, got {dt}")


def effort_divergence(
    joint_names: Sequence[str], effort: Sequence[float], time: float
) -> DivergenceError:
    """Return the exception for efforts whose sum is not finite [N·m | N]."""
    worst = next((i for i, u in enumerate(effort) if not math.isfinite(u)), 0)
    return DivergenceError(joint_names[worst], time, "effort")


def check_new_name(objects: Mapping[str, SceneObject], name: str) -> None:
    """Raise EngineError if an object named ``name`` already exists."""
    if name in objects:
        raise EngineError(
            f"there is already an object '{name}'; remove it first, or use another name"
        )


def find_object(objects: Mapping[str, SceneObject], name: str) -> SceneObject:
    """Return the object named ``name``, or raise EngineError if there is none."""
    if name not in objects:
        hint = did_you_mean(name, set(objects))
        raise EngineError(f"there is no object '{name}'{hint}")
    return objects[name]


def check_attachable(objects: Mapping[str, SceneObject], name: str) -> None:
    """Raise EngineError unless the object named ``name`` exists and can move."""
    if find_object(objects, name).mass is None:
        raise EngineError(
            f"object '{name}' has no mass and is static; only a movable object can be "
            "attached"
        )


def immovable(name: str) -> EngineError:
    """Return the exception for a wrench on a link or object that cannot move."""
    return EngineError(f"'{name}' is fixed: forces do not move it")


def check_placement(objects: Mapping[str, SceneObject], state: ObjectState) -> None:
    """Raise EngineError if ``state`` gives a velocity to an object without mass."""
    item = find_object(objects, state.name)
    if item.mass is None and any((*state.linear, *state.angular)):
        raise EngineError(
            f"object '{state.name}' has no mass and is static; "
            "place it without a velocity"
        )
