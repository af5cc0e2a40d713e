"""Memory of the kernel: structs, and arrays of laws.

The structs are those of ``laws.h`` and ``robot.h``.  Addresses are integers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from ctypes import (
    Array,
    Structure,
    addressof,
    c_char,
    c_double,
    c_int32,
    c_int64,
    c_size_t,
    c_void_p,
)
from enum import IntEnum
from typing import Any, cast, final

import numpy as np
from numpy.typing import NDArray

from tool0.control.law import (
    ActiveLaw,
    CommandLaw,
    GripperLaw,
    TrajectoryLaw,
    TrajectoryStart,
)
from tool0.control.sampler import Check, GoalMonitor, Piece
from tool0.control.spline import JointSpline, Segment, through
from tool0.control.tolerances import UNCHECKED
from tool0.control.trajectory import TrajectoryGoal
from tool0.protocol.goals import Tolerance
from tool0.protocol.trajectories import TrajectoryPoint

MOST_PIECES = 64
"""Largest number of pieces of a motion per joint.  Python continues motions with more
pieces."""
PIECE_SIZE = 16
"""Number of values of a piece."""

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]
TickCounts = NDArray[np.int64]
"""Numbers of ticks, with one element per robot."""
Addresses = NDArray[np.uintp]
"""Addresses of structs or of numbers, with one element or row per robot."""


class LawKind(IntEnum):
    """Kind of a control law."""

    TRAJECTORY = 0
    COMMAND = 1
    GRIPPER = 2


_KINDS = {
    TrajectoryLaw: LawKind.TRAJECTORY,
    CommandLaw: LawKind.COMMAND,
    GripperLaw: LawKind.GRIPPER,
}


GRIP_FIELDS = (
    "target",
    "tolerance",
    "max_effort",
    "stall_range",
    "stall_timeout",
    "ramp",
    "effort",
    "stall_position",
    "stall_since",
    "position",
    "is_unheard",
)


@final
class GripStruct(Structure):
    """Structure ``Grip`` of ``laws.h``."""

    _fields_ = tuple((name, c_double) for name in GRIP_FIELDS)


@final
class StartStruct(Structure):
    """Structure ``Start`` of ``laws.h``."""

    _fields_ = (
        ("is_known", c_int32),
        ("is_spliced", c_int32),
        ("from_desired", c_int32),
        ("reads_velocity", c_int32),
        ("may_end_moving", c_int32),
        ("has_points", c_int32),
        ("is_first", c_int32),
        ("n_points", c_int32),
        ("has_velocities", c_int32),
        ("is_following", c_int32),
        ("now", c_double),
        ("goal_time", c_double),
        ("timeout", c_double),
        ("tolerances", c_size_t),
        ("times", c_size_t),
        ("positions", c_size_t),
        ("velocities", c_size_t),
    )


@final
class StartMemory:
    """Memory of one law for the trajectory that starts in the next tick."""

    def __init__(self, n_joints: int) -> None:
        self.struct = struct = StartStruct()
        self._tolerances: FloatArray = np.zeros((n_joints, 4))
        self._times: FloatArray = np.zeros(MOST_PIECES)
        self._positions: FloatArray = np.zeros((MOST_PIECES, n_joints))
        self._velocities: FloatArray = np.zeros((MOST_PIECES, n_joints))
        struct.tolerances = self._tolerances.ctypes.data
        struct.times = self._times.ctypes.data
        struct.positions = self._positions.ctypes.data
        struct.velocities = self._velocities.ctypes.data
        self._loaded: TrajectoryStart | None = None

    def load(self, start: TrajectoryStart | None, *, has_points: bool) -> None:
        """Set the data for the start of a trajectory.

        ``has_points`` is true if the motion before the trajectory has points.
        """
        struct = self.struct
        struct.is_known, struct.has_points = start is not None, has_points
        struct.n_points = struct.is_first = 0
        if start is None or start is self._loaded:
            return
        self._loaded = start
        struct.is_spliced, struct.from_desired = start.is_spliced, start.from_desired
        struct.reads_velocity = start.reads_velocity
        struct.may_end_moving = start.may_end_moving
        struct.goal_time, struct.timeout = start.goal_time, start.timeout
        self._tolerances[:] = tolerance_rows(start.path, start.at_goal)

    def coming(self) -> tuple[TrajectoryGoal, float] | None:
        """Return the trajectory that starts next, and its command time [s]."""
        struct, n = self.struct, self.struct.n_points
        if not n:
            return None
        points = [
            TrajectoryPoint(q, qd if struct.has_velocities else None, None, time)
            for q, qd, time in zip(
                self._positions[:n].tolist(),
                self._velocities[:n].tolist(),
                self._times[:n].tolist(),
                strict=True,
            )
        ]
        return TrajectoryGoal(points=points), struct.now


def tolerance_rows(
    path: Sequence[Tolerance], at_goal: Sequence[Tolerance]
) -> list[tuple[float, ...]]:
    """Return the rows of ``Law.tolerances`` in ``laws.h``, with one row per joint."""
    return [(*one[:2], *other[:2]) for one, other in zip(path, at_goal, strict=True)]


@final
class LawStruct(Structure):
    """Structure ``Law`` of ``laws.h``."""

    _fields_ = (
        ("kind", c_int32),
        ("n", c_int32),
        ("has_pid", c_int32),
        ("is_monitored", c_int32),
        ("measures_velocity", c_int32),
        ("has_feed_forward", c_int32),
        ("max_pieces", c_int32),
        ("is_moving", c_int32),
        ("is_moving_ahead", c_int32),
        ("watches_all", c_int32),
        ("has_goal", c_int32),
        ("unused", c_int32),
        ("joints", c_size_t),
        ("wraps", c_size_t),
        ("gains", c_size_t),
        ("integrals", c_size_t),
        ("feed_forward", c_size_t),
        ("pieces", c_size_t),
        ("n_pieces", c_size_t),
        ("piece", c_size_t),
        ("piece_ahead", c_size_t),
        ("arrived", c_size_t),
        ("tolerances", c_size_t),
        ("started", c_size_t),
        ("times", c_size_t),
        ("values", c_size_t),
        ("last_errors", c_size_t),
        ("errors", c_size_t),
        ("rates", c_size_t),
        ("grip", c_size_t),
        ("bounds", c_size_t),
        ("start", c_size_t),
        ("next_change", c_double),
        ("next_change_ahead", c_double),
        ("goal_time", c_double),
        ("end", c_double),
        ("timeout", c_double),
        ("lead", c_double),
        ("since", c_double),
        ("lag", c_double),
        ("slip", c_double),
    )


@final
class RobotStruct(Structure):
    """Structure ``Robot`` of ``robot.h``."""

    _fields_ = (
        ("n_joints", c_int32),
        ("n_velocities", c_int32),
        ("n_motors", c_int32),
        ("n_laws", c_int32),
        ("n_brakes", c_int32),
        ("steps_per_tick", c_int32),
        ("steps_left", c_int32),
        ("steps", c_int64),
        ("dt", c_double),
        ("period", c_double),
        ("step", c_size_t),
        ("on_error", c_size_t),
        ("clock", c_size_t),
        ("model", c_size_t),
        ("data", c_size_t),
        ("position", c_size_t),
        ("velocity", c_size_t),
        ("motors", c_size_t),
        ("motor_joints", c_size_t),
        ("brakes", c_size_t),
        ("standstill", c_double),
        ("laws", c_size_t),
        ("drives", c_size_t),
        ("command", c_size_t),
        ("effort", c_size_t),
        ("tick_position", c_size_t),
        ("tick_velocity", c_size_t),
        ("tick_effort", c_size_t),
        ("step_position", c_size_t),
        ("step_velocity", c_size_t),
        ("step_effort", c_size_t),
    )


@final
class LawMemory:
    """Memory of one law of one robot.  The arrays have the shape (n_joints, …)."""

    def __init__(self, law: ActiveLaw, joints: Sequence[int]) -> None:
        """Allocate memory; ``joints`` contains the joint numbers in the engine."""
        k = len(joints)
        self._kind = _KINDS[type(law)]
        self.joints: IntArray = np.array(joints, dtype=np.int32)
        self.wraps: IntArray = np.zeros(k, dtype=np.int32)
        if not isinstance(law, GripperLaw):
            self.wraps[list(law.wrapping)] = 1
        self.gains: FloatArray = np.zeros((k, 11))
        self.feed_forward: FloatArray = np.zeros(k)
        self.integrals: FloatArray = np.zeros(k)
        self.pieces: FloatArray = np.zeros((k, MOST_PIECES, PIECE_SIZE))
        self.n_pieces: IntArray = np.zeros(k, dtype=np.int32)
        self.piece: IntArray = np.zeros(k, dtype=np.int32)
        self.piece_ahead: IntArray = np.zeros(k, dtype=np.int32)
        self.tolerances: FloatArray = np.zeros((k, 4))
        self.arrived: IntArray = np.zeros(k, dtype=np.int32)
        self.started: IntArray = np.zeros(k, dtype=np.int32)
        self.times: FloatArray = np.zeros((k, MOST_PIECES))
        self.values: FloatArray = np.zeros(k)
        self.last_errors: FloatArray = np.zeros(k)
        self.grip = GripStruct()
        self.start = None
        if isinstance(law, TrajectoryLaw) and law.lead:
            self.start = StartMemory(k)
        self._scratch: FloatArray = np.zeros((2, k))
        if isinstance(law, TrajectoryLaw) and law.feed_forward:
            self.feed_forward[:] = law.feed_forward
        if law.pid is not None:
            self.gains[:] = [row[1:] for row in law.pid.rows]

    def fill(self, struct: LawStruct, law: ActiveLaw) -> None:
        """Set the constants and addresses in ``struct``."""
        struct.kind, struct.n = self._kind, len(self.joints)
        struct.has_pid = law.pid is not None
        struct.max_pieces = MOST_PIECES
        struct.next_change = struct.next_change_ahead = -math.inf
        if isinstance(law, TrajectoryLaw):
            struct.has_feed_forward = bool(law.feed_forward)
        elif isinstance(law, CommandLaw):
            struct.measures_velocity = law.measures_velocity
        struct.grip = addressof(self.grip)
        if self.start is not None:
            struct.start = addressof(self.start.struct)
        for name in _ARRAYS:
            setattr(struct, name, getattr(self, name).ctypes.data)
        struct.errors = self._scratch[0].ctypes.data
        struct.rates = self._scratch[1].ctypes.data

    def started_splines(self) -> dict[int, JointSpline]:
        """Return the motions that were started by the kernel, by joint number."""
        found = {}
        for k in np.flatnonzero(self.started).tolist():
            n = self.started[k]
            segments = [
                Segment.of(piece[_ORIGIN], piece[_UNTIL], piece[_COEFFICIENTS])
                for piece in self.pieces[k, :n].tolist()
            ]
            found[k] = through(segments, self.times[k, :n].tolist())
        return found


_UNTIL, _ORIGIN, _COEFFICIENTS = 0, 1, slice(2, 8)
"""Columns of the values of a piece."""
_ARRAYS = (
    "joints",
    "wraps",
    "gains",
    "feed_forward",
    "integrals",
    "pieces",
    "n_pieces",
    "piece",
    "piece_ahead",
    "tolerances",
    "arrived",
    "started",
    "times",
    "values",
    "last_errors",
)


def packed(piece: Piece, monitor: GoalMonitor | None = None) -> tuple[float, ...]:
    """Return a piece in the kernel's format, including the checks of an active goal."""
    check, tolerance = Check.NOTHING, UNCHECKED
    if monitor is not None:
        check, tolerance = monitor.check_of(piece)
    return (
        piece.until,
        *piece.polynomial,
        check,
        tolerance.position,
        tolerance.velocity,
        piece.segment.end,
    )


_from_buffer = cast("Callable[[NDArray[Any]], Array[c_char]]", (c_char * 0).from_buffer)


def address(array: NDArray[Any]) -> Array[c_char] | c_void_p:
    """Return the address of the data of a contiguous array, for calls to the kernel."""
    try:
        return _from_buffer(array)  # takes an eighth of the time of the call below
    except TypeError:
        if array.flags.writeable:  # the array is not contiguous
            raise
        return c_void_p(array.ctypes.data)
