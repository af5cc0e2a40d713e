import pytest
from tool0.interfaces.socket.params import Params

from tool0.errors import TransportError


def test_a_key_that_nothing_reads_is_refused_with_the_nearest_one() -> None:
    params = Params("sim.step", {"tick": 3})
    assert params.count("ticks", default=1) == 1
    with pytest.raises(TransportError, match=r"unknown parameter 'tick'.*'ticks'"):
        params.finish()


def test_a_missing_key_is_named() -> None:
    with pytest.raises(TransportError, match=r"load: parameter 'name' is missing"):
        Params("load", {}).text("name")


@pytest.mark.parametrize(
    ("read", "value"),
    [
        (lambda p: p.text("key"), 5),
        (lambda p: p.flag("key", default=True), "yes"),
        (lambda p: p.count("key", default=1), 0),
        (lambda p: p.count("key", default=1), True),
        (lambda p: p.count("key", default=1), 1.5),
        (lambda p: p.number("key", 1.0), "1"),
        (lambda p: p.number("key", 1.0), False),
        (lambda p: p.number("key", 1.0), 10**400),
        (lambda p: p.names("key"), "elbow_joint"),
        (lambda p: p.names("key"), ["a", 1]),
        (lambda p: p.numbers("key"), [1.0, None]),
        (lambda p: p.number_by_name("key"), [1.0]),
        (lambda p: p.number_by_name("key"), {"a": "b"}),
        (lambda p: p.objects("key"), {}),
        (lambda p: p.objects("key"), [1]),
    ],
)
def test_a_value_of_the_wrong_kind_is_refused(read, value) -> None:
    with pytest.raises(TransportError, match="key"):
        read(Params("method", {"key": value}))


@pytest.mark.parametrize("raw", [[], "x", 5])
def test_params_that_are_no_object_are_refused(raw: object) -> None:
    with pytest.raises(TransportError, match="must be an object"):
        Params("method", raw)


def test_null_stands_for_an_optional_value_left_out() -> None:
    params = Params("method", {"a": None, "b": None, "c": None, "d": None})
    assert params.optional_number("a") is None
    assert params.optional_names("b") is None
    assert params.optional_numbers("c") is None
    assert params.number_by_name("d") is None
    params.finish()
