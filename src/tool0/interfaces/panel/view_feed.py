"""Shows a robot to every page: the newest frame, what changes seldom, and notices."""

from __future__ import annotations

import asyncio
import logging
from typing import Final, final

from tool0.interfaces.panel.notices import NoticeBook
from tool0.interfaces.panel.protocol import Status, ViewInfo
from tool0.interfaces.panel.source import Notification, ViewSource
from tool0.interfaces.server.hub import Hub
from tool0.interfaces.server.session import Session
from tool0.requests.codec import encode

logger = logging.getLogger(__name__)

FRAME_PERIOD: Final = 1 / 60
"""[wall s]"""
STATUS_PERIOD: Final = 0.1
"""[wall s]; also between looks at what happened."""


@final
class ViewFeed:
    """Feeds the sessions that subscribed to the view.  It lives in the event loop."""

    def __init__(self, source: ViewSource, hub: Hub) -> None:
        """Start to look."""
        self._source = source
        self._hub = hub
        self._sessions: set[Session] = set()
        self._book = NoticeBook()
        self._frame = source.frame()
        self._frame_text = encode(self._frame)
        self._scene = source.scene()
        self._scene_text = encode(self._scene)
        self._status: Status | None = None
        self._status_text = b""
        hub.attach_view = self.attach
        hub.when_refused = self._tell_refusal
        self._task = asyncio.create_task(self._look())

    def attach(self, session: Session) -> None:
        """Let a session receive the view from now on."""
        self._sessions.add(session)
        self._update_status()
        session.tell(encode(self._view_info()))
        session.show("scene", self._scene_text)
        session.show("status", self._status_text)
        session.show("frame", self._frame_text)

    def close(self) -> None:
        """Look no more."""
        self._task.cancel()
        self._source.close()

    def _view_info(self) -> ViewInfo:
        facts = self._source.facts
        return ViewInfo(
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
                self._sessions &= self._hub.sessions
                if start >= next_status:
                    next_status = start + STATUS_PERIOD
                    for notification in self._source.notifications():
                        self._tell(notification)
                    self._hub.drop_stuck()
                    if self._sessions:
                        self._update_status()
                if self._sessions:
                    self._show_frame()
            except Exception:  # one page's trouble, or ours, is not the end of all
                logger.exception("the panel could not show the robot")
            pause = FRAME_PERIOD if self._sessions else STATUS_PERIOD
            await asyncio.sleep(max(0.001, start + pause - loop.time()))

    def _show_frame(self) -> None:
        frame = self._source.frame()
        if frame is self._frame:
            return
        self._frame, self._frame_text = frame, encode(frame)
        scene = self._source.scene()
        is_new = scene is not self._scene
        if is_new:
            self._scene, self._scene_text = scene, encode(scene)
        for session in self._sessions:
            if is_new:
                session.show("scene", self._scene_text)
            session.show("frame", self._frame_text)

    def _update_status(self) -> None:
        status = self._source.status(len(self._sessions))
        if status == self._status:
            return
        self._status, self._status_text = status, encode(status)
        for session in self._sessions:
            session.show("status", self._status_text)

    def _tell(self, notification: Notification) -> None:
        notice = self._book.note(notification)
        if notice is None:
            return
        text = encode(notice)
        for session in list(self._sessions):
            session.tell(text)

    def _tell_refusal(self, message: str) -> None:
        self._tell(
            Notification(
                severity="warning",
                code="refused",
                text=message,
                time=self._frame.time,
            )
        )
