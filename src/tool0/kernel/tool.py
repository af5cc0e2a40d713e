"""Tool kinematics of n copies of an arm, computed by the kernel (``tool.c``)."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import Structure, c_double
from typing import final

import numpy as np

from tool0.kernel.memory import FloatArray, address

_JOINTS = 6


class _Frame(Structure):
    _fields_ = (("R", c_double * 9), ("p", c_double * 3))

    @classmethod
    def of(cls, T: FloatArray) -> _Frame:
        """Return a pose, shape (4, 4), as a struct."""
        return cls((c_double * 9)(*T[:3, :3].flat), (c_double * 3)(*T[:3, 3]))


class _Arm(Structure):
    _fields_ = (
        ("base", _Frame),
        ("joints", _Frame * _JOINTS),
        ("axes", c_double * 3 * _JOINTS),
        ("tool", _Frame),
        ("damping", c_double),
    )


@final
class ToolKernel:
    """Tool kinematics of one type of arm.  Every array has one row per copy."""

    def __init__(
        self,
        compiled: ctypes.CDLL,
        *,
        base: FloatArray,
        joints: Sequence[FloatArray],
        axes: FloatArray,
        tool: FloatArray,
        damping: float,
    ) -> None:
        """Set the constants of the arm.

        Args:
            compiled: The kernel.
            base: Pose of the arm's base in the root, shape (4, 4).
            joints: Six poses, shape (4, 4): the pose of each joint at position 0 in the
                frame of the previous joint.
            axes: Axes of the joints in the frames of the joints, shape (6, 3).
            tool: Pose of the tool in the last joint, shape (4, 4).
            damping: Square of the damping of the Jacobian's inverse [m²].
        """
        self._arm = _Arm(
            _Frame.of(base),
            (_Frame * _JOINTS)(*map(_Frame.of, joints)),
            (c_double * 3 * _JOINTS)(*((c_double * 3)(*axis) for axis in axes)),
            _Frame.of(tool),
            damping,
        )
        self._at = ctypes.byref(self._arm)
        self._poses = compiled.tool0_tool_poses
        self._poses.restype = None
        self._approach = compiled.tool0_approach
        self._approach.restype = None
        self._steer = compiled.tool0_steer
        self._steer.restype = None
        self._quats = compiled.tool0_quats
        self._quats.restype = None

    def poses(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return tool positions [m], (n, 3), and rotations, (n, 3, 3), in the root."""
        q = np.ascontiguousarray(q)
        n = len(q)
        positions, rotations = np.empty((n, 3)), np.empty((n, 3, 3))
        self._poses(self._at, n, address(q), address(positions), address(rotations))
        return positions, rotations

    def approach(
        self,
        q: FloatArray,
        positions: FloatArray,
        rotations: FloatArray,
        limit: FloatArray,
    ) -> FloatArray:
        """Return joint positions that approach poses.

        See ``gym.tool.Tool.approach``.
        """
        given = [np.ascontiguousarray(a) for a in (q, positions, rotations, limit)]
        found = np.empty((len(q), _JOINTS))
        self._approach(self._at, len(q), *map(address, given), address(found))
        return found

    def steered(
        self, q: FloatArray, moves: FloatArray, lowest: float, limit: FloatArray
    ) -> FloatArray:
        """Return joint positions after tool moves; see ``gym.tool.Tool.steered``."""
        q, moves = np.ascontiguousarray(q), np.ascontiguousarray(moves)
        found = np.empty((len(q), _JOINTS))
        self._steer(
            *(self._at, len(q), address(q), address(moves), ctypes.c_double(lowest)),
            *(address(limit), address(found)),
        )
        return found

    def quats(self, rotations: FloatArray) -> FloatArray:
        """Return rotations, (n, 3, 3), as quaternions (w, x, y, z), (n, 4).

        The components w are not negative.
        """
        rotations = np.ascontiguousarray(rotations)
        found = np.empty((len(rotations), 4))
        self._quats(len(rotations), address(rotations), address(found))
        return found
