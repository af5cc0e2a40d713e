"""Target positions of an arm's joints that follow a twist of its tool."""

from __future__ import annotations

import math
import time
from typing import Final, Literal, final

import numpy as np

from lerobot_robot_tool0.device import Array
from tool0 import Robot
from tool0.description.transform_arrays import from_rotation_vectors
from tool0.errors import ControlError

FASTEST: Final = 0.5
"""Largest speed of a joint, part of its largest velocity: near a singular pose the tool
is slower than the twist."""
LEAD: Final = 0.15
"""How far a joint's target may be ahead of its setpoint [rad]: so far the arm moves at
most when the twist has ended."""
_LOST: Final = 2 * LEAD
"""A target that is so far from its setpoint is not followed: it is dropped [rad]."""
_PAUSE: Final = 0.3
"""After so long without a call, targets begin anew [wall s]: the robot begins another
stream, too."""
_LONGEST: Final = 0.1
"""The twist of a call is valid for so long [simulated s]."""
_START: Final = 0.1
"""How long the tool takes to full speed [simulated s]."""
_TRIES: Final = 3
"""Of a step, each shorter than the one before."""


@final
class ArmJog:
    """Integrates twists of an arm's flange to positions of its joints.

    Nothing moves by itself: after the start, a pause, an emergency stop, a failed
    motion, a reset, or while the device is away, the positions stay until the device
    has been neutral once.
    """

    def __init__(
        self,
        robot: Robot,
        arm: str,
        *,
        speed: tuple[float, float],
        frame: Literal["root", "tool"],
    ) -> None:
        """Take an arm; it is only observed.

        Args:
            robot: The robot; it stays open.
            arm: The arm's name; empty for the only one.
            speed: Largest speed of the tool [m/s] and of its rotation [rad/s].
            frame: The axes of the twist: those of the robot's root, or of the flange.

        Raises:
            ControlError: If there is no such arm, or it is not built like a UR.
        """
        if arm and arm not in robot.arms:
            raise ControlError(f"no arm '{arm}'; the robot has {sorted(robot.arms)}")
        self._robot, self._frame = robot, frame
        self.arm = robot.arms[arm] if arm else robot.arm
        """The arm that is moved."""
        self._kinematics = self.arm.kinematics
        self._speed = np.repeat(speed, 3)
        self._q = np.zeros(6)
        self._R_carrier_root = np.eye(3)
        self._is_armed, self._level = False, 0.0
        self.is_ready = False
        """Whether the device counted in the last call."""
        self._time, self._called = math.inf, -math.inf

    def follow(self, shares: Array | None) -> Array:
        """Return the target positions now [rad], base to flange, shape (6,).

        Args:
            shares: Of the largest speeds, in the chosen axes, -1 … 1, shape (6,); None
                while the device is away.

        Raises:
            TransportError: If the bring-up has ended.
        """
        arm, snapshot = self.arm.motion.state, self._robot.snapshot
        now = time.monotonic()
        dt, self._time = snapshot.time - self._time, snapshot.time
        was_silent, self._called = now - self._called > _PAUSE, now
        assert arm.setpoint is not None  # None only in the process of the simulation
        setpoint = np.array(arm.setpoint.positions)
        is_lost = np.abs(self._q - setpoint).max() > _LOST
        if dt < 0.0 or was_silent or is_lost or snapshot.is_stopped or arm.failure:
            self._begin_at(setpoint)
        self.is_ready = shares is not None and self._is_armed
        if not self.is_ready:
            self._is_armed = shares is not None and not shares.any()
            self._level = 0.0
        elif not shares.any():
            self._level = 0.0
        elif dt > 0.0:  # not while time is paused
            self._level = min(1.0, self._level + dt / _START)
            self._q = self._moved(self._level * shares, min(dt, _LONGEST), setpoint)
        return self._q.copy()

    def _begin_at(self, setpoint: Array) -> None:
        self._q, self._is_armed = setpoint, False
        carrier = self.arm.chain.base
        self._R_carrier_root = self._robot.pose(carrier).matrix[:3, :3].T

    def _moved(self, shares: Array, dt: float, setpoint: Array) -> Array:
        """Return the positions after a step, or those now if there is none."""
        q, kinematics = self._q, self._kinematics
        T = self.arm.chain.forward(q[None]).T_base_tip[0]
        R = T[:3, :3] if self._frame == "tool" else self._R_carrier_root
        parts = shares.reshape(2, 3)  # a diagonal is not faster than an axis
        parts = parts / np.linalg.norm(parts, axis=1, keepdims=True).clip(min=1.0)
        linear, angular = (parts * self._speed.reshape(2, 3) * dt) @ R.T
        limit = FASTEST * kinematics.fastest * dt
        lead = np.maximum(LEAD, np.abs(q - setpoint))
        lower, upper = np.minimum(kinematics.lower, q), np.maximum(kinematics.upper, q)
        share = 1.0
        for _ in range(_TRIES):
            T_next = T.copy()
            T_next[:3, 3] += share * linear
            T_next[:3, :3] = from_rotation_vectors(share * angular[None])[0] @ T[:3, :3]
            found = kinematics.refined(q[None], T_next)
            excess = np.abs(found - q).max(axis=0, initial=0.0) / limit
            if not len(found):
                share *= 0.5
            elif excess.max() > 1.0:
                share *= 0.9 / float(excess.max())
            else:
                is_allowed = (np.abs(found[0] - setpoint) <= lead).all() and (
                    (lower <= found[0]) & (found[0] <= upper)
                ).all()
                return np.asarray(found[0]) if is_allowed else q
        return q
