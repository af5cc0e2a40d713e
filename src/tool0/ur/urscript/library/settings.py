"""Settings that PolyScope's programs make at the start and that have no effect."""

from __future__ import annotations

from typing import Final

from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import AnyValue, Bool, Integer, Number, Text
from tool0.ur.urscript_errors import ValueProblem

_BAUD_RATES: Final = (*(9600, 19200, 38400, 57600, 115200, 1000000, 2000000, 5000000),)


def set_input_actions_to_default() -> None:
    """Ignore the setting, because inputs have no actions."""


def set_safety_mode_transition_hardness(type_: Integer) -> None:
    """Ignore the setting."""


def _input_domain(port: Integer, domain: Integer) -> None:
    """Ignore the setting, because the simulation sets the domain of inputs."""


def _input_action(port: Integer, action: Text) -> None:
    if action != "default":
        raise ValueProblem(f'inputs have no actions but "default", not "{action}"')


def _runstate_output(outputId: Integer, state: Integer) -> None:
    if state:
        raise ValueProblem("outputs do not follow the state of the program: 0 is left")


def _accept_one(value: AnyValue) -> None:
    """Ignore the setting."""


def _accept_two(index: Integer, value: AnyValue) -> None:
    """Ignore the setting."""


def _accept_none() -> None:
    """Ignore the setting."""


def set_tool_communication(
    enabled: Bool,
    baud_rate: Integer = 115200,
    parity: Integer = 0,
    stop_bits: Integer = 1,
    rx_idle_chars: Number = 1.5,
    tx_idle_chars: Number = 3.5,
) -> None:
    """Ignore the setting, because the gripper's port does not depend on it."""
    del enabled
    if baud_rate not in _BAUD_RATES or parity not in {0, 1, 2}:
        raise ValueProblem(f"{baud_rate} baud with parity {parity} is not possible")
    if stop_bits not in {1, 2}:
        raise ValueProblem(f"there are 1 or 2 stop bits, not {stop_bits}")
    if not (1.0 <= rx_idle_chars <= 40.0 and 0.0 <= tx_idle_chars <= 40.0):
        raise ValueProblem("pauses are up to 40 characters, before reading at least 1")


FUNCTIONS: Final[tuple[Function, ...]] = (
    function(set_input_actions_to_default),
    function(set_safety_mode_transition_hardness),
    function(set_tool_communication),
    function(_input_domain, "set_standard_analog_input_domain"),
    function(_input_domain, "set_tool_analog_input_domain"),
    function(_accept_two, "set_analog_inputrange"),
    function(_accept_one, "set_tool_output_mode"),
    function(_accept_two, "set_tool_digital_output_mode"),
    function(_accept_none, "high_holding_torque_enable"),
    function(_accept_none, "high_holding_torque_disable"),
    *(
        function(_input_action, f"set_{group}_input_action")
        for group in (
            *("standard_digital", "configurable_digital", "tool_digital"),
            "gp_boolean",
        )
    ),
    *(
        function(_runstate_output, f"set_runstate_{group}_output_to_value")
        for group in (
            *("standard_digital", "configurable_digital", "tool_digital"),
            *("standard_analog", "gp_boolean"),
        )
    ),
)
