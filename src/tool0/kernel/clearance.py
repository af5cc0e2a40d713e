"""Clearance checks between shapes, and the search for a collision-free path."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Sequence
from ctypes import (
    Structure,
    byref,
    c_double,
    c_int32,
    c_int64,
    c_size_t,
    c_uint32,
    c_uint64,
)
from enum import IntEnum
from typing import Any, Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.hardware.shape_memory import ShapeMemory
from tool0.kernel.memory import FloatArray, IntArray

MOST_MOVING: Final = 24
"""Largest number of joints that a plan can move."""
FREE: Final = -1
TILTED: Final = -2
"""Value that is returned instead of a pair of shapes if the tool is tilted."""


class Ended(IntEnum):
    """Reason why a search ended."""

    FOUND = 0
    NO_WAY = 1
    """The search trees were full, and no path was found."""
    TIMEOUT = 2
    CANCELLED = 3
    NO_MEMORY = 4


class _Clearances(Structure):
    _fields_ = (
        ("n_joints", c_int32),
        ("n_pairs", c_int32),
        ("tool", c_int32),
        ("calls", c_int64),
        ("poses", c_int64),
        ("kinematics", c_size_t),
        ("distance", c_size_t),
        ("model", c_size_t),
        ("data", c_size_t),
        ("position", c_size_t),
        ("addresses", c_size_t),
        ("centres", c_size_t),
        ("rotations", c_size_t),
        ("axes", c_size_t),
        ("anchors", c_size_t),
        ("axis_rows", c_size_t),
        ("moved_by", c_size_t),
        ("sliding", c_uint32),
        ("tilting", c_uint32),
        ("bodies", c_size_t),
        ("radii", c_size_t),
        ("boxes", c_size_t),
        ("first", c_size_t),
        ("second", c_size_t),
        ("least", c_size_t),
        ("reach", c_size_t),
        ("up", c_size_t),
        ("tool_axis", c_size_t),
        ("tilt", c_double),
        ("slack", c_double),
        ("rates", c_size_t),
        ("until", c_size_t),
        ("looks", c_size_t),
        ("heap", c_size_t),
        ("suspect", c_int32),
    )


class _Search(Structure):
    _fields_ = (
        ("start", c_size_t),
        ("goals", c_size_t),
        ("n_goals", c_int32),
        ("most_nodes", c_int32),
        ("lower", c_size_t),
        ("upper", c_size_t),
        ("beside", c_double),
        ("range", c_double),
        ("deadline", c_double),
        ("seed", c_uint64),
        ("cancelled", c_size_t),
        ("samples", c_int64),
    )


class Pairs(NamedTuple):
    """Pairs of shapes that must stay apart."""

    first: IntArray
    second: IntArray
    """Numbers of the shapes of each pair.  The second shape of a pair is the larger
    shape, or a plane."""
    least: FloatArray
    """Smallest allowed distance between the shapes of each pair [m]."""
    reach: FloatArray
    """Largest relative motion of points on the shapes of a pair per unit motion of each
    joint [m/rad], shape (n, n_joints)."""


class Joints(NamedTuple):
    """Joints that a plan moves, from base to tip."""

    addresses: IntArray
    """Index of each joint in the engine's positions."""
    axis_rows: IntArray
    """Row of each joint in the engine's axes."""
    sliding: int
    """Bit mask of the prismatic joints."""
    moved_by: NDArray[np.uint32]
    """For each shape of the engine, the bit mask of the joints that move it."""


class Upright(NamedTuple):
    """A tool that must not tilt."""

    body: int
    axis: FloatArray
    """Axis of the tool in the body's frame, shape (3,)."""
    up: FloatArray
    """Required direction of ``axis`` in the world, shape (3,)."""
    tilt: float
    """Largest allowed angle between ``axis`` and ``up`` [rad]."""
    tilting: int
    """Bit mask of the joints that rotate the tool."""


class Violation(NamedTuple):
    """Pair of shapes that are too close on a path, and the location on the path."""

    pair: int
    """Number of the pair, or ``TILTED``."""
    row: int
    """Row of the last pose of the path before the violation."""
    part: float
    """Fraction of the segment from the pose ``row`` to the next pose."""


class Found(NamedTuple):
    """Result of a search."""

    ended: Ended
    way: FloatArray
    """Poses of the path [rad | m], shape (n, n_joints)."""
    samples: int


@final
class Cancelled:
    """Flag with which another thread can end a search."""

    def __init__(self) -> None:
        self._flag = c_int32(0)

    def set(self) -> None:
        self._flag.value = 1

    def __bool__(self) -> bool:
        """Return whether the flag is set."""
        return bool(self._flag.value)

    @property
    def address(self) -> int:
        return ctypes.addressof(self._flag)


@final
class Clearances:
    """Checker of poses and paths of a group of joints.

    Only one thread at a time may use a checker.
    """

    def __init__(
        self,
        compiled: ctypes.CDLL,
        memory: ShapeMemory,
        joints: Joints,
        pairs: Pairs,
        *,
        slack: float,
        upright: Upright | None = None,
    ) -> None:
        """Prepare the check of ``pairs``.

        Args:
            compiled: The kernel.
            memory: Memory of the engine.
            joints: Joints that move.
            pairs: Pairs of shapes.  The distances ``least`` must include ``slack``.
            slack: Smallest distance by which the check of a motion advances [m].
            upright: The tool that must be kept upright, if any.
        """
        self.n_joints = len(joints.addresses)
        if self.n_joints > MOST_MOVING:
            raise ValueError(f"{self.n_joints} joints; {MOST_MOVING} is the most")
        self._compiled = compiled
        n_pairs = len(pairs.first)
        struct = self._struct = _Clearances(
            n_joints=self.n_joints,
            n_pairs=n_pairs,
            tool=-1,
            sliding=joints.sliding,
            slack=slack,
        )
        arrays: dict[str, NDArray[Any]] = {
            name: getattr(memory, name)
            for name in memory._fields
            if isinstance(getattr(memory, name), np.ndarray)
        }
        arrays |= {
            "addresses": np.ascontiguousarray(joints.addresses, dtype=np.int32),
            "axis_rows": np.ascontiguousarray(joints.axis_rows, dtype=np.int32),
            "moved_by": np.ascontiguousarray(joints.moved_by, dtype=np.uint32),
            "first": np.ascontiguousarray(pairs.first, dtype=np.int32),
            "second": np.ascontiguousarray(pairs.second, dtype=np.int32),
            "least": np.ascontiguousarray(pairs.least),
            "reach": np.ascontiguousarray(pairs.reach),
            "rates": np.zeros(max(n_pairs, 1)),
            "until": np.zeros(max(n_pairs, 1)),
            "looks": np.zeros(max(n_pairs, 1), dtype=np.int32),
            "heap": np.zeros(max(n_pairs, 1), dtype=np.int32),
        }
        if upright is not None:
            struct.tool, struct.tilt = upright.body, upright.tilt
            struct.tilting = upright.tilting
            arrays |= {
                "up": np.ascontiguousarray(upright.up),
                "tool_axis": np.ascontiguousarray(upright.axis),
            }
        for name, array in arrays.items():
            setattr(struct, name, array.ctypes.data)
        for name in ("kinematics", "distance", "model", "data"):
            setattr(struct, name, getattr(memory, name))
        self._alive = (memory, arrays)

    @property
    def poses(self) -> int:
        """Number of poses that have been checked."""
        return int(self._struct.poses)

    def at(self, q: FloatArray) -> int:
        """Return FREE, TILTED, or a pair that is too close, in a pose (n_joints,)."""
        q = _packed(q)
        return int(self._compiled.tool0_clearances_at(self._ref, _at(q)))

    def distances(self, q: FloatArray, most: float) -> FloatArray:
        """Return the distance of each pair in a pose [m], limited to ``most``."""
        q, found = _packed(q), np.empty(self._struct.n_pairs)
        self._compiled.tool0_clearances_all(
            self._ref, _at(q), c_double(most), _at(found)
        )
        return found

    def along(self, poses: FloatArray) -> Violation | None:
        """Return the first violation on straight segments through poses, or None."""
        poses, row, part = _packed(poses), c_int32(), c_double()
        found = self._compiled.tool0_clearances_along(
            self._ref, _at(poses), len(poses), byref(row), byref(part)
        )
        return None if found == FREE else Violation(found, row.value, part.value)

    def search(
        self,
        start: FloatArray,
        goals: FloatArray,
        samples: tuple[FloatArray, FloatArray],
        *,
        beside: float,
        seed: int,
        longest: float,
        most_nodes: int,
        timeout: float,
        cancelled: Cancelled,
    ) -> Found:
        """Search for a path by RRT-Connect.

        Args:
            start: A free pose, shape (n_joints,).
            goals: Free poses, shape (n, n_joints).
            samples: Lower and upper bounds of the samples, each of shape (n_joints,).
            beside: Distance by which most samples may be outside the range between the
                start and a goal [rad].
            seed: Seed of the samples.
            longest: Length of the longest extension step of a tree [rad].
            most_nodes: Largest number of nodes of a tree.
            timeout: Wall time after which the search ends [s].
            cancelled: Flag that ends the search.
        """
        arrays = [_packed(item) for item in (start, goals, *samples)]
        way = np.empty((2 * most_nodes, self.n_joints))
        names = ("start", "goals", "lower", "upper")
        setup = _Search(
            n_goals=len(goals),
            most_nodes=most_nodes,
            beside=beside,
            range=longest,
            deadline=time.clock_gettime(time.CLOCK_MONOTONIC) + timeout,
            seed=seed,
            cancelled=cancelled.address,
        )
        for name, array in zip(names, arrays, strict=True):
            setattr(setup, name, array.ctypes.data)
        n_way = c_int32()
        ended = Ended(
            self._compiled.tool0_search(self._ref, byref(setup), _at(way), byref(n_way))
        )
        if ended is Ended.NO_MEMORY:
            raise MemoryError
        return Found(ended, way[: n_way.value].copy(), setup.samples)

    def shorten(
        self,
        way: FloatArray,
        *,
        tries: int,
        seed: int,
        timeout: float = math.inf,
        cancelled: Cancelled,
    ) -> FloatArray:
        """Return a path in which detours are replaced by straight parts.

        The method first removes poses that are not needed.  Then the method tries to
        replace ``tries`` random parts of the path.
        """
        most = 2 * len(way) + 16
        room = np.empty((most, self.n_joints))
        room[: len(way)] = way
        n = self._compiled.tool0_shorten(
            self._ref,
            _at(room),
            len(way),
            most,
            tries,
            c_uint64(seed),
            c_double(time.clock_gettime(time.CLOCK_MONOTONIC) + timeout),
            c_size_t(cancelled.address),
        )
        return room[:n].copy()

    @property
    def _ref(self) -> object:
        return byref(self._struct)


def _packed(values: FloatArray | Sequence[float]) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)


def _at(array: FloatArray) -> c_size_t:
    return c_size_t(array.ctypes.data)
