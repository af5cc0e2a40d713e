"""The commands of ur_rtde's control program that move the arm."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from typing import TYPE_CHECKING, Any, Final, final

from tool0.description.transform import Transform
from tool0.errors import ControlError, Tool0Error
from tool0.motion.moves import Move, MoveKind
from tool0.protocol.arm_motion import ServoJoints, SpeedJoints, SpeedTool
from tool0.ur.moves import Moves
from tool0.ur.pose import transform_of
from tool0.ur.rtde_control.exchange import Exchange

if TYPE_CHECKING:
    from tool0.protocol.state import Six
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.tool_contact import ToolHistory

JOG_STOP, CONTACT_STOP = 1.2, 3.0
"""Deceleration of the tool after jogging and at a contact [m/s²]."""
RETURN_ACCELERATION, RETURN_SPEED = 1.2, 0.25
"""Acceleration and speed of the return to a contact, which are URScript's defaults
[m/s², m/s]."""
BASE, TOOL, CUSTOM = 0, 1, 2
"""Numbers of the frames for jogging."""
ASYNCHRONOUS: Final = 1
"""Value of integer register 1 if the client does not wait for the end of a motion."""
CANCEL_DECELERATION: Final = 2.0
"""Deceleration before a motion that replaces an asynchronous motion [rad/s²]; the value
is stopj's default."""


@final
class Motions:
    """Moves an arm; a new motion replaces an asynchronous motion that is active."""

    def __init__(
        self,
        box: UrControlBox,
        exchange: Exchange,
        history: ToolHistory,
        moves: Moves,
        *,
        path: Sequence[Move],
        wake: Callable[[], None],
    ) -> None:
        self._box, self._exchange, self._history = box, exchange, history
        self._moves, self._path, self._wake = moves, path, wake
        self._task: asyncio.Task[None] | None = None
        """Task of an asynchronous motion."""
        self._failure: BaseException | None = None
        self._is_tool_speed = False
        self._circular: Move | None = None
        """Current target of servoc."""
        self._jog_frame = Transform()
        self._is_jogging = False
        self._detection: asyncio.Task[None] | None = None
        self._is_contact_new = False
        self.contact_steps = 0
        """Number of updates between the start of the last contact and its detection; 0
        if there was no contact."""
        self.waypoint: Six = box.tcp_pose(target=True)
        """Target pose of the last move."""

    # ---- moves ----------------------------------------------------------------------

    async def move_joints(self) -> None:
        """Move to joint positions along a path in joint space: movej."""
        await self._move_joints(self._exchange.six(0))

    async def move_joints_to_pose(self) -> None:
        """Move to a pose along a path in joint space: movej with inverse kinematics."""
        await self._move_joints(self._box.inverse(self._exchange.six(0)))

    async def _move_joints(self, q: Six) -> None:
        self.waypoint = self._box.forward(q)
        await self._run([self._move("joint", q=q)])

    async def move_tool(self) -> None:
        """Move to a pose along a straight line: movel."""
        self.waypoint = pose = self._exchange.six(0)
        await self._run([self._move("linear", pose=pose)])

    async def move_tool_to_joints(self) -> None:
        """Move to joint positions along a straight line: movel."""
        q = self._exchange.six(0)
        self.waypoint = self._box.forward(q)
        await self._run([self._move("linear", q=q)])

    async def move_path(self) -> None:
        """Move along the uploaded path; the progress is the current move's index."""
        await self._run(self._path)

    def _move(
        self, kind: MoveKind, q: Six | None = None, pose: Six | None = None
    ) -> Move:
        speed, acceleration = self._exchange.number(6), self._exchange.number(7)
        return Move(kind=kind, q=q, pose=pose, a=acceleration, v=speed)

    async def _run(self, moves: Sequence[Move]) -> None:
        """Start moves, and wait until they end unless the motion is asynchronous."""
        await self._cancel()
        self._exchange.show_progress(0)
        if self._is_asynchronous():
            self._start(self._follow(moves))
        else:
            await self._follow(moves)

    async def _follow(self, moves: Sequence[Move]) -> None:
        """Execute moves, and show the index of the current move as progress.

        Raises:
            ControlError: If the arm has stopped. After a stop, the command is not
                reported as done.
        """
        await self._moves.move(moves, wait=False)
        shown = 0
        while (current := self._moves.progress) >= 0:
            if current > shown:
                shown = current
                self._exchange.show_progress(current)
            await self._box.next_update()
        await self._moves.finish()
        self._exchange.show_progress(None)

    # ---- streams --------------------------------------------------------------------

    async def servo_joints(self) -> None:
        """Follow joint positions: servoj."""
        await self._servo(self._exchange.six(0))

    async def servo_tool(self) -> None:
        """Follow a pose: servoj with inverse kinematics."""
        await self._servo(self._box.inverse(self._exchange.six(0)))

    async def _servo(self, q: Six) -> None:
        await self._cancel()
        exchange = self._exchange
        self._box.send(
            ServoJoints(
                arm=self._box.arm,
                positions=q,
                duration=exchange.number(8),
                lookahead_time=exchange.number(9),
                gain=exchange.number(10),
            )
        )

    async def servo_circular(self) -> None:
        """Move to a pose at constant speed, blended with the previous move: servoc."""
        exchange = self._exchange
        target = Move(
            kind="servo_circular",
            pose=exchange.six(0),
            a=exchange.number(7),
            v=exchange.number(6),
            r=exchange.number(8),
        )
        if self._circular is None:
            await self._cancel()
            self._circular = target
            self._start(self._servo_circular())
        elif target != self._circular:
            self._circular = target

    async def _servo_circular(self) -> None:
        """Move to the newest target until the task is canceled."""
        try:
            while self._circular is not None:
                target = self._circular
                await self._moves.move([target])
                while self._circular is target:
                    await self._box.next_update()
        finally:
            self._circular = None

    async def speed_joints(self) -> None:
        """Move the joints at velocities until the client stops them: speedj."""
        await self._cancel()
        self._is_tool_speed = False
        self._box.send(
            SpeedJoints(
                arm=self._box.arm,
                velocities=self._exchange.six(0),
                acceleration=self._exchange.number(6),
            )
        )

    async def speed_tool(self) -> None:
        """Move the tool at a velocity until the client stops it: speedl."""
        await self._cancel()
        self._is_tool_speed = True
        self._speed_tool(self._exchange.six(0), self._exchange.number(6))

    def _speed_tool(self, twist: Six, acceleration: float) -> None:
        box = self._box
        box.send(
            SpeedTool(arm=box.arm, twist=twist, acceleration=acceleration, tcp=box.tcp)
        )

    async def end_speed(self) -> None:
        """End speedj or speedl."""
        deceleration = self._exchange.number(0)
        if self._is_tool_speed:
            await self._moves.stopl(deceleration)
        else:
            await self._moves.stopj(deceleration)

    async def end_servo(self) -> None:
        """End servoj or servoc."""
        await self._cancel()
        await self._moves.stopl(self._exchange.number(0))

    async def start_jog(self) -> None:
        """Move the tool at a velocity in a frame until the client stops it.

        A second call changes the velocity but not the frame.
        """
        exchange = self._exchange
        if not self._is_jogging:
            await self._cancel()
            self._is_jogging = True
            self._jog_frame = self._frame(exchange.number(6))
        velocity = exchange.six(0)
        linear = self._jog_frame.rotate(velocity[:3])
        angular = self._jog_frame.rotate(velocity[3:])
        self._speed_tool((*linear, *angular), exchange.number(7))

    def _frame(self, feature: float) -> Transform:
        """Return the frame for jogging, relative to the base frame."""
        if feature == BASE:
            return Transform()
        if feature == TOOL:
            return transform_of(self._box.tcp_pose())
        if feature == CUSTOM:
            return transform_of(self._exchange.six(8))
        raise ControlError(f"jogging: {feature:g} is no feature; use 0, 1 or 2")

    async def end_jog(self) -> None:
        """End jogging."""
        self._is_jogging = False
        await self._moves.stopl(JOG_STOP)

    # ---- stops ----------------------------------------------------------------------

    async def stop_joints(self) -> None:
        """Decelerate to rest in joint space: stopj."""
        await self._stop(self._moves.stopj)

    async def stop_tool(self) -> None:
        """Decelerate to rest along the tool's path: stopl."""
        await self._stop(self._moves.stopl)

    async def _stop(self, stop: Callable[[float], Coroutine[Any, Any, None]]) -> None:
        deceleration = self._exchange.number(0)
        await self._abandon()
        if not self._is_asynchronous():
            await stop(deceleration)
            return
        self._exchange.show_progress(0)
        self._start(self._shown(stop(deceleration)))

    async def _shown(self, motion: Coroutine[Any, Any, None]) -> None:
        await motion
        self._exchange.show_progress(None)

    # ---- contacts -------------------------------------------------------------------

    async def move_until_contact(self) -> None:
        """Move the tool at a velocity until a contact; return to the contact point."""
        await self._cancel()
        exchange, box = self._exchange, self._box
        direction = exchange.six(6)
        self._speed_tool(exchange.six(0), exchange.number(12))
        steps = 0
        while not steps:
            await box.next_update()
            steps = self._history.contact(direction)
        await self._return_to_contact(steps)

    async def start_contact_detection(self) -> None:
        """Start contact detection; a direction of zero means the motion's direction."""
        await self.end_contact_detection()
        self.contact_steps = 0
        direction = self._exchange.six(0)
        self._detection = asyncio.create_task(self._detect(direction))

    async def end_contact_detection(self) -> None:
        """Stop contact detection and answer whether there was a contact."""
        if self._detection is not None:
            self._detection.cancel()
            self._detection = None
        self._exchange.answer_integer(self.contact_steps)

    async def _detect(self, direction: Six) -> None:
        """Wait until there is no contact, and then wait for a new contact."""
        is_free = False
        while True:
            sought = direction if any(direction) else self._box.tcp_speed(target=True)
            steps = self._history.contact(sought)
            if steps and is_free:
                break
            is_free = is_free or not steps
            await self._box.next_update()
        self.contact_steps = steps
        self._is_contact_new = True
        self._wake()

    async def look_for_contact(self) -> None:
        """Return to the contact point if a contact was detected since the last call."""
        if self._is_contact_new:
            self._is_contact_new = False
            await self._return_to_contact(self.contact_steps)

    async def _return_to_contact(self, steps: int) -> None:
        q = self._history.positions(steps)
        await self._abandon()
        await self._moves.stopl(CONTACT_STOP)
        move = Move(kind="linear", q=q, a=RETURN_ACCELERATION, v=RETURN_SPEED)
        await self._moves.move([move])

    # ---- asynchronous motions -------------------------------------------------------

    def check(self) -> None:
        """Raise the error that ended an asynchronous motion, if there was one."""
        if self._failure is not None:
            raise self._failure

    async def close(self) -> None:
        """End asynchronous motions."""
        await self._abandon()
        if self._detection is not None:
            self._detection.cancel()

    def _start(self, motion: Coroutine[Any, Any, None]) -> None:
        self._task = asyncio.create_task(self._report(motion))

    async def _report(self, motion: Coroutine[Any, Any, None]) -> None:
        try:
            await motion
        except Tool0Error as error:
            self._failure = error
            self._wake()

    def _is_asynchronous(self) -> bool:
        return self._exchange.integer(1) == ASYNCHRONOUS

    async def _abandon(self) -> None:
        """Cancel the task of an asynchronous motion without stopping the arm."""
        task, self._task = self._task, None
        if task is None or task.done():
            return
        task.cancel()
        await asyncio.wait([task])
        self._exchange.show_progress(None)

    async def _cancel(self) -> None:
        """End an asynchronous motion and decelerate the arm to rest."""
        if self._task is None or self._task.done():
            return
        await self._abandon()
        await self._moves.stopj(CANCEL_DECELERATION)
