"""Scenes, starts and conditions of success of the tasks with cubes."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from tool0.api.table import BIN_HALF_WIDTH, TABLE_TOP
from tool0.description.scene import DEFAULT_WALL, Scene
from tool0.description.transform_arrays import Frames
from tool0.gym.hold import Cube
from tool0.gym.task import Mask, Start, State, Target, Task, length, nearness
from tool0.gym.ways import is_holding, lift, place, push, reach
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

CUBE, LOWER = "cube", "lower_cube"
REACHED = 0.02
"""Distance within which a TCP is considered to have reached the goal [m]."""
LIFTED = 0.08
"""Minimum height of a lifted cube above its initial height [m]."""
PUSHED = 0.03
"""Distance within which a pushed cube is considered to have reached the goal [m]."""
ON_LOWER = 0.4
"""Largest horizontal offset of a stacked cube, as a fraction of the smallest cube's
edge."""
LEVEL = 0.006
"""Largest height error of a cube at rest [m]."""
RELEASED = 0.006
"""The cube is released when the gripper's opening exceeds the cube's edge by more than
this length [m]."""
APART = 0.13
"""Minimum distance between two cubes at the start [m].  The open gripper fits between
cubes at this distance."""
SLIDING = 0.4
"""Friction coefficient of a cube that is pushed.  With a coefficient of 1, the cube
would tip over."""
PUSH_WAY = (0.08, 0.20)
"""Range of the distance between the cube and the goal of a push, for an arm of scale 1
[m]."""


@final
class Reach(Task):
    """Task of moving the TCP to a point."""

    instruction = "Move the tool to the goal."
    goal_names = ("x", "y", "z")

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        low, high = workspace.area()
        scale = workspace.scale
        rest = TABLE_TOP + workspace.grasp_height
        self._low = np.array([low[0], low[1] - 0.2 * scale, rest + 0.05])
        self._high = np.array([*high, rest + 0.05 + 0.3 * scale])

    def scene(self) -> Scene:
        return self.workspace.scene(())

    def draw(self, rng: np.random.Generator) -> Start:
        goal = self.workspace.draw_place(rng, self._low, self._high)
        return Start(np.empty((0, 3)), np.empty(0), goal)

    def achieved(self, state: State) -> Array:
        return state.tcp_position

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return self.distance(achieved, desired) < REACHED

    def expert(self, state: State, commanded: Frames) -> Target:
        return reach(self.workspace, state)


@final
class Lift(Task):
    """Task of grasping a cube and lifting it."""

    instruction = "Lift the cube."
    objects = (CUBE,)
    goal_names = ("height",)
    resizable = objects

    def scene(self) -> Scene:
        return self.workspace.scene(self.objects)

    def draw(self, rng: np.random.Generator) -> Start:
        places = self.workspace.draw_on_table(rng, 1)
        return Start(places, _yaws(rng, 1), np.array([LIFTED]))

    def achieved(self, state: State) -> Array:
        edge, _ = Cube.of(self.workspace, state.object_size)
        rest = np.reshape(TABLE_TOP + edge / 2.0, (-1, 1))
        return np.asarray(state.object_position[:, 0, 2:] - rest)

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return self.distance(achieved, desired) <= 0.0

    def distance(self, achieved: Array, desired: Array) -> Array:
        return np.asarray(np.maximum(0.0, desired - achieved)[..., 0])

    def progress(self, state: State) -> Array:
        lifted = np.minimum(np.maximum(self.achieved(state)[:, 0] / LIFTED, 0.0), 1.0)
        return _grasping(state, self.workspace, 0.3, 0.2) + 0.5 * lifted

    def expert(self, state: State, commanded: Frames) -> Target:
        return lift(self.workspace, state, commanded)


@final
class PickPlace(Task):
    """Task of placing a cube in a bin and releasing it."""

    instruction = "Put the cube into the bin."
    objects = (CUBE,)
    goal_names = ("x", "y", "z", "released")
    resizable = objects

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        x, y, z = workspace.bin_centre
        self._goal = np.array([x, y, z + DEFAULT_WALL + workspace.edge / 2.0, 1.0])
        self._room = BIN_HALF_WIDTH - DEFAULT_WALL - 0.4 * workspace.edges[0]
        """Largest offset of a cube in the bin from the bin's center, along x and y
        [m]."""

    def scene(self) -> Scene:
        return self.workspace.scene(self.objects, with_bin=True)

    def draw(self, rng: np.random.Generator) -> Start:
        places = self.workspace.draw_on_table(rng, 1, beside_bin=True)
        return Start(places, _yaws(rng, 1), self._goal)

    def achieved(self, state: State) -> Array:
        return _place_and_release(state, self.workspace)

    def desired(self, state: State) -> Array:
        return _raised(state, self.workspace)

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        offset = np.abs(achieved - desired)
        is_inside = (offset[..., :2] < self._room).all(axis=-1)
        # A cube that leans on a wall is also in the bin.
        is_down = achieved[..., 2] - desired[..., 2] < self.workspace.edges[1] / 2.0
        return is_inside & is_down & _same(achieved, desired)

    def distance(self, achieved: Array, desired: Array) -> Array:
        return _distance(achieved[..., :3], desired[..., :3])

    def progress(self, state: State) -> Array:
        return _carrying(state, self.workspace, self.desired(state))

    def expert(self, state: State, commanded: Frames) -> Target:
        return place(self.workspace, state, commanded, self.desired(state))


@final
class Stack(Task):
    """Task of placing a cube on another cube and releasing it."""

    instruction = "Stack the cube on the other cube."
    objects = (CUBE, LOWER)
    goal_names = ("x", "y", "z", "released")
    resizable = objects

    def scene(self) -> Scene:
        return self.workspace.scene(self.objects)

    def draw(self, rng: np.random.Generator) -> Start:
        space = self.workspace
        least = APART + 0.71 * (space.edges[1] - space.edge)

        def are_apart(places: Array) -> bool:
            return math.dist(*places) >= least

        places = space.draw_on_table(rng, 2, are_apart)
        return Start(places, _yaws(rng, 2), np.empty(0))

    def achieved(self, state: State) -> Array:
        return _place_and_release(state, self.workspace)

    def desired(self, state: State) -> Array:
        edge, lower = (Cube.of(self.workspace, state.object_size, k)[0] for k in (0, 1))
        goal = np.ones((len(state.q), 4))
        goal[:, :3] = state.object_position[:, 1]
        goal[:, 2] += (edge + lower) / 2.0
        return goal

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        offset = achieved - desired
        is_above = length(offset[..., :2]) < ON_LOWER * self.workspace.edges[0]
        is_level = np.abs(offset[..., 2]) < LEVEL
        return is_above & is_level & _same(achieved, desired)

    def distance(self, achieved: Array, desired: Array) -> Array:
        return _distance(achieved[..., :3], desired[..., :3])

    def progress(self, state: State) -> Array:
        return _carrying(state, self.workspace, self.desired(state))

    def expert(self, state: State, commanded: Frames) -> Target:
        return place(self.workspace, state, commanded, self.desired(state))


@final
class Push(Task):
    """Task of pushing a cube to a place on the table."""

    instruction = "Push the cube to the goal."
    objects = (CUBE,)
    goal_names = ("x", "y", "z")
    resizable = objects

    def scene(self) -> Scene:
        return self.workspace.scene(self.objects, friction=SLIDING)

    def draw(self, rng: np.random.Generator) -> Start:
        space = self.workspace
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

        place, goal = space.draw_on_table(rng, 2, can_push)
        return Start(place[None], _yaws(rng, 1), goal)

    def achieved(self, state: State) -> Array:
        return state.object_position[:, 0]

    def desired(self, state: State) -> Array:
        return _raised(state, self.workspace)

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return self.distance(achieved, desired) < PUSHED

    def progress(self, state: State) -> Array:
        near = nearness(_distance(state.tcp_position, state.object_position[:, 0]), 5.0)
        done = nearness(_distance(state.object_position[:, 0], state.goal), 5.0)
        return 0.3 * near + 0.7 * done

    def expert(self, state: State, commanded: Frames) -> Target:
        return push(self.workspace, state, commanded)


def _yaws(rng: np.random.Generator, n: int) -> Array:
    return rng.uniform(-np.pi, np.pi, n)


def _distance(first: Array, second: Array) -> Array:
    return length(first - second)


def _raised(state: State, space: Workspace) -> Array:
    """Return the drawn goals, with heights corrected for cubes of random size."""
    if not space.has_sizes:
        return state.goal
    goal = state.goal.copy()
    goal[:, 2] += (state.object_size[:, 0, 2] - space.edge) / 2.0
    return goal


def _place_and_release(state: State, space: Workspace) -> Array:
    """Return the first object's position [m] and 1 if it is released, (n, 4)."""
    edge, _ = Cube.of(space, state.object_size)
    released = state.opening > edge + RELEASED
    return np.concatenate([state.object_position[:, 0], released[:, None]], axis=1)


def _same(achieved: Array, desired: Array) -> Mask:
    """Return whether the object is released or the goal requires no release."""
    return np.asarray(achieved[..., 3] >= desired[..., 3])


def _grasping(state: State, space: Workspace, near: float, held: float) -> Array:
    """Return the progress of reaching and grasping the first object."""
    away = _distance(state.tcp_position, state.object_position[:, 0])
    is_held = is_holding(state, Cube.of(space, state.object_size).hold)
    return np.asarray(near * nearness(away, 5.0) + held * is_held)


def _carrying(state: State, workspace: Workspace, goal: Array) -> Array:
    """Return the progress of carrying the first object to a goal."""
    edge, _ = Cube.of(workspace, state.object_size)
    position = state.object_position[:, 0]
    beside = length(position[:, :2] - goal[:, :2])
    height = position[:, 2] - TABLE_TOP - edge / 2.0
    raised = np.clip(height / LIFTED, 0.0, 1.0)
    raised[beside < edge] = 1.0
    return np.asarray(
        _grasping(state, workspace, 0.2, 0.2)
        + 0.2 * raised
        + 0.2 * raised * nearness(beside, 3.0)
        + 0.2 * nearness(_distance(position, goal[:, :3]), 5.0)
    )
