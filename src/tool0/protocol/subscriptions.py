"""Subscriptions of a connection to states, events and the panel's view."""

from __future__ import annotations

from typing import Annotated, Literal, final

from msgspec import Meta, Struct

from tool0.protocol.request import Name, Request
from tool0.protocol.state import MAX_SNAPSHOT_RATE, MIN_SNAPSHOT_RATE
from tool0.protocol.state_message import SNAPSHOT_FIELDS, StateField


class Subscribe(Request[None], frozen=True):
    """Receive ``state`` messages, events when they occur, and log messages.

    A second request replaces the first request.  After the first message, fields that
    rarely change, such as ``joint_names``, ``controllers`` or ``scene``, are included
    only when they have changed.  A slow reader loses the oldest states.  The next state
    contains the number of lost states, and all fields.
    """

    is_of_connection = True

    rate: Annotated[float, Meta(ge=MIN_SNAPSHOT_RATE, le=MAX_SNAPSHOT_RATE)] = 125.0
    """Rate of the states in simulated time [Hz]; the rate is adjusted to a divisor of
    the control rate."""
    fields: tuple[StateField, ...] = SNAPSHOT_FIELDS
    """Fields of the messages in addition to ``time`` and ``tick``."""
    controllers: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """Trajectory controllers in ``motions``; the default is all trajectory
    controllers."""
    arms: Annotated[tuple[Name, ...], Meta(max_length=100)] = ()
    """Arms in ``arms`` and ``wrenches``; the default is all arms."""
    newest_only: bool = False
    """Whether to receive only the newest state: once immediately, and after each
    change.

    At up to four times real time, at most ``rate`` states are sent per second of wall
    time.  At higher speeds, or as fast as possible, 50 states are sent per second of
    wall time, so that the simulation is not slowed down."""


class Unsubscribe(Request[None], frozen=True):
    """Stop receiving states and events."""

    is_of_connection = True


class SubscribeView(Request[None], frozen=True):
    """Receive the panel's ``view``, ``scene``, ``status``, ``state`` and ``notice``.

    At most 60 states are sent per second of wall time; older states are skipped.  A
    second request changes the contents of the states.
    """

    is_of_connection = True

    contacts: bool = False
    """Whether states contain contacts and their forces."""
    wrenches: bool = False
    """Whether states contain the wrench on each tool."""


class ViewShown(Request[None], frozen=True):
    """Report that a page has drawn the robot; ``tool0 demo`` waits for this request."""

    is_of_connection = True


@final
class LogMessage(Struct, frozen=True, kw_only=True, tag="log"):
    """A warning or an error message from the simulation, for users."""

    level: Literal["warning", "error"]
    message: str
