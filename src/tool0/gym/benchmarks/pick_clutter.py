"""Pick one cube from a clutter of other objects, and lift it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final, final

import numpy as np

from tool0.api.table import TABLE_TOP
from tool0.description.scene import PALETTE, Scene, SceneObject
from tool0.description.shapes import RGBA, Box, Cylinder, Geometry
from tool0.description.transform import Pose
from tool0.description.transform_arrays import Frames, yaw_of, yaws_of_quats
from tool0.gym.hold import Hold, folded
from tool0.gym.task import Mask, Start, State, Target, Task, length, nearness
from tool0.gym.ways import is_holding, lift
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

TARGET = "target"
RED: Final[RGBA] = (0.85, 0.1, 0.1, 1.0)
OTHERS: Final[dict[str, Geometry]] = {
    "brick": Box(size=(0.06, 0.03, 0.035)),
    "block": Box(size=(0.035, 0.035, 0.035)),
    "slab": Box(size=(0.05, 0.05, 0.02)),
    "can": Cylinder(radius=0.02, length=0.042),
    "puck": Cylinder(radius=0.03, length=0.02),
    "post": Cylinder(radius=0.0125, length=0.04),
}
TALLEST = 0.042
"""Height of the tallest object [m]."""
DENSITY = 900.0
"""Density of all objects [kg/m³], equal to that of plastic."""
LARGEST_EDGE = 0.036
"""Largest edge of the target cube [m]."""
LIFTED = 0.08
"""Minimum height of a lifted target above its initial height [m]."""
FINGER_ROOM, FINGER_WIDTH = 0.032, 0.03
"""Space that a finger needs next to the target, along and perpendicular to the closing
direction of the pads [m]."""
GAP, SPREAD = 0.003, 0.03
"""Minimum gap between objects, and width of the ring around the target in which the
objects are placed [m].  The ring is widened if it has no free place."""
CROWDED = 400
"""Number of attempts to place one object before the ring is widened."""


@final
class PickClutter(Task):
    """Task of lifting the red cube, which six other objects closely surround.

    Two opposite sides of the cube have room for the fingers.
    """

    instruction = "Lift the red cube out of the clutter."
    objects = (TARGET, *OTHERS)
    goal_names = ("height",)

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._edge = min(LARGEST_EDGE, 0.75 * workspace.gripper.max_opening)
        self._rest = TABLE_TOP + self._edge / 2.0
        above = workspace.grasp_height_of(self._edge) - self._edge / 2.0
        self._hold = Hold(
            self._edge,
            (0.0, 0.0, above),
            hover=TABLE_TOP + TALLEST + workspace.reach + 0.025,
            opening=min(self._edge + 0.024, workspace.gripper.max_opening),
        )
        self._radii = np.array([_radius(shape) for shape in OTHERS.values()])

    def scene(self) -> Scene:
        table = self.workspace.scene(())
        places, yaws, _, _ = self.draw(np.random.default_rng(0))
        cube = Box(size=(self._edge, self._edge, self._edge))
        movable = [
            SceneObject(
                name=name,
                geometry=shape,
                pose=Pose(xyz=(x, y, z), rpy=(0.0, 0.0, yaw)),
                mass=DENSITY * _volume(shape),
                rgba=RED if name == TARGET else PALETTE[k % 4],
            )
            for k, ((name, shape), (x, y, z), yaw) in enumerate(
                zip(
                    {TARGET: cube, **OTHERS}.items(),
                    places.tolist(),
                    yaws.tolist(),
                    strict=True,
                )
            )
        ]
        return replace(table, objects=(*table.objects, *movable))

    def draw(self, rng: np.random.Generator) -> Start:
        middle = self.workspace.draw_on_table(rng, 1)[0, :2]
        yaws = rng.uniform(-np.pi, np.pi, len(self.objects))
        # The largest objects are placed first, because small objects fit between large
        # objects.
        order = np.argsort(-self._radii)
        found: dict[int, Array] = {}
        for k in order.tolist():
            found[k] = self._free_place(rng, found, middle, yaws[0], k)
        xy = np.array([middle, *(found[k] for k in range(len(found)))])
        z = [self._rest, *(TABLE_TOP + _height(s) / 2.0 for s in OTHERS.values())]
        return Start(np.column_stack([xy, z]), yaws, np.array([LIFTED]))

    def _free_place(
        self,
        rng: np.random.Generator,
        found: dict[int, Array],
        middle: Array,
        yaw: float,
        k: int,
    ) -> Array:
        """Return a place near the target for object ``k`` [m], shape (2,)."""
        radius = self._radii[k]
        nearest = self._edge / math.sqrt(2.0) + radius + GAP
        reach = nearest + SPREAD
        while True:
            for _ in range(CROWDED):
                angle, away = rng.uniform(-np.pi, np.pi), rng.uniform(nearest, reach)
                place = middle + away * np.array([np.cos(angle), np.sin(angle)])
                beside = [
                    math.dist(place, other) - radius - self._radii[i]
                    for i, other in found.items()
                ]
                room = _room(place - middle, yaw) - radius
                if min([room, *(gap - GAP for gap in beside)]) > 0.0:
                    return np.asarray(place)
            reach += SPREAD

    def achieved(self, state: State) -> Array:
        return state.object_position[:, 0, 2:] - self._rest

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return self.distance(achieved, desired) <= 0.0

    def distance(self, achieved: Array, desired: Array) -> Array:
        return np.asarray(np.maximum(0.0, desired - achieved)[..., 0])

    def progress(self, state: State) -> Array:
        cube, quat = state.object_position[:, 0], state.object_quat[:, 0]
        away = length(state.tcp_position - self._hold.places(cube, quat))
        lifted = np.clip(self.achieved(state)[:, 0] / LIFTED, 0.0, 1.0)
        held = is_holding(state, self._hold)
        return np.asarray(0.3 * nearness(away) + 0.2 * held + 0.5 * lifted)

    def expert(self, state: State, commanded: Frames) -> Target:
        return lift(
            self.workspace, state, commanded, self._hold, self._clear_yaw(state)
        )

    def _clear_yaw(self, state: State) -> Array:
        """Return the TCP's yaw with the most space for the fingers [rad], (n,)."""
        cube = yaws_of_quats(state.object_quat[:, 0])
        away = state.object_position[:, 1:, :2] - state.object_position[:, :1, :2]
        sides = [
            (_room(away, yaw[:, None]) - self._radii).min(axis=1)
            for yaw in (cube, cube + np.pi / 2.0)
        ]
        yaw = np.where(sides[0] >= sides[1], cube, cube + np.pi / 2.0)
        present = yaw_of(state.tcp_rotation)
        return np.asarray(present + folded(yaw - present, 2))


def _room(away: Array, yaw: Array | float) -> Array:
    """Return the distance of points from the fingers' space at the target [m], (…).

    ``away`` is relative to the target's center [m], shape (…, 2).  At the TCP's ``yaw``
    [rad], the pads close along the y axis.
    """
    c, s = np.cos(yaw), np.sin(yaw)
    across = np.abs(c * away[..., 0] + s * away[..., 1])
    along = np.abs(-s * away[..., 0] + c * away[..., 1])
    outside = np.stack(
        [
            np.maximum(0.0, across - FINGER_WIDTH / 2.0),
            np.maximum(0.0, along - LARGEST_EDGE / 2.0 - FINGER_ROOM),
        ],
        axis=-1,
    )
    return length(outside)


def _radius(shape: Geometry) -> float:
    """Return the radius of the circle around an upright object, seen from above [m]."""
    if isinstance(shape, Box):
        return math.hypot(*shape.size[:2]) / 2.0
    assert isinstance(shape, Cylinder)
    return shape.radius


def _height(shape: Geometry) -> float:
    if isinstance(shape, Box):
        return shape.size[2]
    assert isinstance(shape, Cylinder)
    return shape.length


def _volume(shape: Geometry) -> float:
    if isinstance(shape, Box):
        return math.prod(shape.size)
    assert isinstance(shape, Cylinder)
    return math.pi * shape.radius**2 * shape.length
