"""Messages that a connection receives besides replies: states, events, panel's view."""

from __future__ import annotations

from typing import Annotated, Literal, final

from msgspec import Meta, Struct

from tool0.protocol.request import Name, Request
from tool0.protocol.state import MAX_SNAPSHOT_RATE, MIN_SNAPSHOT_RATE
from tool0.protocol.state_message import SNAPSHOT_FIELDS, StateField


class Subscribe(Request[None], frozen=True):
    """Receive ``state`` messages, events as they happen, and the log.

    A second request replaces the first.  What stays the same for long, such as
    ``joint_names``, ``controllers`` and ``scene``, is in the first message and in those
    in which it has changed.  A slow reader loses the oldest states; the next one says
    how many, and is complete.
    """

    is_of_connection = True

    rate: Annotated[float, Meta(ge=MIN_SNAPSHOT_RATE, le=MAX_SNAPSHOT_RATE)] = 125.0
    """States per simulated second [Hz]: the next divisor of the control rate."""
    fields: tuple[StateField, ...] = SNAPSHOT_FIELDS
    """The fields of the messages, besides ``time`` and ``tick``."""
    controllers: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """The trajectory controllers in ``motions``; all, if left out."""
    arms: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """The arms in ``arms`` and ``wrenches``; all, if left out."""
    newest_only: bool = False
    """Receive the present state at once, and each later one as soon as it exists.

    Up to four times real time, there are no more states per second of wall time than
    ``rate``.  While time runs faster, or as fast as possible, there are 50 a second,
    the newest only: the simulation is not slowed down."""


class Unsubscribe(Request[None], frozen=True):
    """Receive no more states and events."""

    is_of_connection = True


class SubscribeView(Request[None], frozen=True):
    """Receive ``view``, ``scene``, ``status``, ``state`` and ``notice``: the panel.

    States come at most 60 times a second of wall time, the newest only.  A second
    request changes what they have.
    """

    is_of_connection = True

    contacts: bool = False
    """Whether states have the contacts and their forces."""
    wrenches: bool = False
    """Whether states have the wrench on each tool."""


class ViewShown(Request[None], frozen=True):
    """Report that a page has drawn the robot; ``tool0 demo`` starts then."""

    is_of_connection = True


@final
class LogMessage(Struct, frozen=True, kw_only=True, tag="log"):
    """A warning or an error of the simulation, for its users."""

    level: Literal["warning", "error"]
    message: str
