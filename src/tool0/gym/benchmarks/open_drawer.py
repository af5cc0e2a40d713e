"""Pull a drawer out of a cabinet by its handle."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np

from tool0.api.table import TABLE_TOP
from tool0.description.scene import PALETTE, Scene, SceneObject
from tool0.description.shapes import Box, Compound, Geometry
from tool0.description.transform import Pose
from tool0.description.transform_arrays import Frames, from_quats
from tool0.gym.hold import Hold
from tool0.gym.task import Mask, Start, State, Target, Task, length, nearness
from tool0.gym.ways import grasp, is_holding
from tool0.gym.workspace import FIXTURE_RGBA, Workspace
from tool0.kinematics.chain import Array

DRAWER, CABINET = "drawer", "cabinet"
DEPTH, WIDTH, HEIGHT, DRAWER_MASS = 0.18, 0.12, 0.05, 0.4
"""Outer size of the drawer along x, y and z [m], and its mass [kg]."""
PLATE, WALL = 0.006, 0.01
"""Thickness of the drawer's plates and of the cabinet's walls [m]."""
PLAY = 0.001
"""Clearance on each side of the drawer and above it [m]."""
SLIDING, GRIP = 0.2, 0.8
"""Friction coefficient of the cabinet, which has plastic runners, and friction
coefficient of the drawer."""
HANDLE_LENGTH, HANDLE_WIDTH, HANDLE_HEIGHT = 0.06, 0.018, 0.03
"""Size of the handle, an upright plate at the front, along x, y and z [m]."""
HELD_AT = 0.047
"""Distance of the TCP in front of the drawer that keeps the gripper's base clear of the
cabinet [m]."""
PULLED = 0.1
"""Minimum travel of an open drawer [m]."""
TURNED = 0.4
"""Largest angle between the cabinet's front direction and the direction to the robot
[rad]."""
SLOW = 0.3
"""Speed of the pull, as a fraction of the fastest action."""


@final
class OpenDrawer(Task):
    """Open a drawer that slides in a fixed cabinet.

    The drawer is a separate body that the cabinet guides with a little clearance.  The
    drawer can tilt and can be pulled out.  The origin of the cabinet is in the middle
    of the cabinet's floor.  The drawer opens along the x axis.
    """

    instruction = "Open the drawer."
    objects = (DRAWER, CABINET)
    goal_names = ("pulled",)

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._rest = TABLE_TOP + WALL + HEIGHT / 2.0
        lowest = workspace.lowest + workspace.advance - self._rest
        hover = TABLE_TOP + 2.0 * WALL + PLAY + HEIGHT + workspace.reach + 0.03
        self._hold = Hold(
            HANDLE_WIDTH,
            (DEPTH / 2.0 + HELD_AT, 0.0, max(0.0, lowest)),
            turns=2,
            hover=hover,
            opening=min(HANDLE_WIDTH + 0.03, workspace.gripper.max_opening),
        )

    def scene(self) -> Scene:
        table = self.workspace.scene(())
        x, y, _ = self.workspace.start_position
        drawer = SceneObject(
            name=DRAWER,
            geometry=_drawer(),
            pose=Pose(xyz=(float(x), float(y), self._rest)),
            mass=DRAWER_MASS,
            friction=GRIP,
            rgba=PALETTE[5],
        )
        cabinet = SceneObject(
            name=CABINET,
            geometry=_cabinet(),
            pose=Pose(xyz=(float(x), float(y), TABLE_TOP)),
            friction=SLIDING,
            rgba=FIXTURE_RGBA,
        )
        return replace(table, objects=(*table.objects, drawer, cabinet))

    def draw(self, rng: np.random.Generator) -> Start:
        space = self.workspace
        yaw = np.pi + rng.uniform(-TURNED, TURNED)
        ahead = np.array([np.cos(yaw), np.sin(yaw)])

        def can_pull(places: Array) -> bool:
            return space.can_work(places[0] + ahead * (PULLED + 0.02))

        handle = space.draw_on_table(rng, 1, can_pull)[0, :2]
        middle = handle - ahead * (DEPTH / 2.0 + HELD_AT)
        places = np.array([[*middle, self._rest], [*middle, TABLE_TOP]])
        return Start(places, np.array([yaw, yaw]), np.array([PULLED]))

    def achieved(self, state: State) -> Array:
        away = state.object_position[:, 0] - state.object_position[:, 1]
        return np.asarray((away * self._ahead(state)).sum(axis=1, keepdims=True))

    def _ahead(self, state: State) -> Array:
        """Return the direction in which the drawer opens, shape (n, 3)."""
        return np.asarray(from_quats(state.object_quat[:, 1])[:, :, 0])

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return np.asarray((achieved >= desired)[..., 0])

    def distance(self, achieved: Array, desired: Array) -> Array:
        return np.asarray(np.maximum(0.0, desired - achieved)[..., 0])

    def progress(self, state: State) -> Array:
        drawer, quat = state.object_position[:, 0], state.object_quat[:, 0]
        away = length(state.tcp_position - self._hold.places(drawer, quat))
        pulled = np.clip(self.achieved(state)[:, 0] / PULLED, 0.0, 1.0)
        held = is_holding(state, self._hold)
        return np.asarray(0.3 * nearness(away) + 0.2 * held + 0.5 * pulled)

    def expert(self, state: State, commanded: Frames) -> Target:
        target, held = grasp(self.workspace, state, commanded, self._hold)
        left = PULLED + 0.02 - self.achieved(state)
        pull = commanded.position + left * self._ahead(state)
        turn = self._hold.turn(commanded.yaw, state.object_quat[:, 1])
        return Target(
            np.where(held[:, None], pull, target.position),
            np.where(held, commanded.yaw + turn, target.yaw),
            target.opening,
            np.where(held, SLOW, target.speed),
        )


def _plate(x: float, y: float, z: float, *size: float) -> tuple[Geometry, Pose]:
    """Return a plate with the given position and size in x, y and z [m]."""
    width, depth, height = size
    return Box(size=(width, depth, height)), Pose(xyz=(x, y, z))


def _drawer() -> Compound:
    """Return the drawer, with its origin at the center and its handle at +x."""
    x, y, z = (DEPTH - PLATE) / 2.0, (WIDTH - PLATE) / 2.0, (HEIGHT - PLATE) / 2.0
    handle = (DEPTH + HANDLE_LENGTH) / 2.0
    return Compound(
        parts=(
            _plate(0.0, 0.0, -z, DEPTH, WIDTH, PLATE),
            _plate(x, 0.0, PLATE / 2.0, PLATE, WIDTH, HEIGHT - PLATE),
            _plate(-x, 0.0, PLATE / 2.0, PLATE, WIDTH, HEIGHT - PLATE),
            _plate(0.0, y, PLATE / 2.0, DEPTH - 2 * PLATE, PLATE, HEIGHT - PLATE),
            _plate(0.0, -y, PLATE / 2.0, DEPTH - 2 * PLATE, PLATE, HEIGHT - PLATE),
            _plate(handle, 0.0, 0.0, HANDLE_LENGTH, HANDLE_WIDTH, HANDLE_HEIGHT),
        )
    )


def _cabinet() -> Compound:
    """Return the cabinet, with its origin in the middle of the floor."""
    y = WIDTH / 2.0 + PLAY
    inside = HEIGHT + PLAY
    whole = inside + 2.0 * WALL
    outer = 2.0 * (y + WALL)
    back = -(DEPTH + WALL) / 2.0 - PLAY
    return Compound(
        parts=(
            _plate(0.0, 0.0, WALL / 2.0, DEPTH, outer, WALL),
            _plate(0.0, 0.0, WALL * 1.5 + inside, DEPTH, outer, WALL),
            _plate(0.0, y + WALL / 2.0, whole / 2.0, DEPTH, WALL, inside),
            _plate(0.0, -y - WALL / 2.0, whole / 2.0, DEPTH, WALL, inside),
            _plate(back, 0.0, whole / 2.0, WALL, outer, whole),
        )
    )
