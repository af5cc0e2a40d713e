"""Conversion of journal requests to and from JSON, including internal requests."""

from __future__ import annotations

from functools import cache
from typing import Any

import msgspec

from tool0.control.config import ControllerConfig
from tool0.errors import RequestError
from tool0.protocol.codec import UNREADABLE
from tool0.protocol.request import Request, method_name, plain
from tool0.simulation.handlers.table import entries


def params_of(request: Request[Any]) -> bytes:
    """Return the parameters of a request as a JSON object.

    Raises:
        RequestError: If a value cannot be converted to JSON.
    """
    try:
        return _encoder.encode(request)
    except (TypeError, ValueError, OverflowError) as error:
        raise RequestError(method_name(type(request)), str(error)) from None


def request_of(method: str, params: bytes | str) -> Request[Any]:
    """Return the request that the JSON object describes.

    Raises:
        RequestError: If this version of tool0 has no such request, or the request does
            not accept the parameters.
    """
    entry = entries().get(method)
    if entry is None:
        raise RequestError(method, "this version of tool0 does not have this request")
    try:
        request: Request[Any] = _decoder(entry.request).decode(params)
    except UNREADABLE as error:
        raise RequestError(method, str(error)) from None
    return request


class _WrittenConfig(msgspec.Struct, frozen=True):
    """A configuration of controllers."""

    yaml: str
    types: dict[str, str]
    """Types, by controller, including types that the YAML does not specify."""


def _written(value: Any) -> Any:
    if isinstance(value, ControllerConfig):
        return _WrittenConfig(value.yaml(), dict(value.types))
    found = plain(value)
    if found is value:
        raise TypeError(f"a value of type {type(value).__name__} cannot be written")
    return found


def _read(kind: type[Any], value: Any) -> Any:
    if kind is not ControllerConfig:
        raise NotImplementedError(f"values of type {kind.__name__}")
    written = msgspec.convert(value, _WrittenConfig)
    config = ControllerConfig.from_text(written.yaml)
    for name, type_name in written.types.items():
        if config.types.get(name) != type_name:
            config = config.with_type(name, type_name)
    return config


_encoder = msgspec.json.Encoder(enc_hook=_written)


@cache
def _decoder(kind: type[Request[Any]]) -> msgspec.json.Decoder[Any]:
    return msgspec.json.Decoder(kind, dec_hook=_read)
