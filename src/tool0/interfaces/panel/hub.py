"""All pages of one robot: each sees the same, and may drive it."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from typing import TYPE_CHECKING, Final, cast, final

from starlette.responses import PlainTextResponse

from tool0.errors import Tool0Error
from tool0.interfaces.panel.client import Client
from tool0.interfaces.panel.notices import NoticeBook
from tool0.interfaces.panel.protocol import (
    PROTOCOL,
    ClientMessage,
    Hello,
    PoseJoints,
    Problem,
    Reply,
    Status,
    Steer,
)
from tool0.interfaces.panel.source import Happening, PanelSource
from tool0.interfaces.panel.streams import Streams, Wish
from tool0.interfaces.panel.wire import Unreadable, encode, problem_of

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

logger = logging.getLogger(__name__)

FRAME_PERIOD: Final = 1 / 60
"""[wall s]"""
STATUS_PERIOD: Final = 0.1
"""[wall s]; also between looks at what happened."""
MOST_CLIENTS: Final = 64
WORKERS: Final = 16
"""Requests that are carried out at once; further ones wait."""
GOING_AWAY: Final = 1001
FULL: Final = 503
_GOODBYE: Final = 0.5
"""Longest wait for a page to hear that the server ends [wall s]."""


@final
class Hub:
    """Shows ``source`` to every page.  It lives in the server's event loop."""

    def __init__(
        self,
        source: PanelSource,
        cut: Callable[[WebSocket], None],
        when_shown: Callable[[], None] = lambda: None,
    ) -> None:
        """Start to look.

        Args:
            source: The robot.
            cut: Ends a connection that takes nothing any more.
            when_shown: Called when a page has connected.
        """
        self._when_shown = when_shown
        self._source = source
        self._cut = cut
        self._clients: dict[Client, WebSocket] = {}
        self._book = NoticeBook()
        self._streams = Streams(self._carry_out_wish)
        self._workers = ThreadPoolExecutor(WORKERS, "tool0-panel-worker")
        # The emergency stop never waits behind what other pages ask for.
        self._urgent_worker = ThreadPoolExecutor(1, "tool0-panel-stop")
        self._urgent: set[asyncio.Task[None]] = set()
        self._frame = source.frame()
        self._frame_text = encode(self._frame)
        self._scene = source.scene()
        self._scene_text = encode(self._scene)
        self._status: Status | None = None
        self._status_text = ""
        self._looking = asyncio.create_task(self._look())

    async def serve(self, socket: WebSocket) -> None:
        """Serve a page until it goes."""
        if len(self._clients) >= MOST_CLIENTS:
            text = f"{MOST_CLIENTS} pages are connected already; close one\n"
            await socket.send_denial_response(PlainTextResponse(text, FULL))
            return
        await socket.accept()
        client = Client(socket)
        self._clients[client] = socket
        self._show_now()
        client.tell(encode(self._hello()))
        client.show(
            scene=self._scene_text, status=self._status_text, frame=self._frame_text
        )
        self._when_shown()
        try:
            await client.serve(self._answer_urgently, self._answer)
        finally:
            self._clients.pop(client, None)
            if client.is_lost:
                self._cut(socket)

    async def close(self) -> None:
        """Say goodbye to every page; what they asked for is still carried out."""
        self._looking.cancel()
        self._streams.close()
        clients, self._clients = self._clients, {}
        await asyncio.gather(*(self._part(*pair) for pair in clients.items()))
        self._workers.shutdown(wait=False, cancel_futures=True)
        self._urgent_worker.shutdown(wait=False)
        self._source.close()

    async def _part(self, client: Client, socket: WebSocket) -> None:
        client.end()
        with contextlib.suppress(Exception):  # it may be gone, or stuck
            await asyncio.wait_for(
                socket.close(GOING_AWAY, "the server ends"), _GOODBYE
            )

    # ---- what pages see --------------------------------------------------------------

    def _hello(self) -> Hello:
        facts = self._source.facts
        return Hello(
            protocol=PROTOCOL,
            version=version("tool0"),
            mode=facts.mode,
            engine=facts.engine,
            control_period=facts.control_period,
            grasp_assist=facts.grasp_assist,
            robot=facts.robot,
            notices=list(self._book.kept),
        )

    async def _look(self) -> None:
        """Show what is new, at the pace of the wall clock."""
        loop = asyncio.get_running_loop()
        next_status = loop.time()
        while True:
            start = loop.time()
            try:
                if start >= next_status:
                    next_status = start + STATUS_PERIOD
                    self._tell_happenings()
                    self._give_up_stuck()
                    if self._clients:
                        self._show_status()
                if self._clients:
                    self._show_frame()
            except Exception:  # one page's trouble, or ours, is not the end of all
                logger.exception("the panel could not show the robot")
            pause = FRAME_PERIOD if self._clients else STATUS_PERIOD
            await asyncio.sleep(max(0.001, start + pause - loop.time()))

    def _show_now(self) -> None:
        self._tell_happenings()
        self._show_status()
        self._show_frame()

    def _show_frame(self) -> None:
        frame = self._source.frame()
        if frame is self._frame:
            return
        self._frame, self._frame_text = frame, encode(frame)
        scene = self._source.scene()
        is_other = scene is not self._scene
        if is_other:
            self._scene, self._scene_text = scene, encode(scene)
        for client in self._clients:
            client.show(
                scene=self._scene_text if is_other else None, frame=self._frame_text
            )

    def _show_status(self) -> None:
        status = self._source.status(len(self._clients))
        if status == self._status:
            return
        self._status, self._status_text = status, encode(status)
        for client in self._clients:
            client.show(status=self._status_text)

    def _tell_happenings(self) -> None:
        for happening in self._source.happenings():
            self._tell(happening)

    def _tell(self, happening: Happening) -> None:
        notice = self._book.note(happening)
        if notice is None:
            return
        text = encode(notice)
        for client in list(self._clients):
            client.tell(text)

    def _give_up_stuck(self) -> None:
        for client in list(self._clients):
            if client.is_stuck():
                client.give_up()

    # ---- what pages ask for ----------------------------------------------------------

    async def _answer(
        self, client: Client, message: ClientMessage | Unreadable
    ) -> None:
        if isinstance(message, Unreadable):
            client.tell(encode(message.reply))
        elif isinstance(message, Steer | PoseJoints):
            try:
                self._source.check(message)
            except Exception as error:
                client.tell(encode(Reply(id=None, error=_problem(error))))
            else:
                self._streams.submit(Wish(client, message))
        else:
            await self._streams.settle(self._source.displaced_by(message))
            client.tell(encode(await self._reply(message.id, message, self._workers)))

    def _answer_urgently(self, client: Client, message: ClientMessage) -> None:
        self._streams.drop(self._source.displaced_by(message))

        async def answer() -> None:
            number = cast(int, getattr(message, "id", None))
            client.tell(encode(await self._reply(number, message, self._urgent_worker)))

        task = asyncio.create_task(answer())
        self._urgent.add(task)
        task.add_done_callback(self._urgent.discard)

    async def _reply(
        self, number: int, message: ClientMessage, workers: ThreadPoolExecutor
    ) -> Reply:
        loop = asyncio.get_running_loop()
        try:
            await loop.run_in_executor(workers, self._source.carry_out, message)
        except Exception as error:
            return Reply(id=number, error=_problem(error))
        return Reply(id=number)

    async def _carry_out_wish(self, wish: Wish) -> None:
        loop = asyncio.get_running_loop()
        carry_out = self._source.carry_out
        try:
            await loop.run_in_executor(self._workers, carry_out, wish.message)
        except Exception as error:
            problem = _problem(error)
            if isinstance(wish.sender, Client) and wish.sender in self._clients:
                wish.sender.tell(encode(Reply(id=None, error=problem)))
            self._tell(
                Happening(
                    severity="warning",
                    code="refused",
                    text=problem.message,
                    time=self._frame.time,
                )
            )


def _problem(error: Exception) -> Problem:
    if not isinstance(error, Tool0Error):
        logger.error("a page's request failed", exc_info=error)
    return problem_of(error)
