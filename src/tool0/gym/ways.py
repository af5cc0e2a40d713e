"""Next targets of experts: to grasp, lift, place or push an object.

The functions have no memory and infer the progress from the state, so they can recover
from disturbances.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tool0.api.table import TABLE_TOP
from tool0.description.transform_arrays import Frames, yaw_of
from tool0.gym.hold import Cube, Hold
from tool0.gym.task import Mask, State, Target, length
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array
from tool0.kinematics.geometry import wrapped

HELD = 0.025
"""Largest distance between the TCP and the grasp point of a held object [m]."""
ALIGNED = 0.006
"""Largest offset between the pads and the object for closing the pads [m]."""
PARALLEL = 0.08
"""Largest angle between the pads and the sides of a cube for closing the pads [rad]."""
NEAR = 2.0
"""Factor by which the tolerances increase while an expert continues an action."""
STILL = 0.004
"""Largest speed of pads that hold an object [m/s]."""
DROP = 0.002
"""Height above the goal to which an object is lowered before its release [m]."""
FINE, FINE_GAIN = 0.003, 0.3
"""Distance to the target below which a held object is moved more slowly [m], and
fraction of the remaining distance that is commanded per step."""
BEGUN = 0.0003
"""Smallest commanded downward motion of an object that is being lowered [m]."""
PUSH_OPENING = 0.4
"""Opening of the gripper during a push, as a fraction of the cube's edge.  Two separate
fingers prevent the cube from turning."""
PUSH_SLOW = 0.35
"""Speed of a push, as a fraction of the fastest action."""


def is_holding(state: State, hold: Hold) -> Mask:
    """Return whether the pads squeeze the first object, shape (n,)."""
    near = length(state.tcp_position - _hold_place(state, hold)) < HELD
    is_stopped = np.abs(state.opening - hold.width) < 0.2 * hold.width
    return near & is_stopped & (state.opening_target < 0.8 * hold.width)


def _hold_place(state: State, hold: Hold) -> Array:
    return hold.places(state.object_position[:, 0], state.object_quat[:, 0])


def reach(space: Workspace, state: State) -> Target:
    """Return the next target on the way to a goal that is a point."""
    n = len(state.q)
    yaw = np.full(n, space.start_yaw)
    return Target(state.goal, yaw, state.opening_target, np.ones(n))


class Grasp(NamedTuple):
    """Progress of grasping the first object, and the next target of the grasp."""

    target: Target
    held: Mask
    """Whether the pads hold the first object firmly, shape (n,)."""


def grasp(
    space: Workspace,
    state: State,
    commanded: Frames,
    hold: Hold | None = None,
    yaw: Array | None = None,
) -> Grasp:
    """Return the next target on the way to grasping the first object.

    Args:
        space: Arm and gripper.
        state: The measured state.
        commanded: The current target of the TCP.
        hold: The way in which to hold the object (default: the way to hold a cube).
        yaw: Yaw of the TCP [rad], shape (n,) (default: the nearest yaw at which the
            pads fit).
    """
    cube = Cube.of(space, state.object_size)
    hold = hold or cube.hold
    if yaw is None:
        yaw = yaw_of(state.tcp_rotation)
        yaw = yaw + hold.turn(yaw, state.object_quat[:, 0])
    width, tcp = hold.width, state.tcp_position
    middle = _hold_place(state, hold)
    middle[:, 2] = np.maximum(middle[:, 2], space.lowest)
    # The commanded position is used, because waiting for the measured position to
    # settle would cause oscillations.
    beside = length(commanded.position[:, :2] - middle[:, :2])
    twist = np.abs(wrapped(yaw - commanded.yaw))
    is_low = commanded.position[:, 2] < middle[:, 2] + cube.edge
    slack = np.where(is_low, NEAR, 1.0)
    aligned = (beside < slack * ALIGNED) & (twist < slack * PARALLEL)
    hover = TABLE_TOP + space.hover_height if hold.hover is None else hold.hover
    over = hover + np.maximum(0.0, middle[:, 2] - TABLE_TOP - cube.edge)
    aim = middle.copy()
    aim[:, 2] = np.where(aligned, middle[:, 2], over)
    # Low fingers that are not aligned may be next to an object, so they first rise
    # vertically.
    stuck = ~aligned & (tcp[:, 2] < hover - 0.02)
    aim[:, :2] = np.where(stuck[:, None], commanded.position[:, :2], aim[:, :2])
    there = aligned & (length(tcp - middle) < ALIGNED)
    closing = state.opening_target < 0.8 * width
    closing &= length(tcp[:, :2] - middle[:, :2]) < HELD
    closing &= np.abs(tcp[:, 2] - middle[:, 2]) < HELD
    missed = closing & (state.opening < 0.6 * width)
    close = (there | closing) & ~missed
    held = closing & is_holding(state, hold) & (np.abs(state.opening_rate) < STILL)
    aim = np.where(closing[:, None], commanded.position, aim)
    yaw = np.where(closing, commanded.yaw, yaw)
    widest = space.gripper.max_opening if hold.opening is None else hold.opening
    opening = np.where(close, 0.0, widest)
    return Grasp(Target(aim, yaw, opening, np.ones(len(state.q))), held)


def carried(
    state: State, commanded: Frames, point: Array, place: Array, turn: Array
) -> Array:
    """Return TCP positions [m], (n, 3), that move a point of a held object to a place.

    The positions are in the root frame and account for the position of the object in
    the gripper.  The motion is slow in the last millimeters, because the object swings
    a little when the arm moves.

    Args:
        state: The measured state.
        commanded: The current target of the TCP.
        point: The point in the root frame [m], shape (n, 3).
        place: Target of the point in the root frame [m], shape (n, 3).
        turn: Rotation of the TCP about z during the motion [rad], shape (n,).
    """
    c, s = np.cos(turn), np.sin(turn)
    x, y, z = (point - state.tcp_position).T
    aim = place - np.stack([c * x - s * y, s * x + c * y, z], axis=1)
    left = aim[:, :2] - commanded.position[:, :2]
    part = np.where(length(left) < FINE, FINE_GAIN, 1.0)
    aim[:, :2] = commanded.position[:, :2] + part[:, None] * left
    return np.asarray(aim)


def is_sent_below(state: State, commanded: Frames, point: Array, height: float) -> Mask:
    """Return whether a point of a held object is commanded below a height, (n,).

    The function uses the commanded position instead of the measured position, so that
    it detects when an expert has begun to lower the object.  ``point`` is in the root
    frame [m], shape (n, 3).
    """
    ahead = commanded.position[:, 2] - state.tcp_position[:, 2]
    return np.asarray(point[:, 2] + ahead < height - BEGUN)


def lift(
    space: Workspace,
    state: State,
    commanded: Frames,
    hold: Hold | None = None,
    yaw: Array | None = None,
) -> Target:
    """Return the next target to grasp and lift the first object; see ``grasp``."""
    target, held = grasp(space, state, commanded, hold, yaw)
    up = commanded.position.copy()
    cube = Cube.of(space, state.object_size)
    up[:, 2] = TABLE_TOP + cube.grasp_height + space.lift
    return target._replace(position=np.where(held[:, None], up, target.position))


def place(space: Workspace, state: State, commanded: Frames, goal: Array) -> Target:
    """Return the next target to carry the first object to its goal and release it."""
    edge, grasp_height = Cube.of(space, state.object_size)
    target, held = grasp(space, state, commanded)
    cube = state.object_position[:, 0]
    in_hand = cube - state.tcp_position
    carry = TABLE_TOP + grasp_height + space.lift
    # The cube is moved up, horizontally and then down.
    high = commanded.position[:, 2] > carry - 0.03
    off = length(commanded.position[:, :2] + in_hand[:, :2] - goal[:, :2])
    above = off < np.where(high, 0.5, NEAR) * ALIGNED
    is_across = high | above
    across = goal[:, :3] - in_hand
    across[:, 2] = np.where(above, goal[:, 2] + DROP - in_hand[:, 2], carry)
    up = commanded.position.copy()
    up[:, 2] = carry
    aim = np.where(is_across[:, None], across, up)
    low = np.abs(cube[:, 2] - goal[:, 2]) < 2.0 * DROP
    placed = (length(cube[:, :2] - goal[:, :2]) < NEAR * ALIGNED) & low
    position = np.where(held[:, None], aim, target.position)
    opening = np.where(held, 0.0, target.opening)
    # When the cube is in place, the gripper opens and the arm retreats.
    gone = state.opening > edge + 0.01
    leave = np.where(gone[:, None], up, commanded.position)
    position = np.where(placed[:, None], leave, position)
    opening = np.where(placed, space.gripper.max_opening, opening)
    yaw = np.where(held | placed, commanded.yaw, target.yaw)
    return Target(position, yaw, opening, target.speed)


def push(space: Workspace, state: State, commanded: Frames) -> Target:
    """Return the next target to push the first object to the goal on the table."""
    edge, _ = Cube.of(space, state.object_size)
    cube, tcp = state.object_position[:, 0], state.tcp_position
    way = state.goal[:, :2] - cube[:, :2]
    along = way / np.maximum(length(way), 1e-6)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    from_cube = tcp[:, :2] - cube[:, :2]
    behind = -(from_cube * along).sum(axis=1)
    aside = (from_cube * across).sum(axis=1)
    heading = np.arctan2(along[:, 1], along[:, 0])
    half = np.remainder(heading - commanded.yaw + np.pi / 2.0, np.pi) - np.pi / 2.0
    yaw, twist = commanded.yaw + half, np.abs(half)
    low = space.lowest + space.advance
    hover = TABLE_TOP + space.hover_height + space.advance
    clear = space.run_up
    is_low = tcp[:, 2] < low + 0.01
    slack = np.where(is_low, NEAR, 1.0)
    opening = np.full(len(state.q), PUSH_OPENING * edge)
    ready = is_low | (state.opening < 1.5 * opening)
    ready &= (behind > 0.4 * edge) & (behind < clear + 0.03)
    ready &= (np.abs(aside) < slack * 0.008) & (twist < slack * 0.1)
    aim = np.empty((len(state.q), 3))
    # The tool stays above the place behind the cube until it can move down there.
    aim[:, :2] = cube[:, :2] - along * clear
    aim[:, 2] = np.where(ready, low, hover)
    stuck = ~ready & (tcp[:, 2] < hover - 0.015)
    aim[:, :2] = np.where(stuck[:, None], commanded.position[:, :2], aim[:, :2])
    pushing = ready & is_low
    on_line = cube[:, :2] - along * behind[:, None]
    forward = on_line + along * (length(way) + 0.02)[:, None]
    aim[:, :2] = np.where(pushing[:, None], forward, aim[:, :2])
    speed = np.where(pushing, PUSH_SLOW, 1.0)
    # A cube between the fingers is released.
    caught = cube[:, 2] > TABLE_TOP + edge
    aim = np.where(caught[:, None], commanded.position, aim)
    opening = np.where(caught, space.gripper.max_opening, opening)
    return Target(aim, yaw, opening, speed)
