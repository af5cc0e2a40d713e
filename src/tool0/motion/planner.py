"""Planner of an arm's motion through a sequence of moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from tool0.description.transform_arrays import matrix_of
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.blend import TURN_RATIO, BlendPath, has_arc
from tool0.motion.circle import CirclePath
from tool0.motion.line import LinePath
from tool0.motion.moves import Move, MoveError, MovePlan, MoveWarning, Tail
from tool0.motion.path import Cubics, Path
from tool0.motion.profile import SpeedProfile, ramp
from tool0.motion.rules import UR_RULES, MoveRules
from tool0.motion.segments import JointSegment, PathSegment, ToolSegment, passage
from tool0.motion.timing import ArmLimits, TimedSegment, is_straight, timed_segment
from tool0.motion.tool_path import ToolOfArm

_SMALLEST_MOVE = 1e-7
"""Length below which a move has no effect [m, rad]."""
_ENTRY_SPEEDS = (1.0, 0.7, 0.4, 0.2)
"""Fractions of a move's speed that the planner tries directly after a blend."""
_EXCESS = 1.0 + 1e-6
_ROUNDING = 1e-6
_SAME_TIME = 1e-7
"""Time between two knots below which the knots are merged [s]."""
_BLEND_KNOTS = 9
_CONSTANT_SPEED = ("process", "servo_circular")


@final
class MovePlanner:
    """Plans moves of one arm."""

    def __init__(
        self,
        kinematics: InverseKinematics,
        tcp: Sequence[float] = (0.0,) * 6,
        T_base_frame: Array | None = None,
        *,
        rules: MoveRules = UR_RULES,
    ) -> None:
        """Prepare to plan moves of a tool.

        Args:
            kinematics: The arm's kinematics.
            tcp: Pose of the TCP in the flange's frame, p[x, y, z, rx, ry, rz].
            T_base_frame: Pose of the frame in which all poses are specified, relative
                to the arm's base link; by default, the frame is the base link.
            rules: Rules for planning the moves.
        """
        self._kinematics = kinematics
        self._T_base_frame = np.eye(4) if T_base_frame is None else T_base_frame
        self._tool = ToolOfArm(
            kinematics=kinematics,
            T_tip_tool=matrix_of(tcp),
            T_root_base=np.asarray(np.linalg.inv(self._T_base_frame)),
            rules=rules,
        )
        self._limits = ArmLimits(kinematics.chain.joints, rules)

    def plan(self, start: Sequence[float] | Array, moves: Sequence[Move]) -> MovePlan:
        """Return the motion from rest at ``start`` [rad] through all moves.

        Raises:
            UnreachableError: If a move is impossible; the error contains the move's
                number and the reason.
        """
        return self._planned(None, np.array(start, dtype=np.float64), moves)

    def resume(
        self, plan: MovePlan, time: float, moves: Sequence[Move]
    ) -> MovePlan | None:
        """Return the motion that leaves ``plan`` at a path time to blend into moves.

        Time 0 of the new motion is the path time at which it leaves ``plan``. The path
        time must be within the last blend radius of the plan. The result is None if it
        is too late for a blend; the moves then start from rest at the end of the plan.

        Raises:
            UnreachableError: If a move is impossible; the error contains the move's
                number and the reason.
        """
        tail = plan.tail
        if tail is None or time >= plan.duration:
            return None
        if time < tail.entry - _ROUNDING:
            raise ControlError(
                f"the plan can be left from {tail.entry:.6f} s on, not at {time:.6f} s"
            )
        x, speed, _ = tail.brake.at(np.array([max(time - tail.entry, 0.0)]))[0]
        remaining = tail.remaining - float(x)
        if remaining < _ROUNDING or speed < _ROUNDING:
            return None
        rest = tail._replace(remaining=remaining, speed=float(speed), entry=0.0)
        return self._planned(rest, plan.end, moves)

    def _planned(self, tail: Tail | None, q: Array, moves: Sequence[Move]) -> MovePlan:
        """Plan from rest at ``q``, or from the tail of a motion that ends at ``q``."""
        at_rest = Cubics(np.zeros(1), q[None], np.zeros((1, 6)))
        record = _Record(at_rest if tail is None else _entry(tail))
        begins: list[float] = []
        zones: list[float] = []
        warnings: list[MoveWarning] = []
        for number, move in enumerate(moves, 1):
            try:
                segment = self._segment(q, move)
                begins.append(record.time)
                if segment is None:
                    zones.append(record.time)
                    continue
                timed = None
                if tail is not None:
                    blended = self._blended(segment, move, tail)
                    if blended is None:
                        text = "cannot be blended"
                        warnings.append(MoveWarning(number, move, "stop", text))
                        record.add(_braking(tail))
                        begins[-1] = record.time
                    else:
                        pieces, timed = blended
                        for piece in pieces:
                            record.add(piece)
                if timed is None:
                    timed = timed_segment(segment, move, None, self._limits)
            except UnreachableError as error:
                raise MoveError(number, move, error) from None
            warnings += [
                MoveWarning(number, move, *warning) for warning in timed.warnings
            ]
            record.add(timed.motion)
            zones.append(record.time)
            tail, q = self._tail(move, timed, record.time), timed.segment.end
        if tail is not None:
            record.add(_braking(tail))
        return MovePlan(
            path=record.path(self._kinematics.chain.joint_names),
            begins=tuple(begins),
            zones=tuple(zones),
            warnings=tuple(warnings),
            tail=tail,
        )

    def _tail(self, move: Move, timed: TimedSegment, time: float) -> Tail | None:
        if timed.zone_out == 0.0:
            return None
        return Tail(
            segment=timed.segment,
            kind=move.kind,
            radius=timed.radius,
            remaining=timed.zone_out,
            speed=timed.speed_out,
            acceleration=timed.acceleration,
            T_tip_tool=self._tool.T_tip_tool,
            entry=time,
        )

    # ---- paths of moves -------------------------------------------------------------

    def _segment(self, q: Array, move: Move) -> PathSegment | None:
        """Return the path of a move from rest at ``q``; None if the target is ``q``."""
        if move.kind == "joint":
            end = self._joint_target(q, move)
            if np.abs(end - q).max() < _SMALLEST_MOVE:
                return None
            return JointSegment(self._tool, q, end)
        start = self._tool.pose(q[None])[0]
        if move.q is None:
            end = self._pose(move.pose)
        else:
            end = self._tool.pose(np.array([move.q]))[0]
        path: LinePath | CirclePath
        if move.kind == "circular":
            via = self._pose(move.via)[:3, 3]
            path, turn = CirclePath(start, via, end, mode=move.mode), 0.0
        else:
            path = LinePath(start, end)
            turn = path.angle
        if max(path.length, turn / TURN_RATIO) < _SMALLEST_MOVE:
            return None
        length = max(path.length, turn / move.turn_ratio)
        return ToolSegment(self._tool, path, q, length)

    def _joint_target(self, q: Array, move: Move) -> Array:
        kinematics = self._kinematics
        if move.q is None:
            T = self._pose(move.pose) @ np.linalg.inv(self._tool.T_tip_tool)
            positions = kinematics.solutions(T, q)[0].positions
            return np.array([positions[name] for name in kinematics.chain.joint_names])
        target = np.array(move.q, dtype=np.float64)
        outside = (target < kinematics.lower - _ROUNDING) | (
            target > kinematics.upper + _ROUNDING
        )
        if outside.any():
            k = int(outside.argmax())
            raise UnreachableError(
                f"joint '{kinematics.chain.joint_names[k]}' cannot be at "
                f"{target[k]:.4f} rad: its limits are [{kinematics.lower[k]:.4f}, "
                f"{kinematics.upper[k]:.4f}]"
            )
        return target

    def _pose(self, pose: Sequence[float] | None) -> Array:
        """Convert a pose of the TCP to the frame of the arm's base link."""
        assert pose is not None  # ``Move`` checks it
        return np.asarray(self._T_base_frame @ matrix_of(pose))

    # ---- blends between moves -------------------------------------------------------

    def _blended(
        self, segment: PathSegment, move: Move, tail: Tail
    ) -> tuple[list[Cubics], TimedSegment] | None:
        """Return the blend from a tail into a segment, and the segment after the blend.

        The result is None if the joints cannot follow any blend, so that the arm must
        stop at the waypoint.
        """
        is_arc = (
            tail.kind in _CONSTANT_SPEED
            and move.kind in _CONSTANT_SPEED
            and is_straight(tail.segment)
            and is_straight(segment)
            and has_arc(_direction(tail.segment), _direction(segment))
        )
        joints = (
            isinstance(tail.segment, JointSegment) and isinstance(segment, JointSegment)
        ) or not np.array_equal(tail.T_tip_tool, self._tool.T_tip_tool)
        for entry in _ENTRY_SPEEDS:
            timed = timed_segment(
                segment, move, tail, self._limits, entry=entry, is_symmetric=is_arc
            )
            if timed.speed_in <= 0.0:
                return None
            try:
                if joints:
                    pieces = [self._joint_blend(tail, timed)]
                elif is_arc:
                    pieces = self._arc(tail, timed)
                else:
                    pieces = [self._tool_blend(tail, timed)]
            except UnreachableError:
                return None
            if all(max(self._limits.excess(p)[:2]) <= _EXCESS for p in pieces):
                return pieces, timed
        return None

    def _joint_blend(self, tail: Tail, timed: TimedSegment) -> Cubics:
        """Return a cubic blend of the joints; the mean speed defines its duration."""
        start = _entry(tail)
        q, rate = timed.segment.at(np.array([timed.zone_in]))
        ends = np.stack([start.q[0], q[0]])
        speeds = np.stack([start.qd[0], rate[0] * timed.speed_in])
        ways = np.linalg.norm(ends - tail.segment.end, axis=1).sum()
        duration = 2.0 * float(ways / np.linalg.norm(speeds, axis=1).sum())
        cubic = Cubics(np.array([0.0, duration]), ends, speeds)
        motion = cubic.at(np.linspace(0.0, duration, _BLEND_KNOTS))
        kinematics = self._kinematics
        if ((motion.q < kinematics.lower) | (motion.q > kinematics.upper)).any():
            raise UnreachableError("a joint would leave its limits in the blend")
        return motion

    def _tool_blend(self, tail: Tail, timed: TimedSegment) -> Cubics:
        """Return a cubic blend of the tool; the mean speed defines its duration."""
        x = tail.segment.length - tail.remaining
        start = tail.segment.tool_state(x, tail.speed)
        end = timed.segment.tool_state(timed.zone_in, timed.speed_in)
        waypoint = timed.segment.tool_state(0.0, 1.0).T
        path = BlendPath(start, end, waypoint)
        return self._along(path, tail, timed, SpeedProfile.steady(path.duration))

    def _arc(self, tail: Tail, timed: TimedSegment) -> list[Cubics]:
        """Return an arc between two lines, after the remainder of the first line."""
        first = tail.segment
        x = first.length - tail.remaining
        rest = tail.remaining - timed.zone_in
        path = BlendPath(
            first.tool_state(first.length - timed.zone_in, tail.speed),
            timed.segment.tool_state(timed.zone_in, timed.speed_in),
            timed.segment.tool_state(0.0, 1.0).T,
            is_arc=True,
        )
        profile = ramp(path.length, tail.speed, timed.speed_in)
        entry = tail._replace(remaining=timed.zone_in)
        pieces = [self._along(path, entry, timed, profile)]
        if rest > _ROUNDING:
            pieces.insert(0, passage(first, ramp(rest, tail.speed, tail.speed), x))
        return pieces

    def _along(
        self, path: BlendPath, tail: Tail, timed: TimedSegment, profile: SpeedProfile
    ) -> Cubics:
        """Return the motion of the joints along a blend."""
        start, length = _entry(tail).q[0], float(profile.distances[-1])
        motion = passage(ToolSegment(self._tool, path, start, length), profile)
        end, _ = timed.segment.at(np.array([timed.zone_in]))
        if np.abs(motion.q[-1] - end[0]).max() > _ROUNDING:
            raise UnreachableError("the blend ends in another posture")
        return motion


@final
class _Record:
    """A list of consecutive motions."""

    def __init__(self, start: Cubics) -> None:
        self._parts = [start]
        self.time = 0.0
        """Time at the end of the recorded motions [s]."""

    def add(self, motion: Cubics) -> None:
        times, q, qd = motion
        self._parts.append(Cubics(self.time + times[1:], q[1:], qd[1:]))
        self.time += float(times[-1])

    def path(self, joint_names: tuple[str, ...]) -> Path:
        times, q, qd = (np.concatenate(rows) for rows in zip(*self._parts, strict=True))
        # Phases can be shorter than the resolution of simulated time.
        keep = np.append(np.diff(times) > _SAME_TIME, True)
        keep[0] = True
        return Path(
            joint_names=joint_names,
            times=times[keep],
            positions=q[keep],
            velocities=qd[keep],
        )


def _entry(tail: Tail) -> Cubics:
    """Return the motion at the beginning of a tail."""
    q, rate = tail.segment.at(np.array([tail.segment.length - tail.remaining]))
    return Cubics(np.zeros(1), q, rate * tail.speed)


def _braking(tail: Tail) -> Cubics:
    """Return the motion that stops at the waypoint."""
    return passage(tail.segment, tail.brake, tail.segment.length - tail.remaining)


def _direction(line: PathSegment) -> Array:
    """Return the direction of a line, shape (3,); its length is arbitrary."""
    return line.tool_state(0.0, 1.0).V[:3]
