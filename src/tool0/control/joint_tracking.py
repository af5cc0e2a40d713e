"""Joints of a trajectory controller: desired and measured motion, and PID control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

from tool0.control.law import TrajectoryLaw
from tool0.control.parameters import Pid
from tool0.control.sampler import GoalMonitor, TrajectorySampler
from tool0.control.spline import JointSpline, hold
from tool0.control.trajectory import Setpoint
from tool0.control.trajectory_monitor import TrajectoryMonitor
from tool0.description.model import Joint, JointType, shortest_turn
from tool0.hardware.engine import JointState, joint_selector
from tool0.protocol.controllers import Gains


@final
class JointTracking:
    """Splines that joints follow, with a PID and feed-forward if gains are given.

    The controller determines which splines are followed, when they start, and when they
    end.
    """

    def __init__(
        self,
        joints: tuple[Joint, ...],
        gains: Sequence[Gains],
        velocity_ff: Sequence[float],
        indices: Sequence[int],
        state: JointState,
    ) -> None:
        """Hold the measured positions.

        Args:
            joints: The joints of the controller.
            gains: Gains, one per joint; if there are none, the desired positions are
                commanded.
            velocity_ff: Feed-forward factors from desired velocity to command, one per
                joint; the sequence may be empty.
            indices: Indices of the joints in the lists of a state.
            state: Measured state.
        """
        self.joints = joints
        self.select = joint_selector(indices)
        self.pid = Pid(gains) if gains else None
        self.state = state
        """Measured state of the last tick."""
        self._wrapping = [
            k for k, joint in enumerate(joints) if joint.type is JointType.CONTINUOUS
        ]
        self.set_feed_forward(velocity_ff)
        held = [hold(state.time, q) for q in self.select(state.position)]
        self.sampler = TrajectorySampler(held, state.time)

    def set_feed_forward(self, velocity_ff: Sequence[float]) -> None:
        """Change the feed-forward factors, one per joint or none."""
        self.feed_forward = velocity_ff if any(velocity_ff) else ()

    def follow(self, splines: Sequence[JointSpline], time: float) -> None:
        """Follow other splines, which are first sampled at ``time`` [s]."""
        self.sampler = TrajectorySampler(splines, time)

    def merged(self, splines: Mapping[int, JointSpline]) -> list[JointSpline]:
        """Return the splines of all joints.

        ``splines`` replaces the splines of some joints, by index.
        """
        return [splines.get(k, old) for k, old in enumerate(self.sampler.splines)]

    def errors(self, time: float) -> tuple[list[float], list[float]]:
        """Return the position errors and velocity errors (desired minus measured)."""
        position, velocity = self.state.position, self.state.velocity
        select = self.select
        errors, rates = self.sampler.errors(time, select(position), select(velocity))
        for k in self._wrapping:
            errors[k] = shortest_turn(0.0, errors[k])
        return errors, rates

    def law(self, monitor: GoalMonitor | TrajectoryMonitor | None) -> TrajectoryLaw:
        """Return the law with which the joints follow the splines until an event."""
        return TrajectoryLaw(
            self.sampler, monitor, self.pid, self.feed_forward, self._wrapping
        )

    def setpoint(self, *, lag: float = 0.0, speed_scaling: float = 1.0) -> Setpoint:
        """Return the setpoints of the joints; ``Setpoint`` documents ``lag`` [s]."""
        return Setpoint(
            self.joints,
            self.sampler.splines,
            self.select,
            self.state,
            lag,
            speed_scaling,
        )
