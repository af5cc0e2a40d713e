"""Base class of tasks, with functions on arrays of the state of n copies.

To define your own task, derive a class from ``Task`` (docs/how-to/gym.md) and register
it with ``tool0.gym.register``.  A *goal* is an array of shape (n, g).  The columns of
``achieved`` and ``desired`` have the same meanings.
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
"""Rate at which progress decreases with the distance from the goal [1/m]."""


class ArmState(NamedTuple):
    """Measured state of one arm and its gripper in n copies."""

    q: Array
    """Positions of the arm's joints [rad], shape (n, 6)."""
    qd: Array
    """Velocities of the joints [rad/s], shape (n, 6)."""
    tcp_position: Array
    """Position of the TCP in the root frame [m], shape (n, 3)."""
    tcp_rotation: Array
    """Rotation matrices of the TCP in the root frame, shape (n, 3, 3)."""
    opening: Array
    """Distance between the pads [m], shape (n,)."""
    opening_rate: Array
    """Mean rate of change of the opening in the last control period [m/s], shape
    (n,)."""
    opening_target: Array
    """The commanded opening [m], shape (n,)."""
    wrench: Array
    """Force [N] and torque [N·m] on the tool from ``Batch.tool_wrench``, shape (n, 6),
    or shape (n, 0) if ``Task.needs_wrench`` is False."""


class State(NamedTuple):
    """Measured state of n copies with k objects; poses are in the root frame.

    If the task has one arm, the properties describe this arm.  ``of`` selects one of
    several arms.
    """

    arms: Mapping[str, ArmState]
    """The arms by name."""
    object_position: Array
    """Positions of the objects [m], shape (n, k, 3)."""
    object_quat: Array
    """Orientations of the objects (w, x, y, z), shape (n, k, 4)."""
    object_velocity: Array
    """Linear velocities of the objects [m/s], shape (n, k, 3)."""
    object_size: Array
    """Edges of each object's bounding box, in the object's axes [m], shape (n, k, 3);
    NaN for meshes and compounds."""
    goal: Array
    """Goal that was drawn at the start of the episode, with the columns of
    ``Start.goal``."""

    def of(self, arm: str) -> State:
        """Return the same state with only one of the arms.

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
            ControlError: If there are several arms.
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
        """Velocities of the arm's joints [rad/s], shape (n, 6)."""
        return self.arm.qd

    @property
    def tcp_position(self) -> Array:
        """Position of the TCP [m], shape (n, 3)."""
        return self.arm.tcp_position

    @property
    def tcp_rotation(self) -> Array:
        """Rotation matrices of the TCP, shape (n, 3, 3)."""
        return self.arm.tcp_rotation

    @property
    def opening(self) -> Array:
        """Distance between the gripper's pads [m], shape (n,)."""
        return self.arm.opening

    @property
    def opening_rate(self) -> Array:
        """Mean rate of change of the opening in the last period [m/s], shape (n,)."""
        return self.arm.opening_rate

    @property
    def opening_target(self) -> Array:
        """The commanded opening [m], shape (n,)."""
        return self.arm.opening_target

    @property
    def wrench(self) -> Array:
        """Force [N] and torque [N·m] on the tool, shape (n, 6).

        See ``ArmState.wrench``.
        """
        return self.arm.wrench


class Start(NamedTuple):
    """Random start of an episode in one copy."""

    places: Array
    """Positions of the objects [m], shape (k, 3)."""
    yaws: Array
    """Yaws of the objects [rad], shape (k,)."""
    goal: Array
    """Goal, shape (g,), or any other shape that ``Task.desired`` converts."""
    is_held: bool = False
    """Whether the closed gripper of the first arm holds the first object in the way
    that ``Task.hold`` defines.  If true, the object's place and yaw are ignored."""


class Target(NamedTuple):
    """Next targets of an expert for the tool and gripper of n copies."""

    position: Array
    """Target position of the TCP in the root frame [m], shape (n, 3)."""
    yaw: Array
    """Target yaw of the TCP [rad], shape (n,); the tool points down."""
    opening: Array
    """Target opening of the gripper [m], shape (n,)."""
    speed: Array
    """Largest speed as a fraction of the fastest action, 0 … 1, shape (n,)."""


class Task(abc.ABC):
    """A task of one arm, or of two arms that face each other.

    The functions have no memory.  The arguments and the results of the functions are
    arrays with one row per copy.  A row of a result must not depend on the other
    copies.
    """

    instruction: str = ""
    """Description of the task as an instruction to a robot."""
    objects: tuple[str, ...] = ()
    """Names of the objects that a start places, in the order of ``State``.  Each object
    is either movable or fixed at its place."""
    goal_names: tuple[str, ...] = ()
    """Names of the columns of a goal."""
    arms: tuple[str, ...] = ()
    """Names of two arms, such as ``("left", "right")``; empty for a single arm."""
    distance_of_arms: float = 1.5
    """Distance between the bases of two arms of scale 1 [m]."""
    hold: Hold | None = None
    """The way in which the gripper holds the first object in starts with ``is_held``;
    None if the task has no such starts."""
    resizable: tuple[str, ...] = ()
    """Names of objects that ``Randomisation.size`` may resize, which must be boxes,
    cylinders or spheres with a mass.  Starts are drawn for the size in the scene.  An
    object of another size is placed with its bottom at the same height.  The functions
    read the object's actual size from the state."""
    needs_wrench: bool = False
    """Whether ``State`` and observations include the wrench on the tool."""
    worst_reward: float = -1.0
    """Reward of a copy with diverged physics."""

    def __init__(self, workspace: Workspace) -> None:
        """Prepare the task for an arm, a gripper and a matching table.

        For two arms, ``workspace`` is the workspace of the first arm.  ``workspace.of``
        returns the workspace of either arm.
        """
        self.workspace = workspace

    @abc.abstractmethod
    def scene(self) -> Scene:
        """Return the scene around the robot, including ``workspace.cameras``."""

    @abc.abstractmethod
    def draw(self, rng: np.random.Generator) -> Start:
        """Return a random start of an episode, which depends only on ``rng``."""

    @abc.abstractmethod
    def achieved(self, state: State) -> Array:
        """Return the goals that the states achieve, shape (n, g)."""

    def desired(self, state: State) -> Array:
        """Return the goals to achieve, shape (n, g) (default: the drawn goals)."""
        return state.goal

    @abc.abstractmethod
    def is_success(self, achieved: Array, desired: Array) -> Mask:
        """Return whether goals of any shape (…, g) are achieved."""

    def distance(self, achieved: Array, desired: Array) -> Array:
        """Return the distances between achieved and desired goals [m], shape (…)."""
        return length(achieved - desired)

    def progress(self, state: State) -> Array:
        """Return the progress of the task from 0 to 1, shape (n,)."""
        return nearness(self.distance(self.achieved(state), self.desired(state)))

    def reward(self, state: State, success: Mask) -> Array:
        """Return the dense rewards, (n,): the progress minus 1, or 0 on success."""
        progress = np.minimum(np.maximum(self.progress(state), 0.0), 1.0)
        return np.where(success, 0.0, progress - 1.0)

    def observe(self, state: State) -> Mapping[str, Array]:
        """Return additional parts of observations by name, shape (n,) or (n, m)."""
        return {}

    def expert(self, state: State, commanded: Frames) -> Target:
        """Return the expert's next target; ``commanded`` is the TCP's current target.

        The expert has no memory and infers the progress from the state.  The function
        is optional, but ``tool0.gym.expert`` raises an error for a task without it.
        """
        raise NotImplementedError

    def experts(
        self, state: State, commanded: Mapping[str, Frames]
    ) -> Mapping[str, Target]:
        """Return the expert's next target for each arm, by the arm's name.

        Tasks of two arms implement this function instead of ``expert``.  ``commanded``
        contains the current target of each TCP.
        """
        return {arm: self.expert(state, pose) for arm, pose in commanded.items()}


def length(vectors: Array) -> Array:
    """Return the lengths of vectors (…, k), shape (…)."""
    return np.asarray(np.sqrt(np.add.reduce(vectors * vectors, axis=-1)))


def nearness(distance: Array, rate: float = NEARNESS) -> Array:
    """Return ``1 - tanh(rate * distance)``, with ``rate`` in 1/m."""
    return np.asarray(1.0 - np.tanh(rate * distance))
