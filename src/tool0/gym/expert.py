"""Scripted experts: they solve each task from what the simulation knows.

An expert has no memory.  In each step it tells from the state how far the task is, and
where the tool and the gripper go next: it works on after a disturbance, too.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.api.table import TABLE_TOP
from tool0.description.transform_arrays import (
    Frames,
    from_quats,
    from_rotation_vectors,
    yaw_of,
)
from tool0.errors import ConfigError
from tool0.gym.copies import Copies
from tool0.gym.environments import TaskEnv, TaskVectorEnv
from tool0.gym.tasks import (
    HELD,
    Lift,
    Mask,
    PickPlace,
    Push,
    Reach,
    Stack,
    State,
    is_holding,
)
from tool0.gym.tool import chord_vectors, downward
from tool0.kinematics.chain import Array
from tool0.kinematics.geometry import wrapped

GAIN = 0.6
"""Part of the way to a target that one action goes."""
ALIGNED = 0.006
"""Largest offset of pads around a cube [m]."""
PARALLEL = 0.08
"""Largest angle between pads and the sides of a cube [rad]."""
NEAR = 2.0
"""Times the tolerances: within them an expert goes on with what it began."""
STILL = 0.004
"""Speed of pads below which they hold [m/s]."""
DROP = 0.002
"""Height above its place at which a cube is released [m]."""
PUSH_OPENING = 0.4
"""Of the gripper that pushes, part of the cube's edge: two fingers keep it straight."""
PUSH_SLOW = 0.35
"""Speed of a push, part of the fastest action."""


class Target(NamedTuple):
    """Where tool and gripper of n copies go next."""

    position: Array
    """Of the tcp in the root [m], shape (n, 3)."""
    yaw: Array
    """Of the tcp [rad], shape (n,)."""
    opening: Array
    """Of the gripper [m], shape (n,)."""
    speed: Array
    """Largest part of the fastest action, shape (n,)."""


@final
class Expert:
    """Returns an action for each observation of one environment."""

    def __init__(self, copies: Copies, *, single: bool) -> None:
        self._copies = copies
        self._single = single
        self._target = _EXPERTS[type(copies.task).__name__]

    def __call__(self, observation: object = None) -> NDArray[np.float32]:
        """Return the action, shape (m,), or those of all copies, shape (n, m).

        ``observation`` is not read: the expert sees the simulation's own state, so that
        it works with images, too.
        """
        copies = self._copies
        target = self._target(copies, copies.state)
        actions = np.empty((copies.n, len(copies.actions.names)))
        actions[:, :-1] = self._motion(target)
        widest = copies.workspace.gripper.max_opening
        actions[:, -1] = np.clip(2.0 * target.opening / widest - 1.0, -1.0, 1.0)
        found: NDArray[np.float32] = actions.astype(np.float32)
        return found[0] if self._single else found

    def _motion(self, target: Target) -> Array:
        """Return the actions of the arm, shape (n, m - 1)."""
        actions, q = self._copies.actions, self._copies.target
        pose = self._copies.workspace.tool.pose(q)
        way = GAIN * (target.position - pose.position)
        if actions.mode == "cartesian":
            turn = GAIN * wrapped(target.yaw - pose.yaw)[:, None]
        else:
            turn = GAIN * chord_vectors(pose.rotation, downward(target.yaw))
        linear = _within(way / actions.linear, target.speed)
        angular = _within(turn / actions.turn, np.ones(len(turn)))
        if actions.mode != "joint":
            return np.concatenate([linear, angular], axis=1)
        aim = Frames(
            pose.position + linear * actions.linear,
            from_rotation_vectors(angular * actions.turn) @ pose.rotation,
        )
        return _within((actions.approach(q, aim) - q) / actions.joint, np.ones(len(q)))


def expert(env: Any) -> Expert:  # Env or VectorEnv, in any wrappers
    """Return an expert for an environment of tool0, single or vector.

    Raises:
        ConfigError: If it is not one of these.
    """
    inner = getattr(env, "unwrapped", env)
    if isinstance(inner, TaskEnv | TaskVectorEnv):
        return Expert(inner.copies, single=isinstance(inner, TaskEnv))
    raise ConfigError(f"there is no expert for {env!r:.80}; make a tool0/… environment")


def _within(action: Array, largest: Array) -> Array:
    """Return actions (n, m), shortened so that no number is above ``largest``, (n,)."""
    excess = np.maximum(1.0, np.abs(action).max(axis=1) / largest)
    return np.asarray(action / excess[:, None])


def _reach(copies: Copies, state: State) -> Target:
    n = copies.n
    yaw = np.full(n, copies.workspace.start_yaw)
    return Target(state.goal, yaw, state.opening_target, np.ones(n))


def _grasp_yaw(state: State, k: int = 0) -> Array:
    """Return the yaw nearest to the tcp's at which pads touch an object's sides."""
    yaw = yaw_of(from_quats(state.object_quat[:, k]))
    present = yaw_of(state.tcp_rotation)
    quarter = np.pi / 2.0
    turn = np.remainder(yaw - present + quarter / 2.0, quarter) - quarter / 2.0
    return np.asarray(present + turn)


class _Grasp(NamedTuple):
    """How far the first object is grasped, and where to go for that."""

    target: Target
    held: Mask
    """Whether it is squeezed firmly, shape (n,)."""


def _grasp(copies: Copies, state: State) -> _Grasp:
    """Return the way to a grasp of the first object."""
    space = copies.workspace
    edge, widest = space.edge, space.gripper.max_opening
    cube, tcp = state.object_position[:, 0], state.tcp_position
    yaw = _grasp_yaw(state)
    pose = space.tool.pose(copies.target)
    grasp = cube.copy()
    grasp[:, 2] = np.maximum(
        cube[:, 2] - edge / 2.0 + space.grasp_height, TABLE_TOP + space.grasp_height
    )
    # Commanded, not measured: a step that waits for the arm to settle would oscillate.
    beside = _length(pose.position[:, :2] - cube[:, :2])
    twist = np.abs(wrapped(yaw - pose.yaw))
    is_low = pose.position[:, 2] < grasp[:, 2] + space.edge
    slack = np.where(is_low, NEAR, 1.0)
    aligned = (beside < slack * ALIGNED) & (twist < slack * PARALLEL)
    hover = TABLE_TOP + space.hover_height
    aim = grasp.copy()
    aim[:, 2] = np.where(aligned, grasp[:, 2], np.maximum(hover, cube[:, 2] + hover))
    # Straight up first, if the fingers are beside something.
    stuck = ~aligned & (tcp[:, 2] < hover - 0.02)
    aim[:, :2] = np.where(stuck[:, None], pose.position[:, :2], aim[:, :2])
    there = aligned & (_length(tcp - grasp) < ALIGNED)
    closing = state.opening_target < 0.8 * edge
    closing &= _length(tcp[:, :2] - cube[:, :2]) < HELD
    closing &= np.abs(tcp[:, 2] - grasp[:, 2]) < HELD
    missed = closing & (state.opening < 0.6 * edge)
    close = (there | closing) & ~missed
    held = closing & is_holding(state, edge) & (np.abs(state.opening_rate) < STILL)
    aim = np.where(closing[:, None], pose.position, aim)
    yaw = np.where(closing, pose.yaw, yaw)
    opening = np.where(close, 0.0, widest)
    return _Grasp(Target(aim, yaw, opening, np.ones(copies.n)), held)


def _lift(copies: Copies, state: State) -> Target:
    target, held = _grasp(copies, state)
    pose = copies.workspace.tool.pose(copies.target)
    up = pose.position.copy()
    up[:, 2] = TABLE_TOP + copies.workspace.grasp_height + copies.workspace.lift
    return target._replace(position=np.where(held[:, None], up, target.position))


def _place(copies: Copies, state: State) -> Target:
    """Return the way to carry the first object to its goal, and to release it."""
    space = copies.workspace
    edge = space.edge
    target, held = _grasp(copies, state)
    goal = copies.task.desired(state)
    cube, pose = state.object_position[:, 0], space.tool.pose(copies.target)
    in_hand = cube - state.tcp_position
    carry = TABLE_TOP + space.grasp_height + space.lift
    # The cube goes up, across, and down.
    high = pose.position[:, 2] > carry - 0.03
    off = _length(pose.position[:, :2] + in_hand[:, :2] - goal[:, :2])
    above = off < np.where(high, 0.5, NEAR) * ALIGNED
    is_across = high | above
    across = goal[:, :3] - in_hand
    across[:, 2] = np.where(above, goal[:, 2] + DROP - in_hand[:, 2], carry)
    up = pose.position.copy()
    up[:, 2] = carry
    aim = np.where(is_across[:, None], across, up)
    low = np.abs(cube[:, 2] - goal[:, 2]) < 2.0 * DROP
    placed = (_length(cube[:, :2] - goal[:, :2]) < NEAR * ALIGNED) & low
    position = np.where(held[:, None], aim, target.position)
    opening = np.where(held, 0.0, target.opening)
    # It is there: let go of it, then leave.
    gone = state.opening > edge + 0.01
    leave = np.where(gone[:, None], up, pose.position)
    position = np.where(placed[:, None], leave, position)
    opening = np.where(placed, space.gripper.max_opening, opening)
    yaw = np.where(held | placed, pose.yaw, target.yaw)
    return Target(position, yaw, opening, target.speed)


def _push(copies: Copies, state: State) -> Target:
    space = copies.workspace
    edge = space.edge
    cube, tcp = state.object_position[:, 0], state.tcp_position
    way = state.goal[:, :2] - cube[:, :2]
    along = way / np.maximum(_length(way), 1e-6)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    from_cube = tcp[:, :2] - cube[:, :2]
    behind = -(from_cube * along).sum(axis=1)
    aside = (from_cube * across).sum(axis=1)
    pose = space.tool.pose(copies.target)
    heading = np.arctan2(along[:, 1], along[:, 0])
    half = np.remainder(heading - pose.yaw + np.pi / 2.0, np.pi) - np.pi / 2.0
    yaw, twist = pose.yaw + half, np.abs(half)
    low = space.lowest + space.advance
    hover = TABLE_TOP + space.hover_height + space.advance
    clear = space.run_up
    is_low = tcp[:, 2] < low + 0.01
    slack = np.where(is_low, NEAR, 1.0)
    opening = np.full(copies.n, PUSH_OPENING * edge)
    ready = is_low | (state.opening < 1.5 * opening)
    ready &= (behind > 0.4 * edge) & (behind < clear + 0.03)
    ready &= (np.abs(aside) < slack * 0.008) & (twist < slack * 0.1)
    aim = np.empty((copies.n, 3))
    # Behind the cube, above it, until the tool can go down there.
    aim[:, :2] = cube[:, :2] - along * clear
    aim[:, 2] = np.where(ready, low, hover)
    stuck = ~ready & (tcp[:, 2] < hover - 0.015)
    aim[:, :2] = np.where(stuck[:, None], pose.position[:, :2], aim[:, :2])
    pushing = ready & is_low
    on_line = cube[:, :2] - along * behind[:, None]
    forward = on_line + along * (_length(way) + 0.02)[:, None]
    aim[:, :2] = np.where(pushing[:, None], forward, aim[:, :2])
    speed = np.where(pushing, PUSH_SLOW, 1.0)
    # A cube between the fingers is let go.
    caught = cube[:, 2] > TABLE_TOP + edge
    aim = np.where(caught[:, None], pose.position, aim)
    opening = np.where(caught, space.gripper.max_opening, opening)
    return Target(aim, yaw, opening, speed)


def _length(vectors: Array) -> Array:
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=-1)))


_EXPERTS: dict[str, Callable[[Copies, State], Target]] = {
    Reach.__name__: _reach,
    Lift.__name__: _lift,
    PickPlace.__name__: _place,
    Stack.__name__: _place,
    Push.__name__: _push,
}
