"""The complete UR interface: a control box and its ports for each arm."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final, Protocol

from tool0.errors import Tool0Error, TransportError
from tool0.protocol.arm import ListArms
from tool0.protocol.robot import ReadInfo
from tool0.protocol.socket_channel import SocketChannel
from tool0.ur.control_box import UrControlBox, box_states
from tool0.ur.options import UrArm, UrOptions
from tool0.ur.updates import Updates

logger = logging.getLogger(__name__)

CONNECT_TIMEOUT: Final = 60.0
"""Maximum time to wait for the bring-up [wall s]."""
_RETRY: Final = 0.02
"""Delay between attempts to connect [wall s]."""


class BoxInterface(Protocol):
    """An interface of a control box, such as RTDE, with any number of ports."""

    async def start(self, host: str, port_base: int) -> None:
        """Open the ports; raise TransportError if a port is in use."""

    async def close(self) -> None:
        """Close connections and ports."""


def interfaces_of(box: UrControlBox, options: UrOptions) -> list[BoxInterface]:
    """Return the interfaces of a control box."""
    from tool0.ur.client_interface.interface import ClientInterface
    from tool0.ur.dashboard import Dashboard
    from tool0.ur.interpreter_port import InterpreterPort
    from tool0.ur.program_watch import ProgramWatch
    from tool0.ur.reporter import Reporter
    from tool0.ur.rtde.server import RtdeServer

    interfaces: list[BoxInterface] = [
        ProgramWatch(box),
        Reporter(box),
        RtdeServer(box),
        Dashboard(box, options.programs),
        ClientInterface(box),
        InterpreterPort(box),
        box.modbus,
    ]
    if box.gripper is not None:
        from tool0.ur.robotiq.interface import RobotiqInterface, serial_port_path

        if options.active_gripper:
            box.gripper.assume_activated()
        port = serial_port_path(box.bringup, box.arm)
        interfaces.append(RobotiqInterface(box.gripper, port))
    elif box.has_foreign_gripper:
        logger.warning("%s: %s", box.arm, box.why_no_gripper)
    return interfaces


async def connected(name: str) -> SocketChannel:
    """Return a connection to a bring-up, which may still be starting."""
    deadline = time.monotonic() + CONNECT_TIMEOUT
    while True:
        try:
            return await asyncio.to_thread(SocketChannel, name)
        except TransportError:
            if time.monotonic() > deadline:
                raise
        await asyncio.sleep(_RETRY)


async def serve(
    channel: SocketChannel,
    options: UrOptions,
    ready: Callable[[Mapping[str, UrArm]], None],
) -> None:
    """Serve a bring-up's arms until the bring-up ends.

    ``ready`` is called with the addresses of the arms when the ports are open.

    Raises:
        TransportError: If there is no arm, or a port is in use.
    """
    loop = asyncio.get_running_loop()
    has_ended = asyncio.Event()
    boxes: list[UrControlBox] = []
    updates = Updates(boxes)

    def take() -> None:
        if boxes and (arrived := subscription.pending()):
            updates.show(arrived)

    def refuse(error: Tool0Error) -> None:
        for box in boxes:
            box.report(error)

    def in_loop(callback: Callable[..., None]) -> Callable[..., None]:
        def call(*arguments: Any) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(callback, *arguments)

        return call

    channel.when_ended = in_loop(lambda failure: has_ended.set())
    channel.when_refused = in_loop(refuse)
    arms = [arm.name for arm in await asyncio.to_thread(channel.call, ListArms())]
    if not arms:
        raise TransportError("the robot has no arm that a UR's control box could drive")
    subscription = await asyncio.to_thread(
        channel.follow, box_states(arms), when_published=in_loop(take)
    )
    first = await asyncio.to_thread(subscription.next, CONNECT_TIMEOUT)
    if first is None:
        raise TransportError("the bring-up sends no states")
    info = await asyncio.to_thread(channel.call, ReadInfo())
    limits = {joint: found.limits for joint, found in info.joint_limits.items()}
    boxes += [
        UrControlBox(
            channel, arm, first, limits=limits, allow_sockets=options.allow_sockets
        )
        for arm in arms
    ]
    async with contextlib.AsyncExitStack() as stack:
        served = {}
        for number, box in enumerate(boxes):
            host, interfaces = options.host_of(number), interfaces_of(box, options)
            for interface in interfaces:
                stack.push_async_callback(_closing(interface))
                await interface.start(host, options.port_base)
            served[box.arm] = _served(host, interfaces)
        ready(served)
        await has_ended.wait()
        for box in boxes:
            await box.programs.stop()


def _served(host: str, interfaces: list[BoxInterface]) -> UrArm:
    """Return the addresses of an arm's interfaces, which must have been started."""
    from tool0.ur.robotiq.interface import RobotiqInterface

    for interface in interfaces:
        if isinstance(interface, RobotiqInterface):
            path = interface.serial_port
            return UrArm(
                address=host,
                modbus_port=interface.modbus_tcp.number,
                serial_port=None if path is None else str(path),
            )
    return UrArm(address=host)


def _closing(interface: BoxInterface) -> Callable[[], Awaitable[None]]:
    return interface.close
