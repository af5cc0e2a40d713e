"""Moves of an arm for URScript's functions and ur_rtde's commands.

Moves are planned in this process and sent as paths. The call for a move with a blend
radius returns shortly before the tool enters this radius around the target. The next
move then replaces the remaining path. If no move is received in time, the arm stops at
the target.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar, cast, final

import numpy as np

from tool0.errors import ControlError
from tool0.kinematics.chain import Array
from tool0.motion.moves import Move, MovePlan, MoveWarning
from tool0.motion.planner import MovePlanner
from tool0.protocol.arm_motion import (
    ServoJoints,
    SpeedJoints,
    SpeedTool,
    StopArm,
    path_request,
)
from tool0.ur.pacer import CATCH_UP, Pacer

if TYPE_CHECKING:
    from tool0.protocol.state import Six
    from tool0.ur.control_box import UrControlBox

logger = logging.getLogger(__name__)
T = TypeVar("T")

LEAD: Final = (0.012, 0.03, 0.1)
"""Time between the return of a move's call and its blend, in which the next move is
planned and sent: minimum, initial and maximum value [s]. The time adapts to the
measured duration of planning and sending."""
_MARGIN: Final = 0.01
"""Time between the last update and the time at which a path is replaced [s]. The time
increases after failures."""
_FIRST_KNOT: Final = 0.002
"""Time of the first knot of a path that replaces another one [s]."""
_LEAD_FACTOR: Final = 1.5
_LEAD_DECAY: Final = 0.8
_ATTEMPTS: Final = 4
_SHOWN_WARNINGS: Final = 5
_ROUNDING: Final = 1e-9
_UNFINISHED: Final = 1e-6
"""Remaining time of a path at its end above which the path was stopped [s]."""
OWN_STREAM: Final = 1e6
"""Timeout of streams of the control box's own programs [wall s]. The timeout is
practically infinite, because a program may pause between two commands, and no external
client can disconnect."""
MAX_ACCELERATION: Final = 1000.0
"""Maximum acceleration that requests accept [rad/s², m/s²]."""
STOP: Final = 4.0
"""Deceleration of the leading joint when a motion is canceled or replaced [rad/s²]."""


class _Running(NamedTuple):
    """A path that was sent to the bring-up."""

    plan: MovePlan
    number: int
    """Number of the path in the bring-up; 0 if no motion was necessary."""
    sent: float
    """Simulated time at which the path was sent [s]."""


@final
class Moves:
    """Moves the arm of a control box for one program at a time."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._running: _Running | None = None
        self._lead = LEAD[1]
        self._pacer = Pacer(box)
        self._owed = (0.0, 0.0)
        """Change of velocity that previous steps have left to the next step, and the
        time at which these steps ended [s]."""

    # ---- moves ----------------------------------------------------------------------

    async def move(self, moves: Sequence[Move], *, wait: bool = True) -> None:
        """Execute moves one after another, with blends.

        The first move is blended with the previous move if that move has a blend
        radius. Any other motion ends before the first move starts. If this call is
        canceled while it waits, the arm decelerates to rest.

        Args:
            moves: Moves to execute, at least one. If one of the moves is impossible,
                the arm does not move.
            wait: Whether to return when the last move has ended or is about to be
                blended; otherwise, return as soon as the motion is accepted.

        Raises:
            UnreachableError: If a move is impossible; the message contains the number
                of the move and the reason.
            ControlError: If the arm is not allowed to move.
        """
        self._running = running = await self._start(tuple(moves))
        plan = running.plan
        self._warn(plan.warnings)
        if wait:
            lead = self._lead if plan.tail else 0.0
            await self._until(running, plan.zones[-1] - lead)

    async def finish(self) -> None:
        """Wait until the last moves have ended.

        Raises:
            ControlError: If the arm has stopped.
        """
        if self._running is not None:
            await self._until(self._running, self._running.plan.duration)

    @property
    def progress(self) -> int:
        """Index of the move in progress; -1 if there is none."""
        running = self._running
        if running is None or self._has_ended(running):
            return -1
        return running.plan.move_at(self._path_time(running))

    async def movej(
        self, q: Sequence[float], a: float, v: float, t: float = 0.0, r: float = 0.0
    ) -> None:
        """Move all joints synchronously to the positions ``q`` [rad]."""
        await self.move([Move(kind="joint", q=q, a=a, v=v, t=t, r=r)])

    async def movel(
        self, pose: Sequence[float], a: float, v: float, t: float = 0.0, r: float = 0.0
    ) -> None:
        """Move the TCP along a straight line."""
        await self.move([Move(kind="linear", pose=pose, a=a, v=v, t=t, r=r)])

    async def movep(
        self, pose: Sequence[float], a: float, v: float, r: float = 0.0
    ) -> None:
        """Move the TCP along a straight line at constant speed, with arcs as blends."""
        await self.move([Move(kind="process", pose=pose, a=a, v=v, r=r)])

    async def movec(  # noqa: PLR0917 (URScript's)
        self,
        pose_via: Sequence[float],
        pose_to: Sequence[float],
        a: float,
        v: float,
        r: float = 0.0,
        mode: int = 0,
    ) -> None:
        """Move the TCP along a circular arc."""
        await self.move(
            [
                Move(
                    kind="circular",
                    via=pose_via,
                    pose=pose_to,
                    a=a,
                    v=v,
                    r=r,
                    mode=mode,
                )
            ]
        )

    async def servoc(
        self, pose: Sequence[float], a: float, v: float, r: float = 0.0
    ) -> None:
        """Move the TCP along the same path as ``movep``, as a servo motion."""
        await self.move([Move(kind="servo_circular", pose=pose, a=a, v=v, r=r)])

    # ---- streams and stops ----------------------------------------------------------

    async def servoj(
        self,
        q: Six,
        t: float = 0.002,
        lookahead_time: float = 0.1,
        gain: float = 300.0,
    ) -> None:
        """Follow joint positions [rad] and return after ``t`` [s]."""
        box = self._box
        self._running = None
        box.send(
            ServoJoints(
                arm=box.arm,
                positions=q,
                duration=t,
                lookahead_time=lookahead_time,
                gain=gain,
                timeout=OWN_STREAM,
            )
        )
        await self._pacer.wait(t)

    async def speedj(self, qd: Six, a: float, t: float | None = None) -> None:
        """Accelerate to joint velocities [rad/s]; return after ``t`` [s].

        If ``t`` is None, return when the velocities are reached. Velocities that exceed
        the joint limits are scaled down proportionally. The speed scaling slows down
        the complete motion.
        """
        box, a = self._box, _above_0(a)
        limits = [joint.limits.velocity for joint in box.chain.joints]
        excess = max(abs(v) / limit for v, limit in zip(qd, limits, strict=True))
        if excess > 1.0:
            qd = cast("Six", tuple(v / excess for v in qd))
        if t is None:
            t = float(np.abs(np.subtract(qd, box.target_qd)).max()) / a
        self._running = None
        a = self._hastened(a, t)
        box.send(
            SpeedJoints(arm=box.arm, velocities=qd, acceleration=a, timeout=OWN_STREAM)
        )
        await self._pacer.wait(t, is_scaled=True)

    async def speedl(
        self, xd: Six, a: float, t: float | None = None, a_rot: float | None = None
    ) -> None:
        """Accelerate to a TCP velocity [m/s, rad/s]; return after ``t`` [s].

        If ``t`` is None, return when the velocity is reached.
        """
        box, a = self._box, _above_0(a)
        if t is None:
            change = np.subtract(xd, box.tcp_speed(target=True))
            t = _duration(change, a, a_rot)
        self._running = None
        a = self._hastened(a, t)
        box.send(
            SpeedTool(
                arm=box.arm, twist=xd, acceleration=a, tcp=box.tcp, timeout=OWN_STREAM
            )
        )
        await self._pacer.wait(t, is_scaled=True)

    def _hastened(self, a: float, t: float) -> float:
        """Return the acceleration for a velocity step that may start late [rad/s²].

        A step that starts late has less time for its ramp. If the step should already
        have ended, the next step executes both ramps.
        """
        scale = self._box.state.speed_scaling
        if not scale or t > CATCH_UP:
            return a
        start = self._pacer.start
        end, (owed, since) = start + t / scale, self._owed
        change = a * t / scale
        if abs(start - since) < _ROUNDING:
            change += owed
        left = end - self._box.time
        if left < _ROUNDING:
            self._owed = (change, end)
            return a
        return min(change / left, MAX_ACCELERATION)

    async def stopj(self, a: float = 2.0) -> None:
        """Decelerate to rest with deceleration ``a`` of the leading joint [rad/s²]."""
        box, request = self._box, StopArm(arm=self._box.arm, deceleration=_above_0(a))
        if box.arm_sample.is_done and not any(box.target_qd):
            box.send(request)  # also stops a motion that no update contains yet
            self._running = None
            return
        await box.call(request)
        self._running = None  # also ends a path that has not begun
        await self._rest()

    async def stopl(self, a: float = 20.0, a_rot: float | None = None) -> None:
        """Decelerate to rest in the time in which the TCP stops at ``a`` [m/s²]."""
        fastest = float(np.abs(self._box.target_qd).max())
        duration = _duration(
            np.array(self._box.tcp_speed(target=True)), _above_0(a), a_rot
        )
        await self.stopj(fastest / duration if duration * fastest > 0.0 else a)

    # ---- paths ----------------------------------------------------------------------

    async def _start(self, moves: tuple[Move, ...]) -> _Running:
        if self._running is not None and not self._has_ended(self._running):
            blended = await self._blend(self._running, moves)
            if blended is not None:
                return blended
            await self._until(self._running, self._running.plan.duration)
        box = self._box
        while True:
            if not box.arm_sample.is_done:
                await self.stopj(STOP)
            start = box.target_q
            planner = self._planner()
            plan = await _planned(partial(planner.plan, start, moves), moves)
            if plan.duration == 0.0:
                return _Running(plan, 0, box.time)
            request = path_request(box.arm, plan.path)
            try:
                return _Running(plan, await box.call(request), box.time)
            except ControlError:
                await box.next_update()
                if box.arm_sample.is_done and box.target_q == start:
                    raise
                # The last update did not contain the arm's motion yet.

    async def _blend(
        self, running: _Running, moves: tuple[Move, ...]
    ) -> _Running | None:
        """Replace the end of a path; return None if a replacement is not possible."""
        box, plan, planner = self._box, running.plan, self._planner()
        margin, start = _MARGIN, self._box.time
        for _ in range(_ATTEMPTS):
            if plan.tail is None or self._has_ended(running):
                return None
            before = box.time
            at = max(plan.tail.entry, self._path_time(running) + margin)
            rest = await _planned(partial(planner.resume, plan, at, moves), moves)
            if rest is None:
                return None
            # The new path begins with the motion of the old path, which may be 0.02 mm
            # away. A knot at time 0 would cause a jump.
            path = rest.path.since(_FIRST_KNOT)
            request = path_request(box.arm, path, after=running.number, at=at)
            try:
                number = await box.call(request)
            except ControlError as error:
                logger.debug("%s: %s", box.arm, error)
                margin = max(2.0 * margin, 1.5 * (box.time - before))
            else:
                taken = _LEAD_FACTOR * (box.time - start) + _MARGIN
                self._lead = max(min(taken, LEAD[2]), _LEAD_DECAY * self._lead, LEAD[0])
                return _Running(rest, number, box.time)
        return None

    def _warn(self, warnings: Sequence[MoveWarning]) -> None:
        shown = list(map(str, warnings[:_SHOWN_WARNINGS]))
        if len(warnings) > len(shown):
            shown.append(f"{len(warnings) - len(shown)} more warnings of this path")
        for warning in shown:
            logger.warning("%s: %s", self._box.arm, warning)
            self._box.messages.text(warning)

    def _planner(self) -> MovePlanner:
        box = self._box
        return MovePlanner(box.kinematics, box.tcp, box.T_chain_base)

    # ---- waiting --------------------------------------------------------------------

    async def _until(self, running: _Running, time: float) -> None:
        """Wait until a path reaches ``time`` [s], or this program replaces or stops it.

        Raises:
            ControlError: If the arm has stopped, or left the path for another reason.
        """
        box, end = self._box, running.plan.duration
        must_arrive = time >= end - _ROUNDING

        def is_over() -> bool:
            is_there = not must_arrive and self._path_time(running) >= time - _ROUNDING
            return is_there or self._has_ended(running) or bool(box.stopped)

        try:
            await box.until(is_over)
        except asyncio.CancelledError:
            if not self._has_ended(running):
                box.send(StopArm(arm=box.arm, deceleration=STOP))
            raise
        if box.stopped:
            raise ControlError(box.stopped)
        is_own = running.number == 0 or self._running is not running
        if not is_own and self._path_time(running) < time - _UNFINISHED:
            raise ControlError("the motion was stopped before its end")

    def _path_time(self, running: _Running) -> float:
        """Return the time along a path [s]; 0 if the path has not begun."""
        update = self._box.arm_sample
        return update.path_time if update.path == running.number else 0.0

    def _has_ended(self, running: _Running) -> bool:
        """Return whether a path has reached its end or is no longer followed."""
        update = self._box.arm_sample
        if update.path == running.number:
            return update.is_done or update.mode != "path"
        is_reset = self._box.time < running.sent
        return update.path > running.number or running.number == 0 or is_reset

    async def _rest(self) -> None:
        await self._box.next_update()
        await self._box.until(lambda: self._box.arm_sample.is_done)


async def _planned(plan: Callable[[], T], moves: Sequence[Move]) -> T:
    """Plan in this thread if planning is quick; otherwise, plan in another thread."""
    if len(moves) == 1 and moves[0].kind == "joint":
        return plan()
    return await asyncio.to_thread(plan)


def _above_0(acceleration: float) -> float:
    """Limit an acceleration for requests; raise ControlError if it is not positive."""
    if not acceleration > 0.0:
        raise ControlError(f"an acceleration must be above 0, got {acceleration}")
    return min(acceleration, MAX_ACCELERATION)


def _duration(change: Array, a: float, a_rot: float | None) -> float:
    """Return the duration of a change of the tool's velocity [s]."""
    linear = float(np.linalg.norm(change[:3])) / a
    return max(linear, float(np.linalg.norm(change[3:])) / (a_rot or a))
