"""Lengths and angles as people type them."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.description.units import ANGLE, LENGTH, SPEED, Quantity, read_number
from tool0.errors import ConfigError


@given(st.floats(-1e3, 1e3))
def test_a_unit_scales_the_number(value: float) -> None:
    for quantity, unit, factor in (
        (LENGTH, "m", 1.0),
        (LENGTH, "mm", 1e-3),
        (ANGLE, "rad", 1.0),
        (ANGLE, "deg", math.pi / 180.0),
    ):
        read, measured = read_number(f"{value!r}{unit}", ANGLE, LENGTH)
        assert read == pytest.approx(factor * value)
        assert measured is quantity


@pytest.mark.parametrize("text", ["1", "-.5", "+1.", "1e-3", " 2 ", "1E2"])
def test_a_number_without_a_unit_is_in_si(text: str) -> None:
    assert read_number(text, LENGTH) == (float(text), None)


@pytest.mark.parametrize(
    ("text", "quantities", "said"),
    [
        ("x", (LENGTH,), "'x': need a finite number, alone or with m, mm"),
        ("", (), "'': need a finite number"),
        ("nan", (ANGLE,), "'nan': need a finite number, alone or with rad, deg"),
        ("1e400", (ANGLE, LENGTH), "'1e400': need a finite number"),
        ("1 2", (LENGTH,), "'1 2'"),
        ("40cm", (LENGTH,), "'cm' is not a unit here"),
        ("40mm", (ANGLE,), "'mm' is not a unit here"),
        (
            "180",
            (ANGLE,),
            "180 rad is no plausible angle; did you mean 180deg = 3.142 rad?",
        ),
        ("250", (SPEED,), "did you mean 250mm/s = 0.25 m/s?"),
        ("deg(x)", (ANGLE,), "'deg(x)': need a finite number"),
        ("deg(9)", (LENGTH,), "'deg' is not a unit here"),
        ("-90", (ANGLE,), "did you mean -90deg = -1.571 rad?"),
    ],
)
def test_what_is_not_understood_is_refused(
    text: str, quantities: tuple[Quantity, ...], said: str
) -> None:
    with pytest.raises(ConfigError, match=re.escape(said)):
        read_number(text, *quantities)


def test_a_joint_position_of_unknown_quantity_may_be_large() -> None:
    assert read_number("720", ANGLE, LENGTH) == (720.0, None)


@pytest.mark.parametrize(
    ("value", "hint"),
    [(40.0, "; did you mean 40mm = 0.04 m?"), (400.0, ""), (0.5, ""), (math.inf, "")],
)
def test_a_suggestion_needs_a_large_value_that_would_fit(
    value: float, hint: str
) -> None:
    assert LENGTH.suggestion(value, lambda meant: meant <= 0.085) == hint
