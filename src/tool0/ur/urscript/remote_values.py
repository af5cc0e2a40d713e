"""Conversions between URScript values and XML-RPC values.

A pose is a struct of x, y, z, rx, ry and rz, as in the examples on UR's support pages
(https://www.universal-robots.com/articles/ur/interface-communication/xml-rpc-communication/).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from tool0.ur.urscript.syntax import INT_RANGE
from tool0.ur.urscript.values import (
    Pose,
    Struct,
    Value,
    checked_list,
    checked_pose,
    checked_struct,
    checked_text,
    described,
)
from tool0.ur.urscript_errors import ValueProblem

_POSE: Final = ("x", "y", "z", "rx", "ry", "rz")


def sent(value: Value) -> object:
    """Convert a program's value for xmlrpc.client.

    Raises:
        ValueProblem: If XML-RPC does not support the type of the value.
    """
    match value:
        case Pose():
            return dict(zip(_POSE, value, strict=True))
        case Struct(names, values):
            return dict(zip(names, map(sent, values), strict=True))
        case tuple():
            return [sent(item) for item in value]
        case bool() | int() | float():
            return value
        case str():  # one character for each byte
            return value.encode("latin-1").decode("utf-8", "replace")
        case _:
            raise ValueProblem(f"{described(value)} cannot be sent")


def received(value: object) -> Value:
    """Convert a value from xmlrpc.client to a program's value.

    Raises:
        ValueProblem: If URScript does not support the type, or the value is too large.
    """
    match value:
        case None | bool() | float():
            return value
        case int():
            if value not in INT_RANGE:
                raise ValueProblem(f"the integer {value} has more than 32 bits")
            return value
        case str():
            return checked_text(value.encode().decode("latin-1"))
        case list():
            return checked_list([received(item) for item in value])
        case Mapping():
            if set(value) == set(_POSE):
                return checked_pose([received(value[name]) for name in _POSE])
            names = tuple(map(str, value))
            return checked_struct(names, [received(item) for item in value.values()])
        case _:
            kind = type(value).__name__
            raise ValueProblem(f"programs have no values such as XML-RPC's {kind}")
