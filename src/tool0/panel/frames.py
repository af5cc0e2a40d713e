"""Frames, which are robot states with rounded values for display on pages."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from msgspec import UnsetType, structs

from tool0.description.scene_state import Contact
from tool0.protocol.state_message import StateMask, StateMessage, state_message

if TYPE_CHECKING:
    from tool0.protocol.state import Snapshot

_DIGITS: Final = 6
"""Number of decimals of positions and similar values.  Because of the rounding, the
frames of a stationary robot are identical."""
_FORCE_DIGITS: Final = 4


def frame_of(
    snapshot: Snapshot, scene: int, *, contacts: bool = False, wrenches: bool = False
) -> StateMessage:
    """Return a snapshot as a frame for pages.

    Args:
        snapshot: The snapshot, which may not yet contain forces that were requested
            recently.
        scene: Number of the snapshot's scene.
        contacts: Whether to add contacts.
        wrenches: Whether to add the wrench on each tool.
    """
    message = state_message(snapshot, _mask(contacts=contacts, wrenches=wrenches))
    found: dict[str, Any] = {
        name: _rounded(getattr(message, name))
        for name in ("position", "velocity", "effort")
    }
    if not isinstance(message.desired, UnsetType):
        found["desired"] = tuple(
            None if value is None else rounded(value) for value in message.desired
        )
    if not isinstance(message.objects, UnsetType):
        found["objects"] = tuple(
            (_rounded(position), _rounded(quaternion))
            for position, quaternion in message.objects
        )
    if not isinstance(message.contacts, UnsetType):
        found["contacts"] = tuple(map(_contact, message.contacts))
    if not isinstance(message.wrenches, UnsetType):
        items = message.wrenches.items()
        found["wrenches"] = {arm: _forces(wrench) for arm, wrench in items}
    time = rounded(message.time)
    return structs.replace(message, time=time, scene_number=scene, **found)


@cache
def _mask(*, contacts: bool, wrenches: bool) -> StateMask:
    return StateMask(
        (
            *("position", "velocity", "effort", "desired", "objects"),
            *(("contacts",) if contacts else ()),
            *(("wrenches",) if wrenches else ()),
        )
    )


def rounded(value: float) -> float:
    """Return a position or a similar value, rounded for pages."""
    return round(value, _DIGITS) + 0.0  # avoids minus zero


def _rounded(values: Iterable[float]) -> Any:  # Any: of the same length
    return tuple([round(value, _DIGITS) + 0.0 for value in values])


def _forces(values: Iterable[float]) -> Any:
    return tuple([round(value, _FORCE_DIGITS) + 0.0 for value in values])


def _contact(contact: Contact) -> Contact:
    return Contact(
        contact.first,
        contact.second,
        point=_rounded(contact.point),
        force=_forces(contact.force),
        torque=_forces(contact.torque),
    )
