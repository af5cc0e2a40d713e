"""Policies of openpi servers, which are accessed over a WebSocket.

The protocol is that of openpi_client 0.1.2 (websocket_client_policy.py and
msgpack_numpy.py, https://github.com/Physical-Intelligence/openpi).  The server sends
its metadata once.  The server answers each dictionary of arrays and strings with a
dictionary that contains ``actions``, shape (h, m).  Messages are encoded with msgpack.
A text message reports an error.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any, Final, final

import msgspec
import numpy as np
from numpy.typing import NDArray

from tool0.errors import ConfigError, PolicyError, TransportError, did_you_mean
from tool0.policy.seen import Seen

_TIMEOUT: Final = 10.0
"""Longest wait for the connection and the server's metadata [wall s]."""
_ANSWER_TIMEOUT: Final = 60.0
"""Longest wait for actions [wall s].  Before the first answer, a server compiles its
network."""
_PROMPT: Final = "prompt"
_VECTORS: Final = {
    "state": "observation.state",
    "environment_state": "observation.environment_state",
}
_IMAGES: Final = "observation.images."


@final
class OpenpiServer:
    """A connection to one openpi server; arrays are sent unchanged."""

    digest = None

    def __init__(self, address: str, keys: Mapping[str, str]) -> None:
        """Connect to a server.

        Args:
            address: Address of the server, ``ws://HOST:PORT``.
            keys: Mapping from each name that the server expects to ``state``,
                ``environment_state``, ``prompt``, the name of an image, or a
                comma-separated list of number names.  If the mapping is empty, the
                names that openpi's LIBERO policies expect are used.

        Raises:
            TransportError: If no server answers at the address.
        """
        from websockets.exceptions import InvalidURI, WebSocketException
        from websockets.sync.client import connect

        self._address, self._keys = address, dict(keys)
        self._stack = contextlib.ExitStack()
        try:
            connection = connect(
                address,
                compression=None,
                max_size=None,
                open_timeout=_TIMEOUT,
                proxy=None,
                ping_interval=None,  # a server may be busy
            )
            self._socket = self._stack.enter_context(connection)
            self.metadata = _unpacked(self._socket.recv(timeout=_TIMEOUT))
        except (InvalidURI, ValueError) as error:
            raise ConfigError(f"policy '{address}': {error}") from None
        except (OSError, WebSocketException, PolicyError) as error:
            self._stack.close()
            raise TransportError(
                f"no policy server answers at {address}: {error}"
            ) from None

    def begin(self, seed: int) -> None:
        """Begin an episode; openpi servers keep no state between requests."""

    def infer(self, seen: Seen) -> Any:
        """Return the server's actions, shape (h, m).

        Raises:
            PolicyError: If the server reports an error, or its answer contains no
                actions.
            TransportError: If the server does not answer.
        """
        from websockets.exceptions import WebSocketException

        try:
            self._socket.send(_ENCODER.encode(self._request(seen)))
            answer = self._socket.recv(timeout=_ANSWER_TIMEOUT)
        except (OSError, WebSocketException) as error:
            raise TransportError(
                f"the policy server at {self._address} does not answer: {error}"
            ) from None
        if isinstance(answer, str):
            last = answer.strip().splitlines()[-1:] or ["no reason"]
            raise PolicyError(f"the policy server at {self._address}: {last[0]}")
        found = _unpacked(answer)
        if not isinstance(found, dict) or "actions" not in found:
            raise PolicyError(
                f"the policy server at {self._address} answers without 'actions'"
            )
        return found["actions"]

    def close(self) -> None:
        """Close the connection."""
        self._stack.close()

    def _request(self, seen: Seen) -> dict[str, Any]:
        columns = seen.columns()
        keys = self._keys or _default_keys(columns)
        return {key: _value(key, what, seen, columns) for key, what in keys.items()}


def _default_keys(columns: Mapping[str, Any]) -> dict[str, str]:
    """Return the keys that openpi's LIBERO policies expect for an observation."""
    images = [
        name.removeprefix(_IMAGES) for name in columns if name.startswith(_IMAGES)
    ]
    keys = {"observation/state": "state", _PROMPT: _PROMPT}
    for name in reversed(images):  # the first image has priority
        is_wrist = "wrist" in name
        keys[f"observation/{'wrist_image' if is_wrist else 'image'}"] = name
    return keys


def _value(key: str, what: str, seen: Seen, columns: Mapping[str, Any]) -> Any:
    """Return the value that is sent to the server under a key."""
    if what == _PROMPT:
        return seen.instruction
    name = _VECTORS.get(what, f"{_IMAGES}{what}")
    if name in columns:
        return columns[name]
    numbers = seen.numbers()
    wanted = what.split(",")
    for each in wanted:
        if each not in numbers:
            images = [n.removeprefix(_IMAGES) for n in columns if n.startswith(_IMAGES)]
            known = [*_VECTORS, _PROMPT, *images, *numbers]
            raise ConfigError(
                f"key {key}={what}: nothing that is observed is called '{each}'"
                f"{did_you_mean(each, known)}"
            )
    return np.array([numbers[each] for each in wanted], np.float32)


# ---- messages ------------------------------------------------------------------------


def _packed_array(value: object) -> dict[bytes, object]:
    if not isinstance(value, np.ndarray):
        raise TypeError(f"cannot send a {type(value).__name__}")
    return {
        b"__ndarray__": True,
        b"data": value.tobytes(),
        b"dtype": value.dtype.str,
        b"shape": value.shape,
    }


_ENCODER: Final = msgspec.msgpack.Encoder(enc_hook=_packed_array)


def _unpacked(message: str | bytes) -> Any:
    """Return a decoded message, with its arrays as NumPy arrays.

    Raises:
        PolicyError: If the message is invalid.
    """
    if isinstance(message, str):
        raise PolicyError(f"the policy server says: {message.strip()[:200]}")
    try:
        return _with_arrays(msgspec.msgpack.decode(message))
    except (msgspec.DecodeError, TypeError, ValueError, KeyError) as error:
        raise PolicyError(
            f"the policy server sends a message that is no msgpack of arrays: {error}"
        ) from None


def _with_arrays(value: Any) -> Any:
    if isinstance(value, list):
        return [_with_arrays(each) for each in value]
    if not isinstance(value, dict):
        return value
    if b"__ndarray__" in value:
        found: NDArray[Any] = np.frombuffer(value[b"data"], _dtype(value[b"dtype"]))
        return found.reshape(value[b"shape"])
    if b"__npgeneric__" in value:
        return _dtype(value[b"dtype"]).type(value[b"data"])
    return {key: _with_arrays(each) for key, each in value.items()}


def _dtype(name: str | bytes) -> np.dtype[Any]:
    """Return a numeric data type; reject an object type, which could execute code."""
    found = np.dtype(name.decode() if isinstance(name, bytes) else name)
    if found.kind not in "biuf":
        raise ValueError(f"an array of {found}")
    return found
