"""A simulated gripper that behaves like a Robotiq gripper and has its registers."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, Final, Protocol, TypeVar, final

from tool0.description.model import ParallelGripper
from tool0.devices.robotiq_counts import FULL, Counts
from tool0.devices.robotiq_registers import (
    Activation,
    CommandRegisters,
    Fault,
    ObjectStatus,
    StatusRegisters,
)
from tool0.errors import Tool0Error
from tool0.protocol.control_box_state import ControlBoxState, RobotMode
from tool0.protocol.goals import GoalStarted
from tool0.protocol.gripper import GraspState, Grip, ReadGripper
from tool0.protocol.request import Request
from tool0.protocol.state import Snapshot
from tool0.ur.waiting import seen

R = TypeVar("R")

POLL_PERIOD: Final = 0.02
"""Polling period while the fingers move, and delay before the first poll after a new
goal [s]. After this delay, the simulation's state includes the goal."""
MOVED: Final = 0.0005
"""Change of the opening that restarts the polling of fingers at rest [m]. Fingers that
lose an object, for example, close further."""
STILL: Final = 0.0001
"""Change of the opening between two polls below which fingers near their goal are at
rest [m]. The change is a third of a position count."""
ELSEWHERE: Final = 0.002
"""Distance from the requested opening above which another client is assumed to have
moved the fingers [m]."""
POWER_ON: Final = CommandRegisters(speed=FULL, force=FULL)
"""Command registers after power-on. Speed and force are the URCap's defaults."""


class GripperLink(Protocol):
    """The part of a control box that the gripper uses."""

    when_updated: set[Callable[[], None]]
    """Callbacks for updates, which are called in the event loop."""
    snapshot: Snapshot
    """Newest state of the bring-up."""
    state: ControlBoxState

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    async def call(self, request: Request[R]) -> R:
        """Return the response; raise an error if the request fails."""

    def report(self, error: Tool0Error) -> None:
        """Report an error to users."""


@final
class RobotiqGripper:
    """A gripper with one set of registers for all clients, as in a real gripper.

    The gripper uses the same requests as every other client of the bring-up. The
    gripper reports the simulation's measurements, regardless of which client moves the
    fingers. Use the gripper only in the event loop.
    """

    def __init__(
        self,
        link: GripperLink,
        name: str,
        geometry: ParallelGripper,
        joint_index: int,
    ) -> None:
        """Represent a gripper that has just been switched on.

        Args:
            link: The control box.
            name: Name of the gripper in ``Grip``.
            geometry: Geometry of the gripper, with its speed and force.
            joint_index: Index of the driven joint in the updates.
        """
        self.name = name
        self.counts = Counts(geometry)
        self._geometry = geometry
        self._link = link
        self._index = joint_index
        self.command = POWER_ON
        """Command registers, which clients write."""
        self.address: tuple[str, int] | None = None
        """Host and port of the URCap's socket; None until the socket is open."""
        self._activation = Activation.RESET
        self._object = ObjectStatus.MOVING
        self._fault = Fault.NONE
        self._goal: float | None = None
        """Requested opening [m]; None if another client has moved the fingers."""
        self._task: asyncio.Task[None] | None = None
        self._asked: asyncio.Future[GoalStarted] | None = None
        """Last motion request that was sent to the bring-up."""
        self._changed = asyncio.Event()
        self._waits: list[tuple[Callable[[], bool], asyncio.Event]] = []
        link.when_updated.add(self._look_at_update)

    def assume_activated(self) -> None:
        """Set the registers to activated, as after an activation on the pendant."""
        self.command = replace(self.command, activate=True)
        self._activation = Activation.COMPLETE

    async def close(self) -> None:
        """Stop monitoring the simulation; the fingers complete their motion."""
        self._link.when_updated.discard(self._look_at_update)
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            await asyncio.wait([task])

    # ---- registers ------------------------------------------------------------------

    @property
    def is_powered(self) -> bool:
        """Whether the arm supplies the gripper with power."""
        return self._link.state.robot_mode > RobotMode.POWER_OFF

    @property
    def status(self) -> StatusRegisters:
        """Status registers that the gripper currently reports."""
        position, effort = self._measured()
        is_active = self._activation is Activation.COMPLETE
        return StatusRegisters(
            is_activated=self.command.activate,
            goes_to=is_active and self.command.go_to,
            activation=self._activation,
            object_status=self._object,
            fault=self._fault,
            request=self.command.position,
            position=self.counts.count(position),
            current=self.counts.current(position, effort),
        )

    def change(self, **fields: Any) -> None:
        """Write some of the registers; the names are fields of ``CommandRegisters``."""
        self.write(replace(self.command, **fields))

    def write(self, command: CommandRegisters) -> None:
        """Accept a command and start the requested action."""
        if not self.is_powered:
            return
        before, self.command = self.command, command
        if not command.activate:
            if before.activate:
                self._reset()
            wants = command.go_to or command.release
            self._fault = Fault.ACTIVATION_NEEDED if wants else Fault.NONE
        elif self._fault.is_major:
            pass  # only a reset clears a major fault
        elif command.release:
            self._activation = Activation.RESET
            self._fault = Fault.RELEASE_IN_PROGRESS
            self._start(self._release)
        elif self._activation is not Activation.COMPLETE:
            self._fault = Fault.ACTION_DELAYED if command.go_to else Fault.NONE
            if self._activation is Activation.RESET:
                self._activation = Activation.IN_PROGRESS
                self._start(self._activate)
        elif not command.go_to:
            if before.go_to and self._object is ObjectStatus.MOVING:
                self._start(self._stop)
        elif not self.has_goal or command != before:
            self._start(self._go)
        self._tell()

    # ---- functions for URScript's rq_… -----------------------------------------------

    @property
    def is_activated(self) -> bool:
        """Whether the activation is complete."""
        return self._activation is Activation.COMPLETE

    @property
    def is_object_detected(self) -> bool:
        """Whether an object has stopped the fingers."""
        return self._object in {ObjectStatus.MET_OPENING, ObjectStatus.MET_CLOSING}

    @property
    def is_motion_complete(self) -> bool:
        """Whether the fingers have reached their goal or met an object."""
        return self._object is not ObjectStatus.MOVING

    @property
    def has_goal(self) -> bool:
        """Whether the last goal is valid: no other client has moved the fingers."""
        return self._goal is not None

    @property
    def position(self) -> int:
        """Measured position count: 0 is open, 255 is closed."""
        return self.counts.count(self._measured()[0])

    def reset(self) -> None:
        """Deactivate the gripper and clear its faults."""
        self.change(activate=False, release=False)

    def activate(self) -> None:
        """Start the activation, unless the gripper is already activated."""
        if not self.is_activated:
            self.reset()
        self.change(activate=True)

    async def activate_and_wait(self) -> None:
        """Activate the gripper and wait; a loss of power also ends the wait."""
        self.activate()
        await self.wait_until(
            lambda: self.is_activated or self._fault.is_major or not self.is_powered
        )

    def move(self, position: int) -> None:
        """Start a motion to a position count; 0 is open, 255 is closed."""
        self.change(position=position, go_to=True)

    async def move_and_wait(self, position: int) -> None:
        """Move to a position count; wait until the goal or an object is reached."""
        self.move(position)
        await self.wait()

    async def wait(self) -> None:
        """Wait until the motion is complete or can no longer be completed."""
        await self.wait_until(
            lambda: (
                self.is_motion_complete or not self.is_activated or not self.is_powered
            )
        )

    def stop(self) -> None:
        """Stop the fingers at their current position."""
        self.change(go_to=False)

    async def release_and_wait(self, *, opening: bool) -> None:
        """Release slowly, as in an emergency; a reset is necessary afterwards."""
        self.change(activate=True, release=True, release_opening=opening)
        await self.wait_until(
            lambda: self._fault is Fault.RELEASE_COMPLETE or not self.is_powered
        )

    async def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until the registers meet a condition."""
        while not condition():
            await self._changed.wait()

    # ---- motions: each is a task, and a new motion replaces the last one ------------

    def _start(self, motion: Callable[[], Awaitable[None]]) -> None:
        self._cancel()
        self._object = ObjectStatus.MOVING
        self._task = asyncio.create_task(self._run(motion))

    def _cancel(self) -> None:
        if self._task is not None:
            self._task.cancel()
            self._task = None

    async def _run(self, motion: Callable[[], Awaitable[None]]) -> None:
        try:
            await motion()
        except Tool0Error as error:
            if self._activation is Activation.IN_PROGRESS:
                self._activation = Activation.RESET
                self._fault = Fault.ACTIVATION_FAILED
            self._goal = None
            self._tell()
            self._link.report(error)

    async def _activate(self) -> None:
        """Close and open, like a real gripper, to find the ends of the stroke."""
        for count in (FULL, 0):
            await self._grip(self.counts.opening(count), speed=FULL, force=0)
            await self._settle()
        self._activation, self._fault = Activation.COMPLETE, Fault.NONE
        self._goal = None
        self._tell()
        if self.command.go_to:
            await self._go()

    async def _release(self) -> None:
        count = 0 if self.command.release_opening else FULL
        await self._grip(self.counts.opening(count), speed=0, force=0)
        await self._settle()
        self._fault = Fault.RELEASE_COMPLETE
        self._tell()

    async def _go(self) -> None:
        command = self.command
        self._goal = self.counts.opening(command.position)
        await self._grip(self._goal, speed=command.speed, force=command.force)
        await self._watch()

    async def _stop(self) -> None:
        await self._hold()
        await self._watch()

    async def _hold(self) -> None:
        """Stop the fingers at their current position."""
        opening = self._geometry.opening(self._measured()[0])
        self._goal = min(max(opening, 0.0), self._geometry.max_opening)
        command = self.command
        await self._grip(self._goal, speed=command.speed, force=command.force)

    async def _watch(self) -> None:
        """Update the registers until the next command."""
        while True:
            state = await self._settle()
            self._show(state)
            await self._until_moved(state.opening)

    def _show(self, state: GraspState) -> None:
        """Set the registers from the simulation's measurements."""
        goal = self._goal
        match state.motion:
            case "holding_inside":
                self._object = ObjectStatus.MET_CLOSING
            case "holding_outside":
                self._object = ObjectStatus.MET_OPENING
            case "at_target":
                self._object = ObjectStatus.ARRIVED
                if goal is not None and abs(state.opening - goal) > ELSEWHERE:
                    self._goal = None
            case "blocked":  # a real gripper also reports an object
                is_opening = goal is not None and goal > state.opening
                self._object = (
                    ObjectStatus.MET_OPENING if is_opening else ObjectStatus.MET_CLOSING
                )
            case _:
                self._object = ObjectStatus.MOVING
        self._tell()

    async def _grip(self, opening: float, *, speed: int, force: int) -> None:
        """Start a motion to an opening [m]; speed and force are register values.

        The call first waits for the response to the previous motion request, even if
        that motion was replaced. Fast commands therefore cannot fill the request queue
        of the UR process.
        """
        if self._asked is not None:
            await asyncio.wait({self._asked})
        request = Grip(
            gripper=self.name,
            opening=opening,
            speed=self.counts.speed(speed),
            force=self.counts.force(force),
        )
        self._asked = asked = asyncio.ensure_future(self._link.call(request))
        asked.add_done_callback(seen)
        await asyncio.shield(asked)
        await self._pass(POLL_PERIOD)

    async def _settle(self) -> GraspState:
        """Wait until the fingers are at rest, and return their state."""
        opening = math.inf
        while True:
            state = await self._link.call(ReadGripper(gripper=self.name))
            creeps = abs(state.opening - opening) > STILL
            if state.motion != "moving" and not (
                creeps and state.motion == "at_target"
            ):
                return state
            opening = state.opening
            if state.motion == "moving":
                self._object = ObjectStatus.MOVING
            await self._pass(POLL_PERIOD)

    # ---- power and time -------------------------------------------------------------

    def _reset(self) -> None:
        """Deactivate: moving fingers stop, and fingers at rest keep their grip."""
        is_moving = (
            self._task is not None
            and not self._task.done()
            and self._object is ObjectStatus.MOVING
        )
        self._activation = Activation.RESET
        if is_moving:
            self._start(self._hold)
        else:
            self._cancel()
        self._object = ObjectStatus.MOVING

    def _look_at_update(self) -> None:
        if not self.is_powered and self.command is not POWER_ON:
            self._cancel()
            self.command = POWER_ON
            self._activation, self._fault = Activation.RESET, Fault.NONE
            self._object = ObjectStatus.MOVING
            self._tell()
        for condition, reached in self._waits:
            if condition():
                reached.set()

    async def _until(self, condition: Callable[[], bool]) -> None:
        """Wait for the first update at which a condition holds."""
        wait = (condition, asyncio.Event())
        self._waits.append(wait)
        try:
            await wait[1].wait()
        finally:
            self._waits.remove(wait)

    async def _pass(self, duration: float) -> None:
        """Wait for a duration in simulated time [s]; a time reset ends the wait."""
        start = self._link.time
        await self._until(lambda: not 0.0 <= self._link.time - start < duration)

    async def _until_moved(self, opening: float) -> None:
        """Wait until the opening differs from ``opening`` [m], or the time is reset."""
        start = self._link.time

        def has_moved() -> bool:
            now = self._geometry.opening(self._measured()[0])
            return abs(now - opening) > MOVED or self._link.time < start

        await self._until(has_moved)

    def _measured(self) -> tuple[float, float]:
        """Return the position [rad | m] and effort [N·m | N] of the driven joint."""
        snapshot = self._link.snapshot
        return snapshot.position[self._index], snapshot.effort[self._index]

    def _tell(self) -> None:
        """Wake up all tasks that wait for a change of the registers."""
        self._changed.set()
        self._changed = asyncio.Event()
