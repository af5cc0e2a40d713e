"""Wrong and odd values at random, and how many of them a run tries.

Every test of ``tests/fuzz`` tries a part of what it can; ``TOOL0_FUZZ=50`` tries 50
times as much, with other seeds for each part.
"""

from __future__ import annotations

import logging
import math
import os
import random
import signal
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any, Literal, Union, get_args, get_origin

import msgspec
import numpy as np

from tool0.errors import Tool0Error

SCALE = int(os.environ.get("TOOL0_FUZZ", "1"))
SEED = int(os.environ.get("TOOL0_FUZZ_SEED", "0"))
"""Of the tests that can begin elsewhere: another one tries other cases."""
LONG = 20.0
"""Longest time of one case on a busy machine [wall s]."""

TEXTS = (
    *("", " ", "x", "elbow_joint", "arm_controller", "tool0", "home", "ready", "cube"),
    *("\0", "\n", "\ud800", "é€", "../escape", "/", "~", "a" * 5000, "nan"),
    *(
        "%s%n",
        "{}",
        "${x}",
        "$(arg x)",
        "<a/>",
        "-1",
        "1e999",
        "true",
        "null",
        "\u202e",
    ),
)
NUMBERS = (
    *(0.0, -0.0, 1.0, -1.0, 0.5, 1e-12, 1e-320, 3.14159, 1e6, -1e6, 1e300, -1e300),
    *(math.nan, math.inf, -math.inf),
)
WHOLE = (0, 1, -1, 2, 7, 255, 1 << 31, -(1 << 31), 1 << 53, 1 << 63, 1 << 64, 10**400)


def anything(rng: random.Random, depth: int = 0) -> Any:
    """Return a value of any kind, most of them wrong anywhere."""
    kind = rng.randrange(13 if depth < 3 else 9)
    match kind:
        case 0:
            return None
        case 1:
            return rng.choice((True, False))
        case 2:
            return rng.choice(WHOLE)
        case 3 | 4:
            return rng.choice(NUMBERS)
        case 5 | 6:
            return rng.choice(TEXTS)
        case 7:
            return bytes(rng.randrange(256) for _ in range(rng.randrange(9)))
        case 8:
            return rng.choice(
                (np.float32(1.5), np.zeros(6), np.full((2, 3), np.nan), np.int64(-4))
            )
        case 9 | 10:
            return [anything(rng, depth + 1) for _ in range(rng.randrange(8))]
        case 11:
            return {
                rng.choice(TEXTS): anything(rng, depth + 1)
                for _ in range(rng.randrange(5))
            }
        case _:
            return tuple(rng.choice(NUMBERS) for _ in range(rng.choice((3, 4, 6, 7))))


def value_of(kind: Any, rng: random.Random, depth: int = 0) -> Any:
    """Return a value that fits a type annotation, more or less, or anything."""
    if rng.random() < 0.12 or depth > 5:
        return anything(rng, depth)
    origin = get_origin(kind)
    if hasattr(kind, "__metadata__"):
        return value_of(kind.__origin__, rng, depth)
    if origin is Literal:
        return rng.choice(get_args(kind))
    if origin is Union or type(kind).__name__ == "UnionType":
        return value_of(rng.choice(get_args(kind)), rng, depth + 1)
    if kind is None or kind is type(None):
        return None
    if kind is bool:
        return rng.choice((True, False))
    if kind is int:
        return rng.choice(WHOLE) if rng.random() < 0.5 else rng.randrange(9)
    if kind is float:
        return rng.choice(NUMBERS) if rng.random() < 0.4 else rng.uniform(-2.0, 2.0)
    if kind is str:
        return rng.choice(TEXTS)
    if origin is tuple:
        items = get_args(kind)
        if len(items) == 2 and items[1] is Ellipsis:
            return tuple(_several(items[0], rng, depth))
        return tuple(value_of(item, rng, depth + 1) for item in items)
    if (origin is not None and issubclass(origin, dict)) or _is_mapping(origin):
        key, value = get_args(kind)
        return {
            (rng.choice(TEXTS) if key is str else rng.choice(NUMBERS)): value_of(
                value, rng, depth + 1
            )
            for _ in range(rng.randrange(4))
        }
    if origin is not None and issubclass(origin, Sequence):
        return _several(get_args(kind)[0], rng, depth)
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return made(kind, rng, depth + 1)
    return anything(rng, depth)


def _is_mapping(origin: Any) -> bool:
    return getattr(origin, "__name__", "") == "Mapping"


def _several(kind: Any, rng: random.Random, depth: int) -> list[Any]:
    n = rng.choice((0, 1, 3, 6, 7))
    return [value_of(kind, rng, depth + 1) for _ in range(n)]


def made(kind: type[msgspec.Struct], rng: random.Random, depth: int = 0) -> Any:
    """Return a struct with fields that more or less fit."""
    hints = msgspec.structs.fields(kind)
    fields = {
        field.name: value_of(field.type, rng, depth)
        for field in hints
        if field.required or rng.random() < 0.5
    }
    try:
        return kind(**fields)
    except (TypeError, ValueError):
        return fields


def changed(data: bytes, rng: random.Random) -> bytes:
    """Return ``data`` after one to four changes anywhere in it."""
    for _ in range(rng.randrange(1, 5)):
        at = rng.randrange(len(data) + 1)
        end = min(len(data), at + rng.randrange(1, 40))
        part = data[at:end]
        piece = rng.choice(TEXTS).encode("utf-8", "surrogatepass")
        match rng.randrange(7):
            case 0:
                data = data[:at] + data[end:]
            case 1:
                data = data[:at] + part + part + data[end:]
            case 2:
                data = data[:at] + piece + data[at:]
            case 3:
                data = data[:at]
            case 4:
                data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
            case 5:
                other = rng.randrange(len(data) + 1)
                data = data[:at] + data[other : other + 60] + data[at:]
            case _:
                number = rng.choice((b"-1", b"0", b"1e999", b"nan", b"99999999999"))
                data = data[:at] + number + data[end:]
    return data


class Trial:
    """Cases that end with a result or an error of tool0; others are collected."""

    def __init__(self, what: str) -> None:
        self._what = what
        self.n_tried = self.n_accepted = 0
        self._failures: dict[str, str] = {}
        """Where an exception came from → the first case with it."""

    def carry_out(self, case: Callable[[], object], said: str) -> None:
        """Carry a case out; ``said`` describes it."""
        self.n_tried += 1
        try:
            with limited(), self.noting_logged(said):
                case()
        except Tool0Error as error:
            if not str(error).strip():
                self.note(error, said)
        except Exception as error:
            self.note(error, said)
        else:
            self.n_accepted += 1

    @contextmanager
    def noting_logged(self, said: str) -> Iterator[None]:
        """Note exceptions that are only logged, of any thread."""
        trial = self

        class Handler(logging.Handler):
            def emit(self, record: logging.LogRecord) -> None:
                if record.exc_info and isinstance(record.exc_info[1], Exception):
                    trial.note(record.exc_info[1], f"logged: {said}")

        handler = Handler()
        logging.getLogger("tool0").addHandler(handler)
        try:
            yield
        finally:
            logging.getLogger("tool0").removeHandler(handler)

    def note(self, error: BaseException, said: str) -> None:
        """Note an exception that is no answer."""
        frames = traceback.extract_tb(error.__traceback__)
        ours = [frame for frame in frames if "/src/tool0/" in frame.filename]
        where = f"{type(error).__name__} {error!s:.60}"
        if frames:
            place = (ours or frames)[-1]
            where = f"{place.filename}:{place.lineno}: {type(error).__name__}"
        self._failures.setdefault(where, f"{error!s:.300}\n    {said:.600}")

    def check(self) -> None:
        """Print how many cases there were, and fail for what was no answer."""
        print(
            f"{self._what}: {self.n_tried} tried, {self.n_accepted} accepted, "
            f"{len(self._failures)} kinds of exceptions"
        )
        listed = "\n".join(f"{k}: {v}" for k, v in sorted(self._failures.items()))
        assert not self._failures, f"not errors of tool0:\n{listed}"


@contextmanager
def limited() -> Iterator[None]:
    """Fail if what is inside takes much longer than it should."""

    def late(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"more than {LONG:g} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, LONG)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
