"""Wrenches of tools on their flanges, for many copies of a robot (``wrench.c``)."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, Structure, c_double, c_int32
from typing import NamedTuple, final

import numpy as np

from tool0.hardware.tool_dynamics import ToolForces, ToolTable
from tool0.kernel.drives import Body, native_bodies
from tool0.kernel.memory import Addresses, FloatArray, address


class _Part(Structure):
    _fields_ = (
        ("body", c_int32),
        ("unused", c_int32),
        ("mass", c_double),
        ("center", c_double * 3),
        ("tensor", c_double * 9),
    )


class _Tool(Structure):
    _fields_ = (
        ("n_bodies", c_int32),
        ("n_parts", c_int32),
        ("carrier", c_int32),
        ("unused", c_int32),
        ("dt", c_double),
        ("rise", c_double * 3),
        ("flange", c_double * 12),
        ("bodies", POINTER(Body)),
        ("parts", POINTER(_Part)),
    )


class ToolWrenches(NamedTuple):
    """Wrenches of a tool in k physics steps, without contact wrenches."""

    wrench: FloatArray
    """Force [N] and torque [N·m] at the flange and in its axes, shape (k, 6)."""
    in_root: FloatArray
    """The wrench in the axes of the root, shape (k, 6)."""
    flange: FloatArray
    """Frames of the flange in the root, shape (k, 12)."""

    def forces(self, number: int) -> ToolForces:
        """Return the wrench in one step, without contact wrenches."""
        fx, fy, fz, tx, ty, tz = self.in_root[number].tolist()
        flange = tuple(self.flange[number].tolist())
        return ToolForces((fx, fy, fz), (tx, ty, tz), flange)


@final
class ToolForcesKernel:
    """Computation of wrenches that are bit-identical to ``ToolDynamics.forces``."""

    def __init__(
        self,
        compiled: ctypes.CDLL,
        table: ToolTable,
        joints: Sequence[int],
        dt: float,
    ) -> None:
        """Copy the constants of the tool.

        Args:
            compiled: The kernel.
            table: Constants of ``ToolDynamics``.
            joints: Joint numbers, in the engine, of the bodies in ``table``.
            dt: Length of a physics step [s].
        """
        n = len(table.bodies)
        parts = [
            _Part(n if part.body < 0 else part.body, 0, *part[1:])
            for part in table.parts
        ]
        self._tool = _Tool(
            *(n, len(parts), n if table.carrier < 0 else table.carrier, 0, dt),
            *(table.rise, table.flange, native_bodies(table.bodies, joints)),
            (_Part * len(parts))(*parts),
        )
        self._at = ctypes.byref(self._tool)
        self._forces = compiled.tool0_tool_forces
        self._forces.restype = None
        self._found = ToolWrenches(*np.empty((3, 0, 0)))

    def of_steps(self, steps: Addresses) -> ToolWrenches:
        """Return the wrenches in k physics steps.

        ``steps``, shape (k, 3), contains three addresses per step: those of the
        positions and velocities before the step, and that of the velocities after the
        step.  The values are in the engine's order.  The next call overwrites the
        result.
        """
        k = len(steps)
        if k != len(self._found.wrench):
            self._found = ToolWrenches(*(np.empty((k, m)) for m in (6, 6, 12)))
            self._to = [address(self._found[j]) for j in (1, 2, 0)]
        steps = np.ascontiguousarray(steps)
        self._forces(self._at, address(steps), k, *self._to)
        return self._found
