"""Methods of lists, such as ``items.append(1)``.

Source: URScript manual 5.15 and later, "Lists and Structs". UR's lists have individual
capacities. In tool0, only the common limit for all lists applies.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple, TypeAlias, final

from tool0.ur.urscript.values import (
    MAX_LIST,
    Value,
    checked_list,
    checked_text,
    described,
    element,
    to_text,
    weight,
)
from tool0.ur.urscript_errors import ValueProblem

Items: TypeAlias = tuple[Value, ...]


class Outcome(NamedTuple):
    """Effect of a method call."""

    items: Sequence[Value]
    """The list after the call."""
    value: Value
    """Return value of the method."""


@final
class ListMethod(NamedTuple):
    """A method of lists."""

    call: Callable[..., Outcome]
    n_arguments: int
    changes: bool
    """Whether the method changes the list, which must then be a variable."""

    def apply(self, items: Items, arguments: Sequence[Value]) -> tuple[Items, Value]:
        """Return the list after the call and the return value of the method.

        Raises:
            ValueProblem: If the arguments are invalid.
        """
        new, result = self.call(items, *arguments)
        return (checked_list(new) if self.changes else items), result


def _position(items: Items, index: Value, last: int) -> int:
    if type(index) is not int:
        raise ValueProblem(f"an index is an integer, not {described(index)}")
    if not 0 <= index <= last:
        raise ValueProblem(f"index {index} of a list of {len(items)} elements")
    return index


def _append(items: Items, value: Value) -> Outcome:
    return Outcome((*items, value), None)


def _extend(items: Items, others: Value) -> Outcome:
    if type(others) is not tuple:
        raise ValueProblem(f"a list is needed, not {described(others)}")
    return Outcome((*items, *others), None)


def _insert(items: Items, index: Value, value: Value) -> Outcome:
    k = _position(items, index, len(items))
    return Outcome((*items[:k], value, *items[k:]), None)


def _remove(items: Items, index: Value) -> Outcome:
    k = _position(items, index, len(items) - 1)
    return Outcome((*items[:k], *items[k + 1 :]), None)


def _pop(items: Items) -> Outcome:
    if not items:
        raise ValueProblem("the list is empty")
    return Outcome(items[:-1], element(items, len(items) - 1))


def _slice(items: Items, start: Value, end: Value) -> Outcome:
    last = _position(items, end, len(items))
    return Outcome(items, items[_position(items, start, last) : last])


def _capacity(items: Items) -> Outcome:
    return Outcome(items, MAX_LIST)


def _excess_capacity(items: Items) -> Outcome:
    return Outcome(items, MAX_LIST - weight(items))


LIST_METHODS: Final = {
    "append": ListMethod(_append, 1, changes=True),
    "capacity": ListMethod(_capacity, 0, changes=False),
    "clear": ListMethod(lambda items: Outcome((), None), 0, changes=True),
    "excess_capacity": ListMethod(_excess_capacity, 0, changes=False),
    "extend": ListMethod(_extend, 1, changes=True),
    "insert": ListMethod(_insert, 2, changes=True),
    "length": ListMethod(lambda items: Outcome(items, len(items)), 0, changes=False),
    "pop": ListMethod(_pop, 0, changes=True),
    "remove": ListMethod(_remove, 1, changes=True),
    "slice": ListMethod(_slice, 2, changes=False),
    "to_string": ListMethod(
        lambda items: Outcome(items, checked_text(to_text(items))), 0, changes=False
    ),
}


def list_method(name: str, n_arguments: int) -> ListMethod:
    """Return the list method with this name.

    Raises:
        ValueProblem: If there is no such method with this number of arguments.
    """
    method = LIST_METHODS.get(name)
    if method is None:
        known = ", ".join(LIST_METHODS)
        raise ValueProblem(f"unknown method '{name}'; lists have {known}")
    if n_arguments != method.n_arguments:
        count = method.n_arguments
        plural = "s" * (count != 1)
        raise ValueProblem(
            f"'{name}' takes {count} argument{plural}, not {n_arguments}"
        )
    return method
