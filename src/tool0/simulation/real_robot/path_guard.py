"""Checks of every motion against the model before it is sent to a real robot."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from tool0.errors import CollisionError
from tool0.hardware.own_drives import WantedMotion
from tool0.kinematics.chain import ArmChain, Array
from tool0.motion.path import Path
from tool0.simulation.handlers.motion_checks import motion_plans
from tool0.simulation.simulation import Simulation

SAMPLING: Final = 0.04
"""Time between two checked postures at the start of a motion [s].  The paths between
checked postures are checked as straight lines in joint space."""
_SAMPLES: Final = 500
"""Number of postures after which the time between two postures is doubled, since the
tick waits for the check."""
_MOST_SAMPLES: Final = 6 * _SAMPLES
"""Largest number of checked postures, which covers a motion of 1260 s."""
AHEAD: Final = 0.3
"""Time for which a stream is assumed to continue unchanged [s]."""
JUMP: Final = 0.05
"""Largest distance of a joint from its position at the start of a motion [rad]."""
_ROUNDING: Final = 1e-6
_SPEED_ROUNDING: Final = 0.02
"""Relative tolerance for speeds.  The tolerance is needed because of the speed slider,
and because splines are slightly faster between their knots."""


@final
class PathGuard:
    """Checks limits, speed, jumps and collisions of the motions of one arm.

    The guard is called in the thread of the tick.  A check takes a few milliseconds;
    the robot always has motion buffered for longer than that.
    """

    def __init__(self, simulation: Simulation, arm: str) -> None:
        self._simulation = simulation
        self._chain: ArmChain = simulation.arms[arm]
        self._arm = simulation.core.arms.find(arm)
        self._plans = motion_plans(simulation)
        joints = self._chain.joints
        self._lower = np.array([joint.limits.lower for joint in joints])
        self._upper = np.array([joint.limits.upper for joint in joints])
        self._fastest = np.array([joint.max_velocity for joint in joints])
        here = np.array([self._measured()] * 2)
        here[1, -1] += 1e-3  # compiles the shapes before the first motion
        self._collision(np.array([0.0, SAMPLING]), here)

    def __call__(self, motion: WantedMotion, now: float) -> str:
        """Return the reason why a motion must not be sent, or an empty string.

        The motion starts at ``now`` [s].
        """
        times, q, qd = _sampled(motion, now)
        names = self._chain.joint_names
        off = np.abs(q[0] - self._measured())
        if not off.max() <= JUMP:
            k = int(off.argmax())
            return (
                f"the motion begins {off[k]:.3f} rad from where '{names[k]}' is: plan "
                "it from the measured pose"
            )
        beyond = np.maximum(self._lower - q, q - self._upper)
        if not beyond.max() <= _ROUNDING:
            row, k = divmod(int(beyond.argmax()), len(names))
            return (
                f"the motion moves '{names[k]}' to {q[row, k]:.3f} rad, beyond its "
                f"limits [{self._lower[k]:.3f}, {self._upper[k]:.3f}]"
            )
        state = self._arm.box.state
        most = max(state.speed_slider, state.speed_scaling) + _SPEED_ROUNDING
        speeds = np.abs(qd) / self._fastest
        if not speeds.max() <= most:
            row, k = divmod(int(speeds.argmax()), len(names))
            return (
                f"the motion moves '{names[k]}' at {abs(qd[row, k]):.2f} rad/s, "
                f"{speeds[row, k]:.0%} of its speed; the robot is limited to "
                f"{state.speed_slider:.0%}: raise the speed slider, or move more slowly"
            )
        return self._collision(times, q)

    def _collision(self, times: Array, q: Array) -> str:
        if np.ptp(q, axis=0).max() < _ROUNDING:
            return ""
        path = Path(
            joint_names=self._chain.joint_names,
            times=times,
            positions=q,
            velocities=np.zeros_like(q),
        )
        positions = {
            **self._simulation.snapshot.positions,
            **dict(zip(self._chain.joint_names, q[0].tolist(), strict=True)),
        }
        try:
            self._plans.require_free_path(path, positions)
        except CollisionError as error:
            return str(error)
        return ""

    def _measured(self) -> Array:
        core = self._simulation.core
        index = core.hardware.index
        return np.array(
            [core.state.position[index[name]] for name in self._chain.joint_names]
        )


def _sampled(motion: WantedMotion, now: float) -> tuple[Array, Array, Array]:
    """Return times [s], positions and velocities of a motion until its end."""
    times, q, qd = [], [], []
    if motion.is_streamed:
        start = motion.at(now)
        times = [0.0, AHEAD]
        here, speed = np.array(start.positions), np.array(start.velocities)
        way = np.array([here, here + AHEAD * speed])
        return np.array(times), way, np.array([speed] * 2)
    after, step = 0.0, SAMPLING
    for k in range(1, _MOST_SAMPLES + 1):
        state = motion.at(now + after)
        times.append(after)
        after += step
        step = 2.0 * step if k % _SAMPLES == 0 else step
        q.append(state.positions)
        qd.append(state.velocities)
        is_over = not any(state.velocities) and all(
            abs(a - b) < _ROUNDING
            for a, b in zip(state.positions, motion.target, strict=True)
        )
        if is_over:
            break
    return np.array(times), np.array(q), np.array(qd)
