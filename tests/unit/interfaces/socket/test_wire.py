import socket

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tool0.interfaces.socket.wire import (
    LineReader,
    LineTooLongError,
    decode,
    error_from_json,
    error_to_json,
    result_from_json,
    result_to_json,
)

from tool0 import errors
from tool0.control.goal import GoalResult, GoalStatus, GripperResult, Result
from tool0.errors import DivergenceError, GoalRejectedError, Tool0Error, TransportError
from tool0.interfaces.server.unix_socket import MAX_LINE
from tool0.requests.codec import encode

ERRORS = [
    *(
        kind("what went wrong")
        for name, kind in vars(errors).items()
        if isinstance(kind, type)
        and issubclass(kind, Tool0Error)
        and kind is not DivergenceError
        and not name.startswith("_")
    ),
    GoalRejectedError("late", GoalRejectedError.OLD_HEADER_TIMESTAMP),
    DivergenceError("elbow_joint", 1.25),
]
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=10,
)


@pytest.mark.slow
@given(st.dictionaries(st.text(), JSON))
def test_decoding_undoes_encoding(message: dict[str, object]) -> None:
    line = encode(message)
    assert line.count(b"\n") == 1
    assert decode(line) == message


@given(st.binary(max_size=200))
def test_any_bytes_decode_to_an_object_or_a_transport_error(line: bytes) -> None:
    try:
        message = decode(line)
    except TransportError:
        return
    assert isinstance(message, dict)


@pytest.mark.parametrize("line", [b"[" * 100_000, b"9" * 10_000, b"\xff", b"[]", b""])
def test_a_broken_line_is_a_transport_error(line: bytes) -> None:
    with pytest.raises(TransportError):
        decode(line)


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_an_error_crosses_the_wire_unchanged(error: Tool0Error) -> None:
    arrived = error_from_json(decode(encode(error_to_json(error))))
    assert type(arrived) is type(error)
    assert str(arrived) == str(error)
    assert vars(arrived) == vars(error)


def test_an_error_that_is_not_ours_arrives_as_a_transport_error() -> None:
    arrived = error_from_json(error_to_json(KeyError("x")))
    assert type(arrived) is TransportError
    assert "KeyError('x')" in str(arrived)


@pytest.mark.parametrize("broken", [None, {}, {"message": 5}, "x"])
def test_a_broken_error_is_a_transport_error(broken: object) -> None:
    assert type(error_from_json(broken)) is TransportError


@pytest.mark.parametrize(
    "result",
    [
        GoalResult(status=GoalStatus.SUCCEEDED),
        GoalResult(status=GoalStatus.ABORTED, error_code=-4, error_string="why"),
        GripperResult(
            status=GoalStatus.PREEMPTED,
            position=0.1,
            effort=-2.0,
            stalled=True,
            reached_goal=False,
        ),
    ],
)
def test_a_result_crosses_the_wire_unchanged(result: Result) -> None:
    assert result_from_json(decode(encode(result_to_json(result)))) == result


@pytest.mark.parametrize("answer", [{}, {"type": "GoalResult", "status": "MAYBE"}])
def test_a_broken_result_is_a_transport_error(answer: dict[str, object]) -> None:
    with pytest.raises(TransportError, match="broken result"):
        result_from_json(answer)


def test_lines_are_found_however_the_bytes_arrive() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        reader = LineReader(ours)
        theirs.sendall(b"one\ntwo\nthr")
        assert reader.next_line() == b"one"
        assert reader.next_line() == b"two"
        theirs.sendall(b"ee\n")
        assert reader.next_line() == b"three"
        theirs.sendall(b"cut off")
        theirs.close()
        assert reader.next_line() is None


def test_a_timeout_keeps_the_line_that_has_started() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        reader = LineReader(ours)
        ours.settimeout(0.001)
        theirs.sendall(b"a st")
        with pytest.raises(TimeoutError):
            reader.next_line()
        theirs.sendall(b"art\n")
        assert reader.next_line() == b"a start"


def test_the_longest_line_passes_and_one_byte_more_does_not() -> None:
    frame = len(encode({"x": ""}))
    assert len(encode({"x": "a" * (MAX_LINE - frame)})) == MAX_LINE
    with pytest.raises(LineTooLongError):
        encode({"x": "a" * (MAX_LINE - frame + 1)})


def test_numbers_of_numpy_s_travel_and_arrays_do_not() -> None:
    message = {"speed": np.float32(0.5), "n": np.int64(3)}
    assert decode(encode(message)) == {"speed": 0.5, "n": 3}
    with pytest.raises(TransportError, match=r"a list, got array\(\[0.5\]\)"):
        encode({"speed": np.array([0.5])})
