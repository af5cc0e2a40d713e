"""External wrench on an arm's tool: computed on request, filtered and tared."""

from __future__ import annotations

import math
from typing import Final, final

from tool0.description.model import RobotModel
from tool0.description.payload import Payload
from tool0.description.payload_bodies import payload_inertia, tool_inertia
from tool0.description.scene_state import Contact, Wrench
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.tool_dynamics import ToolDynamics
from tool0.protocol.sensors import DEFAULT_CUTOFF

NO_WRENCH: Final[Wrench] = (0.0,) * 6


@final
class ToolWrench:
    """External force and torque on a tool at its flange, in the flange's axes.

    As on a UR, the payload is subtracted: the payload that was set or, by default,
    the tool in the description. The filter has two poles at ``DEFAULT_CUTOFF``. Any
    time may pass between two readings, because the wrench is computed only when it is
    read.
    """

    def __init__(self, model: RobotModel, flange: str, engine: Engine) -> None:
        self._flange = flange
        self._tool = tool_inertia(model, flange)
        self._dynamics = ToolDynamics(model, flange, engine.world.gravity)
        names = engine.joint_names
        self._order = [names.index(joint.name) for joint in model.movable_joints]
        self._dt = engine.dt
        self._offset: Wrench = NO_WRENCH
        self._passed: list[tuple[float, float]] = []
        """Outputs of the filter's first and second pole before the tare."""
        self._time = -math.inf
        self.subtract(None)

    def subtract(self, payload: Payload | None) -> None:
        """Subtract another payload from now on; None selects the description's tool."""
        inertia = self._tool if payload is None else payload_inertia(payload)
        self._dynamics.subtract({self._flange: inertia})

    def read(
        self, before: JointState, after: JointState, contacts: tuple[Contact, ...]
    ) -> Wrench:
        """Return the force [N] and torque [N·m] after a physics step."""
        elapsed, self._time = after.time - self._time, after.time
        if elapsed != 0.0 or not self._passed:
            raw = self._raw(before, after, contacts)
            if not self._passed or not elapsed > 0.0:
                self._passed = [(x, x) for x in raw]
            part = -math.expm1(-math.tau * DEFAULT_CUTOFF * max(elapsed, 0.0))
            passed = []
            for x, (first, second) in zip(raw, self._passed, strict=True):
                first += part * (x - first)  # noqa: PLW2901
                passed.append((first, second + part * (first - second)))
            self._passed = passed
        fx, fy, fz, tx, ty, tz = (
            second - offset
            for (_, second), offset in zip(self._passed, self._offset, strict=True)
        )
        return fx, fy, fz, tx, ty, tz

    def zero(self) -> None:
        """Tare the sensor: subtract the current reading from later readings."""
        fx, fy, fz, tx, ty, tz = (second for _, second in self._passed)
        self._offset = fx, fy, fz, tx, ty, tz

    def _raw(
        self, before: JointState, after: JointState, contacts: tuple[Contact, ...]
    ) -> Wrench:
        order, dt, was = self._order, self._dt, before.velocity
        return self._dynamics.wrench(
            [before.position[i] for i in order],
            [was[i] for i in order],
            [(after.velocity[i] - was[i]) / dt for i in order],
            contacts,
        )
