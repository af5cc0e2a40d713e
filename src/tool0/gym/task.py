"""A task: functions of the state of n copies, with arrays over all of them.

Subclass ``Task`` for a task of your own (docs/how-to/gym.md), and register it by
``tool0.gym.register``.  A *goal* is an array of shape (n, g); ``achieved`` and
``desired`` have the same meaning, column by column.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tool0.description.scene import Scene
from tool0.description.transform_arrays import Frames
from tool0.errors import ControlError, did_you_mean
from tool0.gym.hold import Hold
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

Mask = NDArray[np.bool_]

NEARNESS = 5.0
"""Rate at which progress falls with the distance from the goal [1/m]."""


class ArmState(NamedTuple):
    """Measured state of one arm and its gripper in n copies, in the root."""

    q: Array
    """Positions of the arm's joints [rad], shape (n, 6)."""
    qd: Array
    """Velocities of the joints [rad/s], shape (n, 6)."""
    tcp_position: Array
    """Position of the tcp [m], shape (n, 3)."""
    tcp_rotation: Array
    """Rotation matrices of the tcp, shape (n, 3, 3)."""
    opening: Array
    """Distance between the pads [m], shape (n,)."""
    opening_rate: Array
    """Mean change of the opening in the last control period [m/s], shape (n,)."""
    opening_target: Array
    """The commanded opening [m], shape (n,)."""
    wrench: Array
    """Force [N] and torque [N·m] on the tool, as ``Batch.tool_wrench``, shape (n, 6);
    (n, 0) without ``Task.needs_wrench``."""


class State(NamedTuple):
    """Measured state of n copies with k objects.  Poses are in the root.

    The properties are those of the arm, if the task has one arm; ``of`` chooses one of
    several arms.
    """

    arms: Mapping[str, ArmState]
    """The arms by name."""
    object_position: Array
    """Positions of the objects [m], shape (n, k, 3)."""
    object_quat: Array
    """Orientations of the objects w, x, y, z, shape (n, k, 4)."""
    object_velocity: Array
    """Linear velocities of the objects [m/s], shape (n, k, 3)."""
    object_size: Array
    """Edges of the box around each object, in its axes [m], shape (n, k, 3); NaN for
    meshes and compounds."""
    goal: Array
    """Goal drawn at the start of the episode, as wide as ``Start.goal``."""

    def of(self, arm: str) -> State:
        """Return the state with one of the arms, and everything else.

        Raises:
            ControlError: If there is no such arm.
        """
        if arm not in self.arms:
            raise ControlError(f"no arm '{arm}'{did_you_mean(arm, self.arms)}")
        return self._replace(arms={arm: self.arms[arm]})

    @property
    def arm(self) -> ArmState:
        """The only arm.

        Raises:
            ControlError: If there are several.
        """
        if len(self.arms) > 1:
            raise ControlError(
                f"this state has several arms: {', '.join(self.arms)}; choose one, as "
                f"state.of('{next(iter(self.arms))}')"
            )
        return next(iter(self.arms.values()))

    @property
    def q(self) -> Array:
        """Positions of the arm's joints [rad], shape (n, 6)."""
        return self.arm.q

    @property
    def qd(self) -> Array:
        """Their velocities [rad/s], shape (n, 6)."""
        return self.arm.qd

    @property
    def tcp_position(self) -> Array:
        """Position of the tcp [m], shape (n, 3)."""
        return self.arm.tcp_position

    @property
    def tcp_rotation(self) -> Array:
        """Rotation matrices, shape (n, 3, 3)."""
        return self.arm.tcp_rotation

    @property
    def opening(self) -> Array:
        """Distance between the pads [m], shape (n,)."""
        return self.arm.opening

    @property
    def opening_rate(self) -> Array:
        """Its mean change in the last control period [m/s], shape (n,)."""
        return self.arm.opening_rate

    @property
    def opening_target(self) -> Array:
        """The commanded opening [m], shape (n,)."""
        return self.arm.opening_target

    @property
    def wrench(self) -> Array:
        """Force [N] and torque [N·m] on the tool, as in ``ArmState``, shape (n, 6)."""
        return self.arm.wrench


class Start(NamedTuple):
    """Random start of an episode of one copy."""

    places: Array
    """Positions of the objects [m], shape (k, 3)."""
    yaws: Array
    """Turns of the objects about z [rad], shape (k,)."""
    goal: Array
    """Goal, shape (g,); any other shape if ``Task.desired`` converts it."""
    is_held: bool = False
    """Whether the closed gripper of the first arm holds the first object, as given by
    ``Task.hold``.  The object's place and yaw are then ignored."""


class Target(NamedTuple):
    """Next target of the tool and gripper of n copies, from an expert."""

    position: Array
    """Target position of the tcp in the root [m], shape (n, 3)."""
    yaw: Array
    """Target yaw of the tcp, which looks down [rad], shape (n,)."""
    opening: Array
    """Target opening of the gripper [m], shape (n,)."""
    speed: Array
    """Largest part of the fastest action, 0 … 1, shape (n,)."""


class Task(abc.ABC):
    """A task of one arm, or of two that face each other.

    Its functions have no memory and get arrays over all copies; what they return has
    one row per copy, which depends on no other copy.
    """

    instruction: str = ""
    """Description of the task, as given to a robot."""
    objects: tuple[str, ...] = ()
    """Names of the objects that a start places, in the order of ``State``: movable, or
    fixed where they are placed."""
    goal_names: tuple[str, ...] = ()
    """Names of the columns of a goal."""
    arms: tuple[str, ...] = ()
    """Names of two arms, such as ``("left", "right")``; none for a single arm."""
    distance_of_arms: float = 1.5
    """Distance between the bases of two arms of scale 1 [m]."""
    hold: Hold | None = None
    """Hold of the first object by a start's gripper; a task without such starts needs
    none."""
    resizable: tuple[str, ...] = ()
    """Objects whose size ``Randomisation.size`` may change: boxes, cylinders or spheres
    with a mass.  Starts are drawn for the size in the scene; an object of another size
    has its bottom where that one would.  The functions find the size in the state."""
    needs_wrench: bool = False
    """Whether ``State`` and observations have the wrench on the tool."""
    worst_reward: float = -1.0
    """Reward of a copy whose physics diverged."""

    def __init__(self, workspace: Workspace) -> None:
        """Prepare the task for an arm, a gripper, and the table that fits them.

        Of two arms, it is the workspace of the first; ``workspace.of`` has both.
        """
        self.workspace = workspace

    @abc.abstractmethod
    def scene(self) -> Scene:
        """Return what is around the robot, ``workspace.cameras`` among it."""

    @abc.abstractmethod
    def draw(self, rng: np.random.Generator) -> Start:
        """Return the random start of an episode, from ``rng`` alone."""

    @abc.abstractmethod
    def achieved(self, state: State) -> Array:
        """Return the goals that the states achieve, shape (n, g)."""

    def desired(self, state: State) -> Array:
        """Return the goals to achieve, shape (n, g): those that were drawn."""
        return state.goal

    @abc.abstractmethod
    def is_success(self, achieved: Array, desired: Array) -> Mask:
        """Return whether goals are achieved, of any shape (…, g)."""

    def distance(self, achieved: Array, desired: Array) -> Array:
        """Return how far goals are from being achieved [m], shape (…)."""
        return length(achieved - desired)

    def progress(self, state: State) -> Array:
        """Return how far the task is done, 0 … 1, shape (n,)."""
        return nearness(self.distance(self.achieved(state), self.desired(state)))

    def reward(self, state: State, success: Mask) -> Array:
        """Return the dense rewards, shape (n,): progress - 1, and 0 with success."""
        progress = np.minimum(np.maximum(self.progress(state), 0.0), 1.0)
        return np.where(success, 0.0, progress - 1.0)

    def observe(self, state: State) -> Mapping[str, Array]:
        """Return further parts of observations by name, shapes (n,) or (n, m)."""
        return {}

    def expert(self, state: State, commanded: Frames) -> Target:
        """Return where to go next; ``commanded`` is the tcp's target now.

        It has no memory, and tells from the state how far the task is.  A task needs
        none; ``tool0.gym.expert`` says so then.
        """
        raise NotImplementedError

    def experts(
        self, state: State, commanded: Mapping[str, Frames]
    ) -> Mapping[str, Target]:
        """Return where each arm goes next, by its name.

        A task of two arms has this instead of ``expert``.  ``commanded`` has the target
        of each tcp now.
        """
        return {arm: self.expert(state, pose) for arm, pose in commanded.items()}


def length(vectors: Array) -> Array:
    """Return the lengths of vectors (…, k), shape (…)."""
    return np.asarray(np.sqrt(np.add.reduce(vectors * vectors, axis=-1)))


def nearness(distance: Array, rate: float = NEARNESS) -> Array:
    """Return 1 at no distance, falling to 0 with ``rate`` [1/m]."""
    return np.asarray(1.0 - np.tanh(rate * distance))
