"""Messages that a connection receives apart from replies: states, events, the view."""

from __future__ import annotations

from typing import Annotated, Literal, final

from msgspec import Meta, Struct

from tool0.protocol.request import Name, Request
from tool0.protocol.state import MAX_SNAPSHOT_RATE, MIN_SNAPSHOT_RATE
from tool0.protocol.state_message import SNAPSHOT_FIELDS, StateField


class Subscribe(Request[None], frozen=True):
    """Receive ``state`` messages, events as they happen, and the log.

    A second request replaces the first.  Fields that rarely change, such as
    ``joint_names``, ``controllers`` and ``scene``, are in the first message and in
    messages in which they have changed.  A slow reader loses the oldest states; the
    next state says how many were lost, and is complete.
    """

    is_of_connection = True

    rate: Annotated[float, Meta(ge=MIN_SNAPSHOT_RATE, le=MAX_SNAPSHOT_RATE)] = 125.0
    """States per simulated second [Hz]; adjusted to a divisor of the control rate."""
    fields: tuple[StateField, ...] = SNAPSHOT_FIELDS
    """Fields of the messages in addition to ``time`` and ``tick``."""
    controllers: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """Trajectory controllers in ``motions``; if left out, all."""
    arms: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """Arms in ``arms`` and ``wrenches``; if left out, all."""
    newest_only: bool = False
    """Whether to receive only the newest state, at once and whenever it changes.

    Up to four times real time, there are at most ``rate`` states per second of wall
    time.  If time runs faster, or as fast as possible, there are 50 per second, so that
    the simulation is not slowed down."""


class Unsubscribe(Request[None], frozen=True):
    """Stop receiving states and events."""

    is_of_connection = True


class SubscribeView(Request[None], frozen=True):
    """Receive the panel's ``view``, ``scene``, ``status``, ``state`` and ``notice``.

    At most 60 states are sent per second of wall time, only the newest.  A second
    request changes their contents.
    """

    is_of_connection = True

    contacts: bool = False
    """Whether states contain contacts and their forces."""
    wrenches: bool = False
    """Whether states contain the wrench on each tool."""


class ViewShown(Request[None], frozen=True):
    """Report that a page has drawn the robot, for which ``tool0 demo`` waits."""

    is_of_connection = True


@final
class LogMessage(Struct, frozen=True, kw_only=True, tag="log"):
    """A warning or an error of the simulation, for users."""

    level: Literal["warning", "error"]
    message: str
