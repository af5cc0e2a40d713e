"""Insert a square peg from the gripper into a hole with 0.5 mm of clearance."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np

from tool0.api.table import TABLE_TOP
from tool0.description.scene import PALETTE, Scene, SceneObject
from tool0.description.shapes import Box, Compound
from tool0.description.transform import Pose
from tool0.description.transform_arrays import Frames, from_quats, yaw_of, yaws_of_quats
from tool0.gym.hold import Hold, folded
from tool0.gym.task import Mask, Start, State, Target, Task, length, nearness
from tool0.gym.ways import carried, grasp, is_holding, is_sent_below
from tool0.gym.workspace import FIXTURE_RGBA, Workspace
from tool0.kinematics.chain import Array

PEG, SOCKET = "peg", "socket"
PEG_WIDTH, PEG_LENGTH, PEG_MASS = 0.025, 0.1, 0.1
"""Width [m], length [m] and mass [kg] of the peg."""
CLEARANCE = 0.0005
"""Excess of the hole's width over the peg's width [m]."""
OUTER, HEIGHT = 0.085, 0.04
"""Width and height of the socket, which has a hole that is open at the bottom [m]."""
SLIDING = 0.3
"""Friction coefficient of the socket, similar to that of polished steel."""
HELD_AT = 0.025
"""Height of the TCP above the peg's middle [m]."""
DEPTH = 0.025
"""Minimum depth of an inserted peg [m]."""
INSIDE = 0.002
"""Horizontal offset of a peg's end from the hole up to which the peg is considered to
be inside [m]."""
FAR_ABOVE, ABOVE = 0.02, 0.004
"""Heights of the peg's end above the socket: far from the hole, and above it [m]."""
BEGUN = 0.002
"""The peg is entering the hole if its end is less than this height above the socket
[m]."""
CENTRED, STRAIGHT = 0.00015, 0.006
"""Largest offset [m] and angle [rad] of the peg for lowering it."""
SWING = 5.0
"""Factor by which CENTRED and STRAIGHT increase while the peg is lowered."""
DOWN = 0.05
"""Speed while the peg is lowered, as a fraction of the fastest action."""


@final
class PegInsertion(Task):
    """Task of inserting the peg that the gripper holds into a fixed socket."""

    instruction = "Insert the peg into the hole."
    objects = (PEG, SOCKET)
    goal_names = ("x", "y", "z")
    hold = Hold(PEG_WIDTH, (0.0, 0.0, HELD_AT))
    needs_wrench = True

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._top = TABLE_TOP + HEIGHT

    def scene(self) -> Scene:
        table = self.workspace.scene(())
        low, high = self.workspace.area()
        aside = (float(low[0]), float(high[1]))
        peg = SceneObject(
            name=PEG,
            geometry=Box(size=(PEG_WIDTH, PEG_WIDTH, PEG_LENGTH)),
            pose=Pose(xyz=(*aside, TABLE_TOP + PEG_LENGTH / 2.0)),
            mass=PEG_MASS,
            rgba=PALETTE[1],
        )
        socket = SceneObject(
            name=SOCKET,
            geometry=frame(PEG_WIDTH + CLEARANCE, OUTER, HEIGHT),
            pose=Pose(xyz=(float(low[0]), float(low[1]), TABLE_TOP + HEIGHT / 2.0)),
            friction=SLIDING,
            rgba=FIXTURE_RGBA,
        )
        return replace(table, objects=(*table.objects, peg, socket))

    def draw(self, rng: np.random.Generator) -> Start:
        space = self.workspace
        place = space.draw_on_table(rng, 1)[0]
        places = np.array([space.start_position, [*place[:2], self._top - HEIGHT / 2]])
        goal = np.array([*place[:2], self._top - DEPTH])
        yaws = np.array([0.0, rng.uniform(-np.pi, np.pi)])
        return Start(places, yaws, goal, is_held=True)

    def achieved(self, state: State) -> Array:
        down = from_quats(state.object_quat[:, 0])[:, :, 2] * PEG_LENGTH / 2.0
        return np.asarray(state.object_position[:, 0] - down)

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        offset = achieved - desired
        is_inside = length(offset[..., :2]) < INSIDE
        return np.asarray(is_inside & (offset[..., 2] <= 0.0))

    def progress(self, state: State) -> Array:
        end, goal = self.achieved(state), state.goal
        away = goal + np.array([0.0, 0.0, DEPTH]) - end
        depth = np.clip((self._top - end[:, 2]) / DEPTH, 0.0, 1.0)
        depth[length(away[:, :2]) > INSIDE] = 0.0
        held = is_holding(state, self.hold)
        return np.asarray(0.2 * held + 0.3 * nearness(length(away), 10.0) + 0.5 * depth)

    def expert(self, state: State, commanded: Frames) -> Target:
        target, held = grasp(self.workspace, state, commanded, self.hold)
        end, hole = self.achieved(state), state.goal[:, :2]
        peg = yaws_of_quats(state.object_quat[:, 0])
        turn = folded(yaws_of_quats(state.object_quat[:, 1]) - peg, 4)
        off = length(end[:, :2] - hole)
        # The peg swings when the arm starts to move down.
        down = is_sent_below(state, commanded, end, self._top + ABOVE)
        slack = np.where(down, SWING, 1.0)
        is_centred = (off < slack * CENTRED) & (np.abs(turn) < slack * STRAIGHT)
        # A peg that touches the rim or is in the hole continues to be lowered.
        is_begun = (end[:, 2] < self._top + BEGUN) & (off < INSIDE)
        is_ready = is_begun | is_centred
        is_far = ~is_begun & (off > 0.02)
        height = np.where(is_far, FAR_ABOVE, np.where(is_ready, -DEPTH - 0.005, ABOVE))
        low = end[:, 2] < self._top + ABOVE / 2.0
        # A low peg far from the hole is first raised vertically.
        place = np.column_stack([hole, self._top + height])
        place[low & is_far, :2] = end[low & is_far, :2]
        position = carried(state, commanded, end, place, turn)
        yaw = yaw_of(state.tcp_rotation) + turn
        speed = np.where(is_ready, DOWN, 1.0)
        return Target(
            np.where(held[:, None], position, target.position),
            np.where(held, yaw, target.yaw),
            np.where(held, 0.0, target.opening),
            np.where(held, speed, target.speed),
        )


def frame(inner: float, outer: float, height: float) -> Compound:
    """Return a square block with a square through-hole, made of four boxes [m]."""
    wall = (outer - inner) / 2.0
    away = (inner + wall) / 2.0
    long, short = Box(size=(wall, outer, height)), Box(size=(inner, wall, height))
    return Compound(
        parts=(
            (long, Pose(xyz=(away, 0.0, 0.0))),
            (long, Pose(xyz=(-away, 0.0, 0.0))),
            (short, Pose(xyz=(0.0, away, 0.0))),
            (short, Pose(xyz=(0.0, -away, 0.0))),
        )
    )
