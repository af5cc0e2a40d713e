"""The bits of the progress are those that ur_rtde's AsyncOperationStatus reads."""

from tool0.ur.registers import Registers
from tool0.ur.rtde_control.exchange import Exchange, State


def test_uses_the_registers_from_its_offset_on() -> None:
    registers = Registers()
    exchange = Exchange(registers, 24)
    registers.inputs.integers[24] = 11
    registers.inputs.doubles[24:30] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert exchange.command == 11
    assert exchange.command_name == "input_int_register_24"
    assert exchange.six(0) == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert exchange.three(1) == (2.0, 3.0, 4.0)
    exchange.tell(State.DONE)
    exchange.answer([7.0, 8.0])
    assert registers.outputs.integers[24] == 2
    assert registers.outputs.doubles[24:26] == [7.0, 8.0]
    assert not any(registers.outputs.integers[:24])


def test_knows_which_arguments_a_command_came_with() -> None:
    exchange = Exchange(Registers(), 0)
    exchange.written = {"input_int_register_0", "input_double_register_0"}
    assert exchange.has_number(0)
    assert not exchange.has_number(6)


def test_progress_has_counters_a_state_and_a_number() -> None:
    registers = Registers()
    exchange = Exchange(registers, 0)

    def progress() -> tuple[int, int, int, int]:
        value = registers.outputs.integers[2]
        return value >> 24, value >> 16 & 0x7F, value >> 15 & 1, value & 0x7FFF

    exchange.show_progress(None)
    assert progress() == (0, 1, 0, 0)
    exchange.show_progress(0)
    assert progress() == (1, 2, 1, 0)
    exchange.show_progress(5)
    assert progress() == (1, 3, 1, 5)
    exchange.show_progress(None)
    assert progress() == (1, 4, 0, 0)
    for _ in range(300):
        exchange.show_progress(0)
    assert 0 < registers.outputs.integers[2] < 2**31
