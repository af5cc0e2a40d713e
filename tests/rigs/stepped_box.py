"""A control box in step with its simulation: both run as fast as they compute.

Box, programs and simulation share one thread.  The programs run until all of them wait;
then one control period of the robot passes, and the box shows the new state.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar, cast

import numpy as np
from msgspec import structs

import tool0
from tool0.errors import Tool0Error
from tool0.protocol import codec
from tool0.protocol.arm import ListArms
from tool0.protocol.channel import Channel, backend_of
from tool0.protocol.request import Request, checked
from tool0.protocol.robot import ReadInfo
from tool0.protocol.socket_channel import SocketChannel
from tool0.protocol.state import MAX_SNAPSHOT_RATE, Snapshot
from tool0.protocol.state_message import filled
from tool0.ur.control_box import UrControlBox

R = TypeVar("R")

PERIOD = 1.0 / MAX_SNAPSHOT_RATE
"""Between two updates of the box [s]."""
MOST_TURNS = 1000
"""Of the event loop in one period; programs that still run then go on in the next."""


class _Requests:
    """Sends requests as a connection does: they are answered in the next period."""

    name = "stepped"

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self.description = channel.description
        self.when_refused: Callable[[Tool0Error], None] = lambda error: None
        self._answers: list[Callable[[], None]] = []

    def answer(self) -> None:
        """Answer what was asked before."""
        answers, self._answers = self._answers, []
        for answer in answers:
            answer()

    def submit(
        self, request: Request[R], when_done: Callable[[Callable[[], R]], None]
    ) -> None:
        sent = _sent(request)
        try:
            response = self._channel.call(sent)
            codec.encode_reply(1, sent, response)
        except Tool0Error as error:
            known = codec.error_of(codec.error_info(error))

            def fail() -> R:
                raise known

            self._answers.append(lambda: when_done(fail))
        else:
            self._answers.append(lambda: when_done(lambda: response))

    def post(self, request: Request[Any]) -> None:
        sent = _sent(request)
        try:
            self._channel.call(sent)
        except Tool0Error as error:
            self.when_refused(error)


def _sent(request: Request[R]) -> Request[R]:
    """Return a request as it arrives at the other end of a connection."""
    text = codec.encode_request(1, checked(request))
    try:
        return codec.decode_request(text)[1]
    except codec.RequestReadError as error:
        raise error.error from None


class _AtOnce(ThreadPoolExecutor):
    """Executes what is given to other threads before it goes on."""

    def submit(self, fn: Callable[..., R], /, *args: Any, **kwargs: Any) -> Future[R]:
        future: Future[R] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class SteppedBox:
    """The control box of a robot that is not in real time, in the running loop."""

    def __init__(self, robot: tool0.Robot) -> None:
        """Show the only arm of a robot of this process."""
        self.robot = robot
        self._loop = asyncio.get_running_loop()
        self._loop.set_default_executor(_AtOnce(max_workers=1))
        self._turns: Callable[[], int] = cast("Any", self._loop)._ready.__len__
        self._requests = requests = _Requests(robot.channel)
        (arm,) = robot.channel.call(ListArms())
        self.arm = arm.name
        states = backend_of(robot.channel).states
        assert states is not None
        self._states = states.subscribe(
            MAX_SNAPSHOT_RATE, with_arms=True, with_contacts=True, latest_only=True
        )
        info = robot.channel.call(ReadInfo())
        limits = {name: found.limits for name, found in info.joint_limits.items()}
        self.box = UrControlBox(
            cast("SocketChannel", requests),
            self.arm,
            self._snapshot(),
            limits=limits,
        )
        requests.when_refused = self.box.report
        joints = [joint.limits for joint in self.box.chain.joints]
        self.lower = np.array([limits.lower for limits in joints])
        self.upper = np.array([limits.upper for limits in joints])
        self.fastest = np.array([limits.velocity for limits in joints])
        """Of the description, which are those of the data sheet [rad/s]."""
        self._links = {link.name for link in robot.description.model.links}

    def _snapshot(self) -> Snapshot:
        states = backend_of(self.robot.channel).states
        assert states is not None
        shot = states.snapshot
        if not shot.arms:
            shot = states.snapshot_with_arms()
        sample = shot.arms[self.arm]
        return structs.replace(shot, arms={self.arm: filled(shot, sample)})

    @property
    def touches(self) -> bool:
        """Whether a link of the robot touches something."""
        return any(
            contact.first in self._links or contact.second in self._links
            for contact in self.box.snapshot.contacts
        )

    async def settle(self) -> None:
        """Let programs run until all of them wait for time to pass."""
        for _ in range(MOST_TURNS):
            await asyncio.sleep(0)
            if not self._turns():
                return

    async def step(self) -> None:
        """Let programs run; then let a control period pass."""
        await self.settle()
        self.robot.run(PERIOD)
        self._requests.answer()
        self.box.take(self._snapshot())

    async def show(self) -> None:
        """Show what has changed while no time passes."""
        self._requests.answer()
        self.box.take(self._snapshot())
        await self.settle()

    def close(self) -> None:
        """Show nothing any more."""
        self._states.close()
