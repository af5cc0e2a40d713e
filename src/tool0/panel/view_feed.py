"""Sends the robot's view to pages, with frames, status, scene and notices."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Sequence
from typing import Final, Protocol, final

import msgspec
from msgspec import UNSET

from tool0.panel.notices import NoticeBook
from tool0.panel.protocol import Status, ViewInfo, ViewScene
from tool0.panel.robot_info import RobotFiles
from tool0.protocol.codec import encode
from tool0.protocol.notifications import Notification
from tool0.protocol.sensors import CameraRenderer
from tool0.protocol.state_message import StateMessage
from tool0.protocol.subscriptions import SubscribeView
from tool0.server.hub import Hub
from tool0.server.session import Session

logger = logging.getLogger(__name__)

FRAME_PERIOD: Final = 1 / 60
"""Shortest period between frames [wall s]."""
STATUS_PERIOD: Final = 0.1
"""Period of status updates and of checks for notifications [wall s]."""
HEARTBEAT: Final = 0.2
"""Longest wall time between frames, including frames of a paused robot [s]."""


class ViewSource(Protocol):
    """Source of a robot's view on pages, used only in the server's thread."""

    @property
    def info(self) -> ViewInfo:
        """The constant part of the view, with earlier notices."""

    @property
    def files(self) -> RobotFiles: ...

    @property
    def cameras(self) -> CameraRenderer | None:
        """Renderer of the cameras in ``info``; None if there are no cameras."""

    def scene(self) -> ViewScene:
        """Return the objects of the last returned frame.

        The result is the same instance until an object is added or removed.
        """

    def frame(self) -> StateMessage:
        """Return the current frame; it is the same instance until the view changes."""

    def need_forces(self, *, contacts: bool, wrenches: bool) -> None:
        """Set whether frames contain contacts and wrenches."""

    def status(self, clients: int) -> Status:
        """Return the status; ``clients`` is the number of pages."""

    def notifications(self) -> Sequence[Notification]:
        """Return the notifications since the last call of this method."""

    def close(self) -> None:
        """Stop reading the state of the robot."""


@final
class ViewFeed:
    """Feed of the view to subscribed sessions, used only in the event loop."""

    def __init__(self, source: ViewSource, hub: Hub) -> None:
        """Start reading the source."""
        self._source = source
        self._hub = hub
        self._sessions: dict[Session, SubscribeView] = {}
        """Requested contents of the frames, by subscribed session."""
        self._book = NoticeBook()
        self._frame = source.frame()
        self._frame_texts: dict[SubscribeView, bytes] = {}
        """Encoded current frame, by requested contents."""
        self._frame_sent = 0.0
        self._scene = source.scene()
        self._scene_text = encode(self._scene)
        self._status: Status | None = None
        self._status_text = b""
        hub.attach_view = self.attach
        hub.when_refused = self._notify_refusal
        self._task = asyncio.create_task(self._run())

    def attach(self, session: Session, wanted: SubscribeView) -> None:
        """Start to send the view to a session, or change the contents of its frames."""
        if session in self._sessions:
            self._sessions[session] = wanted
            self._update_needs()
            return
        notices = [*self._source.info.notices, *self._book.kept]
        session.send(
            encode(msgspec.structs.replace(self._source.info, notices=notices))
        )
        self._update_frame()
        session.send_latest("scene", self._scene_text)
        self._sessions[session] = wanted
        self._update_needs()
        self._update_status()
        session.send_latest("status", self._status_text)
        session.send_latest("state", self._frame_text(wanted))

    def close(self) -> None:
        """Stop sending the view, and close the source."""
        self._task.cancel()
        self._source.close()

    async def _run(self) -> None:
        """Send changes periodically in wall time."""
        loop = asyncio.get_running_loop()
        next_status = loop.time()
        while True:
            start = loop.time()
            try:
                self._forget_ended()
                if start >= next_status:
                    next_status = start + STATUS_PERIOD
                    for notification in self._source.notifications():
                        self._notify(notification)
                    if self._sessions:
                        self._update_status()
                if self._sessions:
                    self._update_frame()
            except Exception:  # a failure must not end the view
                logger.exception("the panel could not show the robot")
            pause = FRAME_PERIOD if self._sessions else STATUS_PERIOD
            await asyncio.sleep(max(0.001, start + pause - loop.time()))

    def _update_frame(self) -> None:
        frame = self._source.frame()
        now = time.monotonic()
        if frame is self._frame and now - self._frame_sent < HEARTBEAT:
            return
        self._frame_sent = now
        if frame is not self._frame:
            self._frame = frame
            self._frame_texts.clear()
        scene = self._source.scene()
        is_new = scene is not self._scene
        if is_new:
            self._scene, self._scene_text = scene, encode(scene)
        for session, wanted in self._sessions.items():
            if is_new:
                session.send_latest("scene", self._scene_text)
            session.send_latest("state", self._frame_text(wanted))

    def _frame_text(self, wanted: SubscribeView) -> bytes:
        """Return the encoded frame with the contents that a session requested."""
        text = self._frame_texts.get(wanted)
        if text is None:
            frame = self._frame
            text = self._frame_texts[wanted] = encode(
                msgspec.structs.replace(
                    frame,
                    contacts=frame.contacts if wanted.contacts else UNSET,
                    wrenches=frame.wrenches if wanted.wrenches else UNSET,
                )
            )
        return text

    def _forget_ended(self) -> None:
        ended = self._sessions.keys() - self._hub.sessions
        for session in ended:
            del self._sessions[session]
        if ended:
            self._update_needs()

    def _update_needs(self) -> None:
        """Request from the source only the forces that a page requires."""
        wanted = self._sessions.values()
        self._source.need_forces(
            contacts=any(item.contacts for item in wanted),
            wrenches=any(item.wrenches for item in wanted),
        )

    def _update_status(self) -> None:
        status = self._source.status(len(self._sessions))
        if status == self._status:
            return
        self._status, self._status_text = status, encode(status)
        for session in self._sessions:
            session.send_latest("status", self._status_text)

    def _notify(self, notification: Notification) -> None:
        notice = self._book.note(notification)
        if notice is None:
            return
        text = encode(notice)
        for session in list(self._sessions):
            session.send(text)

    def _notify_refusal(self, message: str) -> None:
        self._notify(
            Notification(
                severity="warning",
                code="refused",
                text=message,
                time=self._frame.time,
            )
        )
