import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tool0.control.parameters import Pid
from tool0.errors import ConfigError
from tool0.protocol.controllers import Gains, Unwinding

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


def updates(pid: Pid, *errors: float, rate: float = 0.0, period: float = 0.1) -> list:
    """Return the commands of one joint for errors one after the other."""
    return [pid.update([error], [rate], period)[0] for error in errors]


@given(st.lists(gains, min_size=1, max_size=4), errors)
def test_each_joint_has_a_law_of_its_own(
    several: list[Gains], sequence: list[tuple[float, float]]
) -> None:
    n = len(several)
    together, singles = Pid(several), [Pid([item]) for item in several]
    for error, rate in sequence:
        commands = together.update([error] * n, [rate] * n, 0.01)
        assert commands == [pid.update([error], [rate], 0.01)[0] for pid in singles]


def test_computes_the_formula_of_control_toolbox() -> None:
    pid = Pid([Gains(p=10.0, i=2.0, d=0.5, i_min=-1.0, i_max=1.0)])
    assert updates(pid, 0.3, rate=-0.2) == pytest.approx([3.0 + 2 * 0.03 - 0.1])
    assert updates(pid, 0.3) == pytest.approx([3.0 + 2 * 0.06])


@given(st.floats(0.1, 100.0), st.lists(numbers))
def test_the_integral_contributes_no_more_than_its_clamp(
    i: float, sequence: list[float]
) -> None:
    pid = Pid([Gains(p=0.0, i=i, i_min=-0.2, i_max=0.3)])
    assert all(-0.2 <= command <= 0.3 for command in updates(pid, *sequence))


def test_without_a_clamp_the_integral_contributes_nothing() -> None:
    assert updates(Pid([Gains(p=0.0, i=1000.0)]), 1.0) == [0.0]


@pytest.mark.parametrize(("antiwindup", "after"), [(True, 0.5), (False, 1.0)])
def test_antiwindup_lets_the_integral_turn_back_at_once(
    antiwindup: bool, after: float
) -> None:
    pid = Pid([Gains(p=0.0, i=1.0, i_min=-1.0, i_max=1.0, antiwindup=antiwindup)])
    assert updates(pid, *[1.0] * 10, period=1.0) == [1.0] * 10
    assert updates(pid, -0.5, period=1.0) == [after]


def test_no_time_passing_commands_nothing() -> None:
    assert updates(Pid([Gains(p=1.0)]), 1.0, rate=1.0, period=0.0) == [0.0]


@pytest.mark.parametrize("bad", [{"p": math.nan}, {"p": 1.0, "i_min": 1.0}])
def test_gains_must_be_finite_and_a_clamp_must_hold_0(bad: dict[str, float]) -> None:
    with pytest.raises(ConfigError):
        Gains(**bad, i_max=2.0)


@given(gains, gains, errors)
def test_new_gains_keep_what_the_integral_contributes(
    old: Gains, new: Gains, sequence: list[tuple[float, float]]
) -> None:
    assume(new.i == 0.0 or abs(new.i) > 1e-300)  # others have no inverse
    pid = Pid([old])
    for error, rate in sequence:
        pid.update([error], [rate], 0.01)
    (before,) = pid.update([0.0], [0.0], 1e-9)
    pid.set_gains(0, new)
    (after,) = pid.update([0.0], [0.0], 1e-9)
    kept = min(max(before, new.i_min), new.i_max)
    assert after == pytest.approx(kept if new.i else 0.0, abs=1e-9)
    pid.set_gains(0, Gains(p=3.0))
    assert updates(pid, 2.0) == [6.0]


# ---- what ROS 2 adds -----------------------------------------------------------------


@given(gains, errors, st.floats(0.0, 5.0))
def test_the_command_stays_within_its_limits(
    item: Gains, sequence: list[tuple[float, float]], limit: float
) -> None:
    limited = Pid([replace(item, u_min=-limit, u_max=2 * limit)])
    for error, rate in sequence:
        (command,) = limited.update([error], [rate], 0.01)
        assert -limit <= command <= 2 * limit


def test_errors_within_the_deadband_are_not_integrated() -> None:
    item = Gains(p=0.0, i=1.0, i_min=-9.0, i_max=9.0, error_deadband=0.5)
    assert updates(Pid([item]), 0.5, -0.5, 1.0, 0.2) == [0.0, 0.0, 0.1, 0.1]


def test_a_limited_command_keeps_the_integral_from_growing() -> None:
    def integral(unwinding: Unwinding, error: float = 1.0) -> float:
        item = Gains(
            p=1.0, i=1.0, i_min=-99.0, i_max=99.0, u_min=-0.5, u_max=0.5,
            unwinding=unwinding, tracking_time=0.5,
        )  # fmt: skip
        pid = Pid([item])
        updates(pid, *[error] * 100)
        return pid.integrals[0]

    assert integral(Unwinding.NONE) == pytest.approx(10.0)
    assert integral(Unwinding.CONDITIONAL_INTEGRATION) == 0.0
    # It settles where the excess of the command balances the error.
    assert abs(integral(Unwinding.BACK_CALCULATION)) < 0.2
    for unwinding in Unwinding:
        assert integral(unwinding, 0.001) == pytest.approx(0.01)
