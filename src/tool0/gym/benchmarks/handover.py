"""Hand a bar from one arm to another that cannot reach it on the table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple, final

import numpy as np

from tool0.api.table import TABLE_TOP
from tool0.description.scene import PALETTE, Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.description.transform_arrays import Frames, yaw_of, yaws_of_quats
from tool0.gym.hold import Hold
from tool0.gym.task import Mask, Start, State, Target, Task, length, nearness
from tool0.gym.ways import Grasp, carried, grasp, is_holding
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array
from tool0.kinematics.geometry import wrapped

GIVER, TAKER = "left", "right"
BAR = "bar"
LENGTH, MASS, WIDEST = 0.24, 0.1, 0.03
"""Length [m], mass [kg], and largest width and height [m] of the bar."""
HELD_AT = 0.085
"""Distance from the bar's center at which a gripper holds it [m]."""
NEAR, FAR, SIDE = 0.34, 0.52, 0.3
"""Limits for the bar's center at the start: minimum and maximum distance in front of
the giver, and maximum distance to each side, for arms of scale 1 [m]."""
EDGE = 0.31
"""Minimum distance from the giver to the bar, set by the edge of the table, for an arm
of scale 1 [m]."""
CLOSE = 0.4
"""Minimum distance from the giver's axis to the TCP when it grasps the bar, for an arm
of scale 1 [m].  At a shorter distance, a small arm with a long gripper would collide
with itself."""
PARTS = 13
"""Number of points along the bar that the taker must not reach."""
ATTEMPTS = 200
"""Number of attempts to draw a valid place.  If all attempts fail, the last place is
used."""
LIFTED = 0.08
"""Minimum height of a lifted bar above its initial height [m]."""
RELEASED = 0.006
"""The bar is released when the gripper's opening exceeds the bar's width by more than
this length [m]."""
AT_END = 0.03
"""Distance from the grasp point at an end of the bar within which a TCP is considered
to be at that end [m]."""
BELOW = 0.03
"""A bar that is below the handover height by more than this distance first rises
vertically [m]."""
MET, STRAIGHT = 0.006, 0.06
"""Largest position error [m] and angle [rad] of the bar for the taker to approach
it."""
SLACK = 3.0
"""Factor by which MET and STRAIGHT increase when the taker is at the bar."""
LEAVE = 0.12
"""Height above the bar to which a gripper retreats [m]."""


class _Ends(NamedTuple):
    """State as seen by each arm; the bar's x axis points from giver to taker."""

    give: State
    take: State
    yaw: Array
    """Yaw of the bar's x axis [rad], shape (n,)."""


@final
class Handover(Task):
    """Task in which one arm lifts a bar, and a second arm takes the bar in the air.

    The bar lies where only the first arm can reach it.  Each arm holds one half of the
    bar.
    """

    instruction = "Hand the bar over from the left arm to the right arm."
    arms = (GIVER, TAKER)
    objects = (BAR,)
    goal_names = ("height", "taken", "released")

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._giver, self._taker = workspace.of(GIVER), workspace.of(TAKER)
        self._width = round(min(WIDEST, 0.75 * workspace.gripper.max_opening), 4)
        self._rest = TABLE_TOP + self._width / 2.0
        above = workspace.grasp_height_of(self._width) - self._width / 2.0
        self._give = Hold(self._width, (-HELD_AT, 0.0, above), turns=2)
        self._take = Hold(self._width, (HELD_AT, 0.0, above), turns=2)
        start, back = self._giver.start_position, self._taker.start_position
        self._meeting = (start + back) / 2.0
        """Position of the bar's center at the handover [m]."""

    def scene(self) -> Scene:
        table = self.workspace.scene(())
        bar = SceneObject(
            name=BAR,
            geometry=Box(size=(LENGTH, self._width, self._width)),
            pose=Pose(xyz=(*self.workspace.table.at(FAR, 0.0), self._rest)),
            mass=MASS,
            rgba=PALETTE[1],
        )
        return replace(table, objects=(*table.objects, bar))

    def draw(self, rng: np.random.Generator) -> Start:
        table = self._giver.table
        low, high = np.array(table.at(NEAR, -SIDE)), np.array(table.at(FAR, SIDE))
        for _ in range(ATTEMPTS):
            place, yaw = rng.uniform(low, high), rng.uniform(-np.pi, np.pi)
            if self._is_start(place, yaw):
                break
        places = np.array([[*place, self._rest]])
        return Start(places, np.array([yaw]), np.array([LIFTED, 1.0, 1.0]))

    def _is_start(self, place: Array, yaw: float) -> bool:
        """Return whether the bar is on the table and only the giver can lift it."""
        along = np.array([np.cos(yaw), np.sin(yaw)])
        parts = place + np.linspace(-0.5, 0.5, PARTS)[:, None] * LENGTH * along
        if parts[:, 0].min() < EDGE * self._giver.scale:
            return False
        low = np.column_stack([parts, np.full(PARTS, self._taker.lowest)])
        if self._taker.reaches_from_above(low):
            return False
        holds = [place + side * HELD_AT * along for side in (-1.0, 1.0)]
        nearest = CLOSE * self._giver.scale
        return all(
            math.hypot(*hold) > nearest and self._giver.can_lift(hold) for hold in holds
        )

    def achieved(self, state: State) -> Array:
        ends = self._ends(state)
        return np.column_stack(
            [
                state.object_position[:, 0, 2] - self._rest,
                is_holding(ends.take, self._take),
                ends.give.opening > self._width + RELEASED,
            ]
        )

    def is_success(self, achieved: Array, desired: Array) -> Mask:
        return np.asarray((achieved >= desired).all(axis=-1))

    def distance(self, achieved: Array, desired: Array) -> Array:
        missing = np.maximum(0.0, desired - achieved)
        return np.asarray(missing[..., 0] + LIFTED * missing[..., 1:].sum(axis=-1))

    def progress(self, state: State) -> Array:
        give, take, _ = self._ends(state)
        height, taken, released = self.achieved(state).T
        near = nearness(length(give.tcp_position - _place(give, self._give)))
        reached = nearness(length(take.tcp_position - _place(take, self._take)))
        held = is_holding(give, self._give)
        raised = np.clip(height / LIFTED, 0.0, 1.0)
        return np.asarray(
            0.15 * np.maximum(near, taken)
            + 0.15 * np.maximum(held, taken)
            + raised * (0.2 + 0.2 * reached + 0.2 * taken + 0.1 * taken * released)
        )

    def _ends(self, state: State) -> _Ends:
        """Return the states as if the bar were turned so that the giver's end is at -x.

        The giver's end is the end at the giver's TCP or, if the giver's TCP is not at
        the bar, the end opposite the taker's TCP.  If no TCP is at the bar, the giver's
        end is the end that points away from the taker.
        """
        position, quat = state.object_position[:, 0], state.object_quat[:, 0]
        yaw = yaws_of_quats(quat)
        is_turned = np.cos(yaw) < 0.0
        for arm, hold in ((TAKER, self._take), (GIVER, self._give)):
            tcp = state.arms[arm].tcp_position
            ends = hold.places(position, quat), hold.places(position, _turned(quat))
            own, other = (length(tcp - end) < AT_END for end in ends)
            is_turned = np.where(own, False, np.where(other, True, is_turned))
        quats = state.object_quat.copy()
        quats[is_turned, 0] = _turned(quat[is_turned])
        seen = state._replace(object_quat=quats)
        yaw = wrapped(yaw + np.pi * is_turned)
        return _Ends(seen.of(GIVER), seen.of(TAKER), yaw)

    def experts(
        self, state: State, commanded: Mapping[str, Frames]
    ) -> Mapping[str, Target]:
        ends = self._ends(state)
        give, take = (
            grasp(self._giver, ends.give, commanded[GIVER], self._give),
            grasp(self._taker, ends.take, commanded[TAKER], self._take),
        )
        bar = state.object_position[:, 0]
        at_bar = length(ends.take.tcp_position - _place(ends.take, self._take))
        slack = np.where(at_bar < LEAVE / 2.0, SLACK, 1.0)
        is_met = length(bar - self._meeting) < slack * MET
        is_met &= np.abs(ends.yaw) < slack * STRAIGHT
        is_met &= give.held | take.held
        return {
            GIVER: self._give_it(ends, commanded[GIVER], give, take.held),
            TAKER: self._take_it(ends, commanded[TAKER], take, is_met),
        }

    def _give_it(
        self, ends: _Ends, commanded: Frames, own: Grasp, is_taken: Mask
    ) -> Target:
        """Return the giver's next target to grasp, carry or release the bar."""
        state = ends.give
        bar = state.object_position[:, 0]
        is_low = bar[:, 2] < self._meeting[2] - BELOW
        place = np.where(is_low[:, None], bar, self._meeting)
        place[:, 2] = self._meeting[2]
        turn = np.where(is_low, 0.0, -ends.yaw)
        carry = carried(state, commanded, bar, place, turn)
        position = np.where(own.held[:, None], carry, own.target.position)
        yaw = np.where(own.held, yaw_of(state.tcp_rotation) + turn, own.target.yaw)
        opening = np.where(own.held, 0.0, own.target.opening)
        # When the taker holds the bar, the giver opens its gripper and retreats.
        is_open = state.opening > self._width + RELEASED
        up = commanded.position.copy()
        up[:, 2] = self._meeting[2] + LEAVE
        leave = np.where(is_open[:, None], up, commanded.position)
        return Target(
            np.where(is_taken[:, None], leave, position),
            np.where(is_taken, commanded.yaw, yaw),
            np.where(is_taken, self._giver.gripper.max_opening, opening),
            np.ones(len(yaw)),
        )

    def _take_it(
        self, ends: _Ends, commanded: Frames, own: Grasp, is_met: Mask
    ) -> Target:
        """Return the taker's next target, which is above the handover or at the bar."""
        wait = self._meeting + np.array([HELD_AT, 0.0, LEAVE])
        yaw = commanded.yaw + self._take.turn(commanded.yaw, np.array([[1.0, 0, 0, 0]]))
        widest = self._taker.gripper.max_opening
        hold = own.held | is_met
        return Target(
            np.where(is_met[:, None], own.target.position, wait),
            np.where(is_met, own.target.yaw, yaw),
            np.where(hold, own.target.opening, widest),
            np.ones(len(yaw)),
        )


def _turned(quat: Array) -> Array:
    """Return orientations w, x, y, z, (n, 4), turned by pi about their z axes."""
    w, x, y, z = quat.T
    return np.column_stack([-z, y, -x, w])


def _place(state: State, hold: Hold) -> Array:
    """Return the TCP position at which a gripper holds the bar [m], shape (n, 3)."""
    return hold.places(state.object_position[:, 0], state.object_quat[:, 0])
