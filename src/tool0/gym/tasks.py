"""The five tasks: what is on the table, where it starts, and when it is done.

A task is a table of pure functions of the state of n copies.  A *goal* is an array of
shape (n, k); ``achieved`` and ``desired`` have the same meaning, column by column.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol, final

import numpy as np
from numpy.typing import NDArray

from tool0.api.table import BIN_HALF_WIDTH, TABLE_TOP
from tool0.description.scene import DEFAULT_WALL, Scene
from tool0.errors import ConfigError, did_you_mean
from tool0.gym.workspace import ATTEMPTS, Workspace
from tool0.kinematics.chain import Array

Mask = NDArray[np.bool_]

CUBE, LOWER = "cube", "lower_cube"
REACHED = 0.02
"""Largest distance of a tcp that has reached its goal [m]."""
LIFTED = 0.08
"""Height from which a cube is lifted [m]."""
PUSHED = 0.03
"""Largest distance of a cube that is pushed to its goal [m]."""
ON_LOWER = 0.4
"""Largest offset of a cube that stands on another, part of its edge."""
LEVEL = 0.006
"""Largest error of the height of a cube at rest [m]."""
RELEASED = 0.006
"""Least opening beyond a cube's edge that has released it [m]."""
APART = 0.13
"""Least distance of two cubes at the start: the open gripper fits between [m]."""
SLIDING = 0.4
"""Friction coefficient of a cube to push: with 1, one that is pushed tips over."""
PUSH_WAY = (0.08, 0.20)
"""Range of the way to push, for an arm of scale 1 [m]."""
HELD = 0.025
"""Largest distance from the tcp of a cube that is held [m]."""


class State(NamedTuple):
    """What is measured in n copies; k movable objects.  Poses are in the root."""

    q: Array
    """Positions of the arm's joints [rad], shape (n, 6)."""
    qd: Array
    """Their velocities [rad/s], shape (n, 6)."""
    tcp_position: Array
    """[m], shape (n, 3)."""
    tcp_rotation: Array
    """Rotation matrices, shape (n, 3, 3)."""
    opening: Array
    """Distance between the pads [m], shape (n,)."""
    opening_rate: Array
    """Its mean change in the last control period [m/s], shape (n,)."""
    opening_target: Array
    """The commanded opening [m], shape (n,)."""
    object_position: Array
    """[m], shape (n, k, 3)."""
    object_quat: Array
    """w, x, y, z, shape (n, k, 4)."""
    object_velocity: Array
    """[m/s], shape (n, k, 3)."""
    goal: Array
    """What was drawn at the start of the episode, shape (n, g)."""


class Start(NamedTuple):
    """What is drawn at the start of an episode of one copy."""

    places: Array
    """Positions of the movable objects [m], shape (k, 3)."""
    yaws: Array
    """Their turns about z [rad], shape (k,)."""
    goal: Array
    """Shape (g,)."""


class Task(Protocol):
    """One task in one workspace."""

    @property
    def instruction(self) -> str:
        """What is to be done, as one says it to a robot."""

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the movable objects."""

    @property
    def goal_names(self) -> tuple[str, ...]:
        """What the columns of a goal are."""

    def scene(self) -> Scene:
        """Return what is around the robot."""

    def draw(self, rng: np.random.Generator) -> Start:
        """Return a random start."""

    def achieved(self, state: State) -> Array:
        """Return the goals that the states achieve."""

    def desired(self, state: State) -> Array:
        """Return the goals that they are to achieve."""

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        """Return whether goals are achieved, of any shape (…, g)."""

    def distance(self, achieved: Array, desired: Array) -> Array:
        """Return how far goals are from being achieved [m], shape (…)."""

    def progress(self, state: State) -> Array:
        """Return how far the task is done, 0 … 1, shape (n,)."""


@final
class Reach:
    """Move the tcp to a point."""

    instruction = "Move the tool to the goal."
    objects: tuple[str, ...] = ()
    goal_names = ("x", "y", "z")

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        low, high = workspace.area()
        scale = workspace.scale
        rest = TABLE_TOP + workspace.grasp_height
        self._low = np.array([low[0], low[1] - 0.2 * scale, rest + 0.05])
        self._high = np.array([*high, rest + 0.05 + 0.3 * scale])

    def scene(self) -> Scene:
        return self._workspace.scene(())

    def draw(self, rng: np.random.Generator) -> Start:
        goal = self._workspace.draw_place(rng, self._low, self._high)
        return Start(np.empty((0, 3)), np.empty(0), goal)

    def achieved(self, state: State) -> Array:
        return state.tcp_position

    def desired(self, state: State) -> Array:
        return state.goal

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return self.distance(achieved, desired) < REACHED

    def distance(self, achieved: Array, desired: Array) -> Array:
        return _distance(achieved, desired)

    def progress(self, state: State) -> Array:
        return _nearness(_distance(state.tcp_position, state.goal), 5.0)


@final
class Lift:
    """Grasp a cube and lift it."""

    instruction = "Lift the cube."
    objects = (CUBE,)
    goal_names = ("height",)

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self._rest = TABLE_TOP + workspace.edge / 2.0

    def scene(self) -> Scene:
        return self._workspace.scene(self.objects)

    def draw(self, rng: np.random.Generator) -> Start:
        places = _draw_on_table(self._workspace, rng, 1)
        return Start(places, _yaws(rng, 1), np.array([LIFTED]))

    def achieved(self, state: State) -> Array:
        return state.object_position[:, 0, 2:] - self._rest

    def desired(self, state: State) -> Array:
        return state.goal

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return self.distance(achieved, desired) <= 0.0

    def distance(self, achieved: Array, desired: Array) -> Array:
        return np.asarray(np.maximum(0.0, desired - achieved)[..., 0])

    def progress(self, state: State) -> Array:
        lifted = np.clip(self.achieved(state)[:, 0] / LIFTED, 0.0, 1.0)
        return _grasping(state, self._workspace.edge, 0.3, 0.2) + 0.5 * lifted


@final
class PickPlace:
    """Place a cube in a bin, and release it."""

    instruction = "Put the cube into the bin."
    objects = (CUBE,)
    goal_names = ("x", "y", "z", "released")

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        x, y, z = workspace.bin_centre
        self._goal = np.array([x, y, z + DEFAULT_WALL + workspace.edge / 2.0, 1.0])
        self._room = BIN_HALF_WIDTH - DEFAULT_WALL - 0.4 * workspace.edge
        """Largest offset of a cube in the bin from its middle, in x and y [m]."""

    def scene(self) -> Scene:
        return self._workspace.scene(self.objects, with_bin=True)

    def draw(self, rng: np.random.Generator) -> Start:
        places = _draw_on_table(self._workspace, rng, 1, beside_bin=True)
        return Start(places, _yaws(rng, 1), self._goal)

    def achieved(self, state: State) -> Array:
        return _place_and_release(state, self._workspace.edge)

    def desired(self, state: State) -> Array:
        return state.goal

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        offset = np.abs(achieved - desired)
        is_inside = (offset[..., :2] < self._room).all(axis=-1)
        # A cube that leans on a wall is in the bin, too.
        is_down = achieved[..., 2] - desired[..., 2] < self._workspace.edge / 2.0
        return is_inside & is_down & _same(achieved, desired)

    def distance(self, achieved: Array, desired: Array) -> Array:
        return _distance(achieved[..., :3], desired[..., :3])

    def progress(self, state: State) -> Array:
        return _carrying(state, self._workspace, state.goal)


@final
class Stack:
    """Place a cube on another one, and release it."""

    instruction = "Stack the cube on the other cube."
    objects = (CUBE, LOWER)
    goal_names = ("x", "y", "z", "released")

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace

    def scene(self) -> Scene:
        return self._workspace.scene(self.objects)

    def draw(self, rng: np.random.Generator) -> Start:
        def are_apart(places: Array) -> bool:
            return math.dist(*places) >= APART

        places = _draw_on_table(self._workspace, rng, 2, are_apart)
        return Start(places, _yaws(rng, 2), np.empty(0))

    def achieved(self, state: State) -> Array:
        return _place_and_release(state, self._workspace.edge)

    def desired(self, state: State) -> Array:
        goal = np.ones((len(state.q), 4))
        goal[:, :3] = state.object_position[:, 1]
        goal[:, 2] += self._workspace.edge
        return goal

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        offset = achieved - desired
        is_above = _norm(offset[..., :2]) < ON_LOWER * self._workspace.edge
        is_level = np.abs(offset[..., 2]) < LEVEL
        return is_above & is_level & _same(achieved, desired)

    def distance(self, achieved: Array, desired: Array) -> Array:
        return _distance(achieved[..., :3], desired[..., :3])

    def progress(self, state: State) -> Array:
        return _carrying(state, self._workspace, self.desired(state))


@final
class Push:
    """Push a cube to a place on the table."""

    instruction = "Push the cube to the goal."
    objects = (CUBE,)
    goal_names = ("x", "y", "z")

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace

    def scene(self) -> Scene:
        return self._workspace.scene(self.objects, friction=SLIDING)

    def draw(self, rng: np.random.Generator) -> Start:
        space = self._workspace
        low, high = space.area()
        shortest, longest = (way * space.scale for way in PUSH_WAY)
        shortest = max(shortest, 2.0 * PUSHED)

        def can_push(places: Array) -> bool:
            place, goal = places
            way = math.dist(place, goal)
            if not shortest <= way <= longest:
                return False
            behind = place + (place - goal) * space.run_up / way
            return bool(((low <= behind) & (behind <= high)).all())

        place, goal = _draw_on_table(space, rng, 2, can_push)
        return Start(place[None], _yaws(rng, 1), goal)

    def achieved(self, state: State) -> Array:
        return state.object_position[:, 0]

    def desired(self, state: State) -> Array:
        return state.goal

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return self.distance(achieved, desired) < PUSHED

    def distance(self, achieved: Array, desired: Array) -> Array:
        return _distance(achieved, desired)

    def progress(self, state: State) -> Array:
        near = _nearness(
            _distance(state.tcp_position, state.object_position[:, 0]), 5.0
        )
        done = _nearness(_distance(state.object_position[:, 0], state.goal), 5.0)
        return 0.3 * near + 0.7 * done


TASKS: dict[str, type[Reach | Lift | PickPlace | Stack | Push]] = {
    "Reach": Reach,
    "Lift": Lift,
    "PickPlace": PickPlace,
    "Stack": Stack,
    "Push": Push,
}
EPISODE_STEPS = {"Reach": 100, "Lift": 200, "PickPlace": 300, "Stack": 300, "Push": 300}
"""Time limit of each task, in actions."""


def make_task(name: str, workspace: Workspace) -> Task:
    """Return a task by name, or raise ConfigError."""
    if name not in TASKS:
        raise ConfigError(f"unknown task '{name}'{did_you_mean(name, TASKS)}")
    task: Task = TASKS[name](workspace)
    return task


def is_holding(state: State, edge: float) -> Mask:
    """Return whether the pads squeeze the first object, shape (n,)."""
    near = _distance(state.tcp_position, state.object_position[:, 0]) < HELD
    is_stopped = np.abs(state.opening - edge) < 0.2 * edge
    return near & is_stopped & (state.opening_target < 0.8 * edge)


def _draw_on_table(
    workspace: Workspace,
    rng: np.random.Generator,
    n: int,
    fits: Callable[[Array], bool] = lambda places: True,
    *,
    beside_bin: bool = False,
) -> Array:
    """Return random places of n cubes on the table [m], shape (n, 3).

    The arm can lift cubes there, and the places (n, 2) are such that they fit.
    """
    low, high = workspace.area(beside_bin=beside_bin)
    for _ in range(ATTEMPTS):
        places = rng.uniform(low, high, (n, 2))
        if fits(places) and all(map(workspace.can_lift, places)):
            break
    height = np.full((n, 1), TABLE_TOP + workspace.edge / 2.0)
    return np.concatenate([places, height], axis=1)


def _yaws(rng: np.random.Generator, n: int) -> Array:
    return rng.uniform(-np.pi, np.pi, n)


def _norm(vectors: Array) -> Array:
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=-1)))


def _distance(first: Array, second: Array) -> Array:
    return _norm(first - second)


def _nearness(distance: Array, rate: float) -> Array:
    """Return 1 at no distance, falling with ``rate`` [1/m]."""
    return np.asarray(1.0 - np.tanh(rate * distance))


def _place_and_release(state: State, edge: float) -> Array:
    """Return where the first object is, and 1 if the pads are wider, (n, 4)."""
    released = state.opening > edge + RELEASED
    return np.concatenate([state.object_position[:, 0], released[:, None]], axis=1)


def _same(achieved: Array, desired: Array) -> Mask:
    """Return whether what is to be released is released."""
    return np.asarray(achieved[..., 3] >= desired[..., 3])


def _grasping(state: State, edge: float, near: float, held: float) -> Array:
    """Return the part of the progress up to a grasp."""
    away = _distance(state.tcp_position, state.object_position[:, 0])
    return np.asarray(near * _nearness(away, 5.0) + held * is_holding(state, edge))


def _carrying(state: State, workspace: Workspace, goal: Array) -> Array:
    """Return the progress of carrying the first object to a goal."""
    position = state.object_position[:, 0]
    beside = _norm(position[:, :2] - goal[:, :2])
    height = position[:, 2] - TABLE_TOP - workspace.edge / 2.0
    raised = np.clip(height / LIFTED, 0.0, 1.0)
    raised[beside < workspace.edge] = 1.0
    return np.asarray(
        _grasping(state, workspace.edge, 0.2, 0.2)
        + 0.2 * raised
        + 0.2 * raised * _nearness(beside, 3.0)
        + 0.2 * _nearness(_distance(position, goal[:, :3]), 5.0)
    )
