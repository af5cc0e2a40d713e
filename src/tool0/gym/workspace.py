"""The table in front of an arm with a gripper, its places, and the arm's reach."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import final

import numpy as np

from tool0.api.grasps import CLEARANCE, find_bin, finger_reach
from tool0.api.table import (
    BIN,
    BIN_HALF_WIDTH,
    BIN_Y,
    FAR,
    GAP,
    LEFT,
    NEAR,
    RIGHT,
    TABLE,
    TABLE_TOP,
    joined,
)
from tool0.description.grasp_frames import grasp_frame
from tool0.description.parts import find_grippers, gripper_of
from tool0.description.scene import PALETTE, Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose, Vector3
from tool0.errors import ConfigError, did_you_mean
from tool0.gym.options import EnvOptions
from tool0.gym.site import FILL, Site
from tool0.gym.tool import Tool, downward
from tool0.kinematics.chain import Array, find_chains, fixed_transform
from tool0.kinematics.geometry import wrapped
from tool0.kinematics.inverse import InverseKinematics

HIGHEST = 0.6
"""Largest height of a cube, as a fraction of the height at which cubes are carried."""
OPENINGS = 33
"""Number of gripper openings between which the position of the pads is interpolated
linearly; the error is within 0.02 mm for the grippers of the catalogue."""
CUBE_MASS, CUBE_FRICTION = 0.1, 1.0
"""Mass [kg] and coefficient of friction of a cube, unless these values are
randomized."""
HOVER = 0.02
"""Minimum clearance between the fingertips and the cubes below them [m]."""
RUN_UP = 0.03
"""Clearance between a cube's nearest corner and a tool that moves down to push the cube
[m]."""
FIXTURE_RGBA = (0.35, 0.37, 0.4, 1.0)
"""Color of fixed objects on the table, which is the color of steel."""
NEARER = 0.05
"""Depth of the additional working area between the start area and the base, for an arm
of scale 1 [m]."""
ATTEMPTS = 200
"""Number of attempts to draw a valid place.  If all attempts fail, the last place is
used."""


@final
class Workspace:
    """One arm with a gripper, and the table in front of it.

    Lengths on the table are proportional to the scale of the arm, but the sizes of
    cubes and the bin are constant.  Poses are in the robot's root frame.
    """

    def __init__(self, site: Site, arm: str, beside: Mapping[str, Workspace]) -> None:
        """Use an arm of a task.

        Args:
            site: All arms of the task.
            arm: Name of this arm in the robot model.
            beside: Workspaces of all arms by name; the caller adds each workspace after
                it is made.

        Raises:
            Tool0Error: If the arm or the gripper is not supported.
        """
        model = site.model
        self.arm = arm
        """Name of the arm in the robot model."""
        self.gripper_name = gripper_of(model, arm) or ""
        """Name of the arm's gripper in the robot model."""
        self.gripper = find_grippers(model)[self.gripper_name]
        """The gripper's geometry."""
        self._site, self._beside = site, beside
        self.description, self.scale = site.description, site.scale
        self.cameras = site.cameras
        """The cameras for images."""
        self.table = site.tables[arm]
        self.edge = site.edge
        """Edge of each cube [m]; if sizes are random, this is the nominal edge."""
        self.chain = find_chains(model)[arm]
        self._inverse = InverseKinematics(self.chain)
        self.fastest = self._inverse.fastest
        """Largest velocities of the arm's joints [rad/s], shape (6,)."""
        limits = [joint.limits for joint in self.chain.joints]
        self.lower = np.array([item.lower for item in limits])
        self.upper = np.array([item.upper for item in limits])
        """Lower and upper limits of the arm's joints [rad], shape (6,) each."""
        tip = self.chain.tip
        T_tip_tcp = grasp_frame(model, self.gripper, self.edge, tip)
        T_root_base = fixed_transform(model, model.root, self.chain.base)
        self.tool = Tool(self.chain, T_root_base, T_tip_tcp)
        """Tool with its TCP at the point between pads that hold a cube."""
        self._T_base_root = T_root_base.inverse().matrix
        self._T_tcp_tip = T_tip_tcp.inverse().matrix
        self.reach = finger_reach(model, self.gripper)
        """Distance by which the fingers extend beyond the TCP when they hold a cube
        [m]."""
        closed = grasp_frame(model, self.gripper, 0.0, tip)
        away = closed.position[2] - T_tip_tcp.position[2]
        self.advance = max(0.0, away)
        """Distance by which the fingertips of a closed gripper extend beyond those of
        one that holds a cube [m]."""
        self.grasp_height = self.grasp_height_of(self.edge)
        """Height of the TCP above a cube's support when the gripper grasps the cube
        [m]."""
        self._size_range = site.size_range
        self.has_sizes = tuple(self._size_range) != (1.0, 1.0)
        """Whether objects have random sizes."""
        low, high = self.size_factors(np.full(3, self.edge))
        self.edges = (low * self.edge, high * self.edge)
        """Edges of the smallest and the largest cube [m]."""
        if self.has_sizes:
            self._openings = np.linspace(0.0, self.gripper.max_opening, OPENINGS)
            frames = [
                grasp_frame(model, self.gripper, opening, tip)
                for opening in self._openings.tolist()
            ]
            z = np.array([frame.position[2] for frame in frames])
            self._aheads = z - T_tip_tcp.position[2]
            """Distance from the TCP forward to the middle of the pads, for each gripper
            opening [m]."""

    @property
    def prefix(self) -> str:
        """Prefix of names in actions and observations; it is empty for a single arm."""
        return f"{self.arm}_" if len(self._beside) > 1 else ""

    def of(self, arm: str) -> Workspace:
        """Return the workspace of an arm of the task.

        Raises:
            ConfigError: If there is no such arm.
        """
        if arm not in self._beside:
            raise ConfigError(f"no arm '{arm}'{did_you_mean(arm, self._beside)}")
        return self._beside[arm]

    def grasp_height_of(self, height: float) -> float:
        """Return the height of the TCP above the support of a grasped object [m].

        ``height`` [m] is the height of the object.  If the TCP were lower, the fingers
        would touch the table, or the knuckles would touch the object.
        """
        return max(height / 2.0, height - self.reach, self.reach + CLEARANCE)

    def grasp_heights(self, edge: Array) -> Array:
        """Return heights of the TCP above the support of grasped cubes [m], shape (n,).

        This function is the counterpart of ``grasp_height_of`` for cubes with the edges
        ``edge`` [m], shape (n,).  The middle of the pads moves relative to the TCP,
        because the fingers turn as they open.
        """
        height = np.maximum(edge / 2.0, edge - self.reach)
        height = np.maximum(height, self.reach + CLEARANCE)
        return np.asarray(height + np.interp(edge, self._openings, self._aheads))

    def size_factors(self, extents: Array) -> tuple[float, float]:
        """Return the range of random factors on the size of an object.

        The result is the range of ``Randomisation.size``, limited so that the middle of
        the pads is beside the object, the gripper opens wide enough, and a cube can be
        carried above another cube.  If the nominal size of an object is outside these
        limits, it becomes the limit.  ``extents`` are the extents of the object [m],
        shape (3,).

        Raises:
            ConfigError: If the limited range is empty.
        """
        smallest = self.reach + CLEARANCE
        largest = min(FILL * self.gripper.max_opening, HIGHEST * self.lift)
        least = min(1.0, smallest / float(extents[2]))
        most = max(1.0, largest / float(extents[:2].min()))
        low, high = max(self._size_range[0], least), min(self._size_range[1], most)
        if low > high:
            raise ConfigError(
                f"randomise.size is {tuple(self._size_range)}, but the gripper grasps "
                f"objects of {least:.3g} … {most:.3g} times the usual size"
            )
        return low, high

    # ---- places on the table --------------------------------------------------------

    @property
    def lowest(self) -> float:
        """Minimum height of the TCP at which the fingertips clear the table [m]."""
        return TABLE_TOP + self.reach + CLEARANCE

    @property
    def hover_height(self) -> float:
        """Height of the TCP above the table when the fingers pass over cubes [m]."""
        return max(self.grasp_height, self.reach) + self.edges[1] + HOVER

    @property
    def run_up(self) -> float:
        """Distance from a cube's center at which a tool moves down for a push [m]."""
        return 0.71 * self.edges[1] + RUN_UP

    @property
    def lift(self) -> float:
        """Height of a carried cube above the height at which it is grasped [m]."""
        return self.table.lift

    @cached_property
    def bin_centre(self) -> Vector3:
        """Position of the center of the bin's floor [m]."""
        x, y, z = find_bin(self._shipped, BIN).center
        return x, y, z

    def area(self, *, beside_bin: bool = False) -> tuple[Array, Array]:
        """Return the corners of the start area of objects [m], shape (2,) each."""
        right = RIGHT
        if beside_bin:  # the bin does not scale with the table
            right = max(RIGHT, BIN_Y + (BIN_HALF_WIDTH + GAP) / self.scale)
        corners = self.table.at(NEAR, right), self.table.at(FAR, LEFT)
        return np.minimum(*corners), np.maximum(*corners)

    def draw_place(self, rng: np.random.Generator, low: Array, high: Array) -> Array:
        """Return a random place within reach between two corners [m], shape (3,)."""
        for _ in range(ATTEMPTS):
            place = rng.uniform(low, high)
            if self.is_in_reach(place):
                break
        return place

    def is_in_reach(self, position: Array) -> bool:
        """Return whether ``posture`` has a solution for a point [m], (3,)."""
        return bool(np.isfinite(self.posture(position)).all())

    def posture(self, position: Array) -> Array:
        """Return the joint positions at a TCP position [rad], or NaN if out of reach.

        ``position`` [m], (3,), is in the root frame.  The yaw and the posture of the
        arm are the same as at the start.
        """
        T = self._flange(position, self.start_yaw)
        with np.errstate(invalid="ignore"):
            return np.asarray(self._inverse.geometry.solve(T[None])[0][self._branch])

    def reaches_from_above(self, positions: Array) -> bool:
        """Return whether the TCP reaches any of k points, (k, 3) [m], in any posture.

        The tool points down, and joint limits are ignored.
        """
        T = np.array([self._flange(each, self.start_yaw) for each in positions])
        with np.errstate(invalid="ignore"):
            found = self._inverse.geometry.solve(T)
        return bool(np.isfinite(found).all(axis=2).any())

    def can_lift(self, place: Array) -> bool:
        """Return whether the arm can grasp and lift a cube at ``place`` [m], (2,)."""
        low = TABLE_TOP + self.grasp_height
        return all(
            self.is_in_reach(np.append(place, z)) for z in (low, low + self.lift)
        )

    def can_work(self, place: Array) -> bool:
        """Return whether the arm can lift a cube at a place far enough from the base.

        ``place`` [m], (2,), may be outside of ``area``.
        """
        ahead = place[0] - self.table.base[0]
        if self.table.is_turned:
            ahead = -ahead
        nearest = NEAR * self.scale - NEARER * self.scale
        return bool(ahead > nearest) and self.can_lift(place)

    def draw_on_table(
        self,
        rng: np.random.Generator,
        n: int,
        fits: Callable[[Array], bool] = lambda places: True,
        *,
        beside_bin: bool = False,
    ) -> Array:
        """Return random places of n cubes on the table [m], shape (n, 3).

        The arm can lift cubes at these places, and ``fits`` accepts the places, shape
        (n, 2).
        """
        low, high = self.area(beside_bin=beside_bin)
        for _ in range(ATTEMPTS):
            places = rng.uniform(low, high, (n, 2))
            if fits(places) and all(map(self.can_lift, places)):
                break
        height = np.full((n, 1), TABLE_TOP + self.edge / 2.0)
        return np.concatenate([places, height], axis=1)

    # ---- the start ------------------------------------------------------------------

    @cached_property
    def start(self) -> Array:
        """Positions of the arm's joints at the start [rad], shape (6,)."""
        return self._start[1]

    @cached_property
    def start_yaw(self) -> float:
        """Yaw of the TCP at the start [rad]."""
        return self._start[0]

    @cached_property
    def start_position(self) -> Array:
        """Position of the TCP at the start [m], shape (3,)."""
        x, y = self.table.at((NEAR + FAR) / 2.0, (RIGHT + LEFT) / 2.0)
        return np.array([x, y, TABLE_TOP + self.grasp_height + self.lift])

    @cached_property
    def _start(self) -> tuple[float, Array]:
        ready = self._site.ready
        near = np.array([ready[name] for name in self.chain.joint_names])
        best: tuple[float, float, Array] | None = None
        for yaw in (k * math.pi / 2.0 for k in range(-1, 3)):
            found = self._inverse.solutions(
                self._flange(self.start_position, yaw), near
            )
            if best is None or found[0].distance < best[0]:
                q = np.array([found[0].positions[j] for j in self.chain.joint_names])
                best = found[0].distance, yaw, q
        assert best is not None
        return best[1], best[2]

    @cached_property
    def _branch(self) -> int:
        """Index of the start posture among the eight inverse kinematics solutions."""
        T = self._flange(self.start_position, self.start_yaw)
        every = self._inverse.geometry.solve(T[None])[0]
        away = np.nan_to_num(np.abs(wrapped(every - self.start)), nan=np.inf)
        return int(away.max(axis=1).argmin())

    def _flange(self, position: Array, yaw: float) -> Array:
        """Return the flange's pose in the arm's base frame, (4, 4), for a TCP pose."""
        T = np.eye(4)
        T[:3, :3] = downward(np.array([yaw]))[0]
        T[:3, 3] = position
        return np.asarray(self._T_base_root @ T @ self._T_tcp_tip)

    # ---- the scene ------------------------------------------------------------------

    @cached_property
    def _shipped(self) -> tuple[SceneObject, ...]:
        """The table, the bin and a cube of the demos."""
        found = self.table.scene(edge=self.edge, mass=CUBE_MASS, friction=CUBE_FRICTION)
        return found.objects

    def scene(
        self,
        cubes: tuple[str, ...],
        *,
        friction: float = CUBE_FRICTION,
        with_bin: bool = False,
    ) -> Scene:
        """Return the table with cubes of these names, and optionally with the bin.

        All arms share the table.  The cubes and the bin are in front of this arm.
        """
        tables = [
            item
            for space in self._beside.values()
            for item in space._shipped
            if item.name == TABLE
        ]
        fixed = tables if len(tables) == 1 else [joined(tables)]
        if with_bin:
            fixed += [item for item in self._shipped if item.name.startswith(f"{BIN}.")]
        low, high = self.area()
        movable = [
            SceneObject(
                name=name,
                geometry=Box(size=(self.edge, self.edge, self.edge)),
                pose=Pose(xyz=(float(x), float(high[1]), TABLE_TOP + self.edge / 2.0)),
                mass=CUBE_MASS,
                friction=friction,
                rgba=PALETTE[k % len(PALETTE)],
            )
            for k, (name, x) in enumerate(
                zip(cubes, np.linspace(low[0], high[0], len(cubes)), strict=True)
            )
        ]
        return Scene(objects=(*fixed, *movable), cameras=self.cameras)


def workspaces(
    options: EnvOptions, arms: tuple[str, ...] = (), distance: float = 0.0
) -> dict[str, Workspace]:
    """Return the workspace of each arm of a task, by the arm's name.

    Args:
        options: Arm, gripper and cameras.
        arms: Names of two arms; empty for a single arm.
        distance: Distance between the bases of two arms of scale 1 [m].

    Raises:
        Tool0Error: If the arm or the gripper is unknown or not supported.
    """
    site = Site(options, arms, distance)
    found: dict[str, Workspace] = {}
    for name in site.tables:
        found[name] = Workspace(site, name, found)
    return found
