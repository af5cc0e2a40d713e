"""Requests: operations on a robot as immutable structs, and types of the fields."""

from __future__ import annotations

import math
import re
import typing
from collections.abc import Mapping, Sequence, Set
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from typing import Annotated, Any, ClassVar, Generic, Literal, TypeVar

import msgspec
from msgspec import Meta

from tool0.errors import RequestError

Response = TypeVar("Response")


class Request(
    msgspec.Struct,
    Generic[Response],
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    gc=False,
):
    """One operation on a running robot, answered by a ``Response``."""

    unchecked: ClassVar[tuple[str, ...]] = ()
    """Fields that the handler checks because they are large, such as the points of a
    trajectory."""
    is_urgent: ClassVar[bool] = False
    """Whether the request is a stop, which overtakes all requests that wait on its
    connection, for a worker thread, or for the tick."""
    revokes: ClassVar[tuple[str, ...]] = ()
    """Methods that would undo this stop.  A waiting request with one of these methods
    is refused if it was sent before the stop, on the same connection and for the same
    arm.  If such a request is already in progress, the stop is executed after the
    request."""
    is_streamed: ClassVar[bool] = False
    """Whether the requests form streams without replies.  Each request of a stream is
    executed at the next tick, and is not passed through other threads."""
    written_paths: ClassVar[tuple[str, ...]] = ()
    """Fields with the paths of the files or folders that the request writes on the
    robot's machine."""
    is_of_connection: ClassVar[bool] = False
    """Whether the request concerns the streams of one connection.  The server answers
    such a request for every backend."""

    def read_paths(self) -> tuple[str, ...]:
        """Return the paths of files that the request reads on the robot's machine."""
        return ()

    def as_done(self) -> Request[Any]:
        """Return a request with the same effect as this request, but without checks."""
        return self


class ArmRequest(Request[Response], Generic[Response], frozen=True, kw_only=True):
    """Common field of requests to an arm or its control box."""

    arm: str | None = None
    """Name of the arm in ``list_arms``; required only if the robot has several arms."""


RequestType = TypeVar("RequestType", bound=Request[Any])


def method_name(request: type[Request[Any]]) -> str:
    """Return the method name of a request: ``MoveJoints`` becomes ``move_joints``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", request.__name__).lower()


Name = Annotated[str, Meta(min_length=1, max_length=200)]
"""Name of a controller, a joint, a link, a pose or another part."""

SLOWEST = 0.01
SpeedScale = Annotated[float, Meta(ge=SLOWEST, le=1.0)]
"""Fraction of each joint's maximum velocity."""

Vector3 = tuple[float, float, float]

Quaternion = tuple[float, float, float, float]
"""Quaternion w, x, y, z."""

RGBA = tuple[float, float, float, float]

Length = Annotated[float, Meta(gt=0.0, le=1000.0)]
"""Length [m]."""

Coordinate = Annotated[float, Meta(ge=-1000.0, le=1000.0)]
"""Coordinate of a position [m]."""

Place = tuple[Coordinate, Coordinate, Coordinate]

CollisionRule = Literal["refuse", "ignore"]
"""``refuse``: check the motion, and refuse it if an arm would collide.  ``ignore``: do
not check the motion."""

JointPositions = Annotated[dict[str, float], Meta(max_length=1000)]
"""Joint → position [rad | m]."""


def checked(request: RequestType) -> RequestType:
    """Return ``request`` with plain values, or raise RequestError for an invalid value.

    NumPy numbers and arrays are converted to Python values.  Every value is checked
    against the type and the bounds of its field, as in requests on a connection.

    Raises:
        RequestError: If a value has the wrong type, is not finite, or is out of bounds.
    """
    kind = type(request)
    values = {}
    for field, annotation in _field_types(kind).items():
        value = getattr(request, field)
        if field not in kind.unchecked:
            value = checked_value(method_name(kind), field, value, annotation)
        values[field] = value
    return kind(**values)


def checked_value(method: str, name: str, value: object, kind: Any) -> Any:
    """Return ``value`` converted to the type ``kind``; raise RequestError on failure.

    Args:
        method: Name of the method with this parameter, for the error message.
        name: Name of the parameter.
        value: The value to check.
        kind: The type of the parameter, with bounds.
    """
    try:
        return msgspec.convert(plain(value), kind)
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise RequestError(method, f"'{name}': {problem_text(error)}") from None


def checked_path(method: str, name: str, value: object) -> Path:
    """Return ``value``, a string or a path, as an absolute path, or raise RequestError.

    ``~`` is replaced by the user's home folder.
    """
    if not isinstance(value, str | Path):
        raise RequestError(method, f"'{name}': expected a path, got {value!r:.80}")
    try:
        return Path(plain(str(value))).expanduser().absolute()
    except (ValueError, RuntimeError) as error:  # the user does not exist
        raise RequestError(method, f"'{name}': {error}") from None


def problem_text(error: Exception) -> str:
    """Return the text of an error, with type names from Python rather than JSON."""
    return str(error).replace("`object", "`mapping").replace("`array", "`list")


def plain(value: Any, key: object = None) -> Any:
    """Return ``value`` with plain Python numbers and sequences.

    Raises:
        ValueError: If a number is NaN or infinite; in a mapping, the message contains
            the ``key``.
    """
    match value:
        case str():
            return _encodable(value)
        case None | bool() | bytes():
            return value
        case msgspec.Struct():
            return _plain_struct(value)
        case Integral():
            return int(value)
        case Real():
            if not math.isfinite(value):
                of = "" if key is None else f"'{key}' "
                raise ValueError(f"{of}must be finite, got {value}")
            return float(value)
        case Mapping():
            return {plain(key): plain(item, key) for key, item in value.items()}
        case Sequence() | Set():
            return [plain(item, key) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _encodable(text: str) -> str:
    """Return a string unchanged, or raise ValueError if it has unpaired surrogates."""
    if not text.isascii():
        try:
            text.encode()
        except UnicodeEncodeError as error:
            raise ValueError(f"{text!r:.40} is no Unicode text: {error}") from None
    return text


def _plain_struct(value: msgspec.Struct) -> Any:
    """Return a struct as a mapping, in the form that connections receive."""
    kind = value.__struct_config__
    found: dict[str, Any] = {}
    if kind.tag_field is not None:
        found[kind.tag_field] = kind.tag
    for name, encoded in zip(
        value.__struct_fields__, value.__struct_encode_fields__, strict=True
    ):
        found[encoded] = plain(getattr(value, name), encoded)
    return found


@cache
def _field_types(kind: type[Request[Any]]) -> Mapping[str, Any]:
    hints = typing.get_type_hints(kind, include_extras=True)
    return {field: hints[field] for field in kind.__struct_fields__}


@cache
def response_type(kind: type[Request[Any]]) -> Any:
    """Return the resolved response type of a request class."""
    for parent in kind.__mro__:
        for base in parent.__dict__.get("__orig_bases__", ()):
            if isinstance(argument := (*typing.get_args(base), None)[0], TypeVar):
                continue
            if issubclass(typing.get_origin(base) or object, Request):
                return argument
    raise TypeError(f"{kind.__name__} does not declare its response type")
