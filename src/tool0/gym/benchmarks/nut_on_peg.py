"""Put a square nut with a handle over a square peg, and release it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import final

import numpy as np

from tool0.api.table import TABLE_TOP
from tool0.description.scene import PALETTE, Scene, SceneObject
from tool0.description.shapes import Box, Compound
from tool0.description.transform import Pose
from tool0.description.transform_arrays import Frames, yaw_of, yaws_of_quats
from tool0.gym.benchmarks.peg_insertion import frame
from tool0.gym.hold import Hold, folded
from tool0.gym.task import Mask, Start, State, Target, Task, length, nearness
from tool0.gym.ways import DROP, carried, grasp, is_holding, is_sent_below
from tool0.gym.workspace import FIXTURE_RGBA, Workspace
from tool0.kinematics.chain import Array

NUT, PEG = "nut", "peg"
INNER, OUTER, THICKNESS, NUT_MASS = 0.03, 0.06, 0.025, 0.1
"""Hole width, outer width and thickness of the nut [m], and its mass [kg]."""
HANDLE_LENGTH, HANDLE_WIDTH = 0.06, 0.022
"""Length of the handle along the nut's x axis, and its width [m]."""
HELD_AT = 0.07
"""Distance from the nut's center, along the handle, at which the gripper holds it
[m]."""
PEG_WIDTH, PEG_HEIGHT = 0.024, 0.08
"""Width and height of the peg [m]."""
APART = 0.17
"""Minimum distance between the nut and the peg at the start [m]."""
AROUND, LEVEL, RELEASED = 0.006, 0.006, 0.006
"""Largest horizontal offset and largest height error of a nut on the peg, and smallest
clearance between the pads and the handle of a released nut [m]."""
RAISED, LOW = 0.015, 0.002
"""Height above the peg at which the nut is carried, and minimum height above the peg
for moving it horizontally [m]."""
OVER, STRAIGHT = 0.001, 0.03
"""Largest offset [m] and angle [rad] of the nut for lowering it over the peg."""
SWING = 3.0
"""Factor by which OVER and STRAIGHT increase while the nut is lowered."""
DOWN = 0.25
"""Speed near the peg, as a fraction of the fastest action."""


@final
class NutOnPeg(Task):
    """Task of putting a nut with a handle over a fixed peg, and releasing it."""

    instruction = "Put the nut over the peg."
    objects = (NUT, PEG)
    goal_names = ("x", "y", "z", "released")

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._rest = TABLE_TOP + THICKNESS / 2.0
        low = workspace.lowest + workspace.advance - self._rest
        self._hold = Hold(HANDLE_WIDTH, (HELD_AT, 0.0, low), turns=2)

    def scene(self) -> Scene:
        table = self.workspace.scene(())
        low, high = self.workspace.area()
        handle = Box(size=(HANDLE_LENGTH, HANDLE_WIDTH, THICKNESS))
        middle = (OUTER + HANDLE_LENGTH) / 2.0
        ring = frame(INNER, OUTER, THICKNESS)
        nut = SceneObject(
            name=NUT,
            geometry=Compound(
                parts=(*ring.parts, (handle, Pose(xyz=(middle, 0.0, 0.0))))
            ),
            pose=Pose(xyz=(float(low[0]), float(high[1]), self._rest)),
            mass=NUT_MASS,
            rgba=PALETTE[3],
        )
        peg = SceneObject(
            name=PEG,
            geometry=Box(size=(PEG_WIDTH, PEG_WIDTH, PEG_HEIGHT)),
            pose=Pose(xyz=(float(low[0]), float(low[1]), TABLE_TOP + PEG_HEIGHT / 2.0)),
            rgba=FIXTURE_RGBA,
        )
        return replace(table, objects=(*table.objects, nut, peg))

    def draw(self, rng: np.random.Generator) -> Start:
        yaws = rng.uniform(-np.pi, np.pi, 2)
        handle = HELD_AT * np.array([np.cos(yaws[0]), np.sin(yaws[0])])

        def fits(places: Array) -> bool:
            nut, peg = places
            return math.dist(nut, peg) > APART and self.workspace.can_work(nut + handle)

        places = self.workspace.draw_on_table(rng, 2, fits)
        places[:, 2] = self._rest, TABLE_TOP + PEG_HEIGHT / 2.0
        return Start(places, yaws, np.array([*places[1, :2], self._rest, 1.0]))

    def achieved(self, state: State) -> Array:
        released = state.opening > HANDLE_WIDTH + RELEASED
        return np.column_stack([state.object_position[:, 0], released])

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        offset = achieved - desired
        is_around = length(offset[..., :2]) < AROUND
        is_down = np.abs(offset[..., 2]) < LEVEL
        return np.asarray(is_around & is_down & (np.abs(offset[..., 3]) < 0.5))

    def distance(self, achieved: Array, desired: Array) -> Array:
        return length(achieved[..., :3] - desired[..., :3])

    def progress(self, state: State) -> Array:
        nut = state.object_position[:, 0]
        held_at = self._hold.places(nut, state.object_quat[:, 0])
        away = length(state.tcp_position - held_at)
        beside = length(nut[:, :2] - state.goal[:, :2])
        raised = np.clip((nut[:, 2] - self._rest) / PEG_HEIGHT, 0.0, 1.0)
        raised[beside < AROUND] = 1.0
        return np.asarray(
            0.2 * nearness(away)
            + 0.2 * is_holding(state, self._hold)
            + 0.2 * raised
            + 0.2 * raised * nearness(beside)
            + 0.2 * nearness(length(nut - state.goal[:, :3]))
        )

    def expert(self, state: State, commanded: Frames) -> Target:
        space, nut, goal = self.workspace, state.object_position[:, 0], state.goal
        target, held = grasp(space, state, commanded, self._hold)
        yaw = yaws_of_quats(state.object_quat[:, 0])
        turn = folded(yaws_of_quats(state.object_quat[:, 1]) - yaw, 4)
        off = length(nut[:, :2] - goal[:, :2])
        bottom, top = nut[:, 2] - THICKNESS / 2.0, TABLE_TOP + PEG_HEIGHT
        is_around = (bottom < top + LOW) & (off < AROUND)
        is_high = bottom > top + LOW
        high = top + RAISED + THICKNESS / 2.0
        # The nut swings when the arm starts to move down.
        slack = np.where(is_sent_below(state, commanded, nut, high), SWING, 1.0)
        is_over = (off < slack * OVER) & (np.abs(turn) < slack * STRAIGHT)
        # The nut is moved up, horizontally and then down.
        may_sink = is_around | (is_over & is_high)
        height = np.where(may_sink, goal[:, 2] + DROP, high)
        across = is_around | is_high
        turn = np.where(across, turn, 0.0)
        place = np.where(across[:, None], goal[:, :3], nut)
        place[:, 2] = height
        position = carried(state, commanded, nut, place, turn)
        speed = np.where(off < 2.0 * AROUND, DOWN, 1.0)
        placed = is_around & (np.abs(nut[:, 2] - goal[:, 2]) < 2.0 * DROP)
        position = np.where(held[:, None], position, target.position)
        # When the nut is in place, the gripper opens and the arm retreats.
        up = commanded.position.copy()
        up[:, 2] = TABLE_TOP + space.grasp_height + space.lift
        gone = state.opening > HANDLE_WIDTH + 0.01
        leave = np.where(gone[:, None], up, commanded.position)
        opening = np.where(held, 0.0, target.opening)
        return Target(
            np.where(placed[:, None], leave, position),
            np.where(
                placed,
                commanded.yaw,
                np.where(held, yaw_of(state.tcp_rotation) + turn, target.yaw),
            ),
            np.where(placed, space.gripper.max_opening, opening),
            np.where(held, speed, 1.0),
        )
