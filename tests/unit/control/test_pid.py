import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.control.pid import Gains, Pid, PidBank
from tool0.errors import ConfigError

numbers = st.floats(-100.0, 100.0)
gains = st.builds(
    Gains,
    p=numbers,
    i=numbers,
    d=numbers,
    i_min=st.floats(-10.0, 0.0),
    i_max=st.floats(0.0, 10.0),
    antiwindup=st.booleans(),
)
errors = st.lists(st.tuples(numbers, numbers), min_size=1, max_size=20)


@given(st.lists(gains, min_size=1, max_size=4), errors)
def test_a_bank_computes_what_single_laws_compute(
    bank_gains: list[Gains], sequence: list[tuple[float, float]]
) -> None:
    bank = PidBank(bank_gains)
    singles = [Pid(item) for item in bank_gains]
    for error, rate in sequence:
        n = len(bank_gains)
        commands = bank.update([error] * n, [rate] * n, 0.01)
        assert commands == [pid.update(error, rate, 0.01) for pid in singles]


def test_computes_the_formula_of_control_toolbox() -> None:
    pid = Pid(Gains(p=10.0, i=2.0, d=0.5, i_min=-1.0, i_max=1.0))
    assert pid.update(0.3, -0.2, 0.1) == pytest.approx(3.0 + 2 * 0.03 - 0.1)
    assert pid.update(0.3, 0.0, 0.1) == pytest.approx(3.0 + 2 * 0.06)


@given(st.floats(0.1, 100.0), errors)
def test_the_integral_contributes_no_more_than_its_clamp(
    i: float, sequence: list[tuple[float, float]]
) -> None:
    pid = Pid(Gains(p=0.0, i=i, i_min=-0.2, i_max=0.3))
    for error, _ in sequence:
        assert -0.2 <= pid.update(error, 0.0, 0.1) <= 0.3


def test_without_a_clamp_the_integral_contributes_nothing() -> None:
    pid = Pid(Gains(p=0.0, i=1000.0))
    assert pid.update(1.0, 0.0, 1.0) == 0.0


def test_antiwindup_lets_the_integral_turn_back_at_once() -> None:
    wound, unwound = (
        Pid(Gains(p=0.0, i=1.0, i_min=-1.0, i_max=1.0, antiwindup=flag))
        for flag in (False, True)
    )
    for _ in range(10):
        assert wound.update(1.0, 0.0, 1.0) == unwound.update(1.0, 0.0, 1.0) == 1.0
    assert unwound.update(-0.5, 0.0, 1.0) == pytest.approx(0.5)
    assert wound.update(-0.5, 0.0, 1.0) == 1.0


@pytest.mark.parametrize("error", [math.nan, math.inf])
def test_an_error_that_is_not_finite_commands_nothing_and_is_forgotten(
    error: float,
) -> None:
    pid = Pid(Gains(p=1.0, i=1.0, i_min=-9.0, i_max=9.0))
    assert pid.update(error, 0.0, 1.0) == 0.0
    assert pid.update(0.0, error, 1.0) == 0.0
    assert pid.update(1.0, 0.0, 1.0) == 2.0


def test_no_time_passing_commands_nothing() -> None:
    assert Pid(Gains(p=1.0)).update(1.0, 1.0, 0.0) == 0.0
    assert PidBank([Gains(p=1.0)]).update([1.0], [1.0], 0.0) == [0.0]


def test_the_one_error_form_differentiates_and_kicks_first() -> None:
    pid = Pid(Gains(p=0.0, d=2.0))
    assert pid.update_from_error(0.5, 0.1) == pytest.approx(2.0 * 0.5 / 0.1)
    assert pid.update_from_error(0.6, 0.1) == pytest.approx(2.0 * 0.1 / 0.1)


def test_gains_must_be_numbers() -> None:
    with pytest.raises(ConfigError, match="finite"):
        Gains(p=math.nan)
    with pytest.raises(ConfigError, match="i_min"):
        Gains(p=1.0, i_min=1.0, i_max=2.0)
