"""Programs that are clients of Modbus units, with pymodbus as the unit."""

from __future__ import annotations

import asyncio
import socket
from typing import Any, NamedTuple, cast

import pytest
from pymodbus.client import AsyncModbusTcpClient
from pymodbus.datastore import (
    ModbusDeviceContext,
    ModbusSequentialDataBlock,
    ModbusServerContext,
)
from pymodbus.server import ModbusTcpServer
from urscript_rig import Run, TimeBox, run_in_time, run_on


class Unit:
    """A unit with some inputs on, and input registers 100, 101, …"""

    def __init__(self) -> None:
        def block(values: list[Any]) -> Any:
            return cast("Any", ModbusSequentialDataBlock)(1, values)

        memory = ModbusDeviceContext(
            di=block([False, True] * 8),
            co=block([False] * 16),
            hr=block([0] * 16),
            ir=block(list(range(100, 116))),
        )
        with socket.create_server(("127.0.0.1", 0)) as free:
            self.port = free.getsockname()[1]
        context = ModbusServerContext(memory, single=True)
        self._server = ModbusTcpServer(context, address=("127.0.0.1", self.port))

    async def serve(self) -> None:
        await self._server.serve_forever(background=True)

    async def close(self) -> None:
        await cast("Any", self._server).shutdown()

    async def coils(self) -> list[bool]:
        """Return the coils as another client sees them."""
        client = AsyncModbusTcpClient("127.0.0.1", port=self.port)
        await client.connect()
        response = await client.read_coils(0, count=16)
        client.close()
        return list(response.bits)

    async def holding(self) -> list[int]:
        """Return the holding registers as another client sees them."""
        client = AsyncModbusTcpClient("127.0.0.1", port=self.port)
        await client.connect()
        response = await client.read_holding_registers(0, count=16)
        client.close()
        return list(response.registers)


class Outcome(NamedTuple):
    run: Run
    coils: list[bool]
    holding: list[int]


def run_with_unit(text: str) -> Outcome:
    """Run a program beside a unit; UNIT stands for its address."""
    box = TimeBox()

    async def run() -> Outcome:
        unit = Unit()
        await unit.serve()
        try:
            program = text.replace("UNIT", f'"127.0.0.1:{unit.port}"')
            done = await asyncio.wait_for(run_on(cast("Any", box), program), 20.0)
            return Outcome(done, await unit.coils(), await unit.holding())
        finally:
            await box.modbus.close()
            await unit.close()

    return asyncio.run(run())


WAIT = """
def wait_for(name):
  while modbus_get_error(name) != 0:
    sync()
  end
  while modbus_get_time_since_signal_invalid(name) > 0:
    sync()
  end
end
"""


def test_inputs_are_read() -> None:
    run, *_ = run_with_unit(
        WAIT
        + """
        modbus_add_signal(UNIT, 255, 1, 0, "door")
        modbus_add_signal(UNIT, 255, 3, 2, "level")
        modbus_add_signal(UNIT, 255, 2, 2, "levels", False, 3)
        modbus_add_signal(UNIT, 255, 0, 0, "doors", False, 10)
        wait_for("door")
        wait_for("level")
        wait_for("levels")
        wait_for("doors")
        textmsg(modbus_get_signal_status("door", False))
        textmsg(modbus_get_signal_status("level"))
        textmsg(modbus_get_signal_status("levels"))
        textmsg(modbus_get_signal_status("doors"))
        """
    )
    assert run.error is None
    doors = ", ".join(["False", "True"] * 5)
    assert run.texts == ["True", "103", "[102, 103, 104]", f"[{doors}]"]


def test_outputs_are_written() -> None:
    run, coils, holding = run_with_unit(
        WAIT
        + """
        modbus_add_signal(UNIT, 255, 4, 1, "lamp")
        modbus_add_signal(UNIT, 255, 5, 3, "speed")
        modbus_add_signal(UNIT, 255, 6, 16, "speeds", register_count = 3)
        modbus_add_signal(UNIT, 255, 6, 15, "lamps", register_count = 9)
        modbus_add_signal(UNIT, 255, 5, 2, "unused")
        modbus_add_rw_signal(UNIT, 255, 12, 2, 12, 2, "both")
        modbus_set_runstate_dependent_choice("speed", 0)
        modbus_set_output_signal("lamp", True)
        modbus_set_output_register("speed", 300, False)
        modbus_set_output_register("speeds", [7, 8])
        modbus_set_output_signal("lamps", [True, False, True])
        modbus_set_output_register("both", [5, 6])
        modbus_add_signal(UNIT, 255, 5, 3, "seen")
        modbus_add_signal(UNIT, 255, 6, 3, "seen2")
        modbus_add_signal(UNIT, 255, 8, 1, "seen3")
        modbus_add_signal(UNIT, 255, 4, 1, "seen4")
        while modbus_get_signal_status("seen") != 300:
          sync()
        end
        while modbus_get_signal_status("seen2") != 7:
          sync()
        end
        while not modbus_get_signal_status("seen3"):
          sync()
        end
        while not modbus_get_signal_status("seen4"):
          sync()
        end
        while modbus_get_signal_status("both")[1] != 6:
          sync()
        end
        """
    )
    assert run.error is None
    assert coils[4:5] == [True]
    assert coils[6:10] == [True, False, True, False]
    assert holding[5:9] == [300, 7, 8, 0]
    assert holding[12:14] == [5, 6]


def test_a_refusal_of_the_unit_is_told() -> None:
    run, *_ = run_with_unit(
        """
        modbus_add_signal(UNIT, 255, 500, 3, "far")
        modbus_set_signal_watchdog("far", 0)
        while modbus_get_error("far", 1) == 0:
          sync()
        end
        textmsg(modbus_get_error("far"))
        textmsg(modbus_get_error("far", 2))
        modbus_get_signal_status("far")
        """
    )
    assert run.texts == ["2", "0"]
    assert "invalid for more than 0 s: the unit answers with exception 2" in str(
        run.error
    )


def test_a_unit_that_is_not_there_is_told() -> None:
    run, *_ = run_with_unit(
        """
        modbus_add_signal("127.0.0.1:1", 255, 0, 3, "none")
        while modbus_get_error("none", 2) < 0:
          sync()
        end
        textmsg(modbus_get_error("none", 1))
        textmsg(modbus_get_error("none", 2) > 0)
        textmsg(modbus_get_signal_status("none"))
        modbus_set_signal_watchdog("none", 0)
        modbus_set_output_register("none", 1)
        """
    )
    assert run.texts == ["0", "True", "0"]
    assert "signal 'none' of 127.0.0.1:1 has been invalid" in str(run.error)


def test_a_custom_command_is_sent() -> None:
    run, _, holding = run_with_unit(
        "modbus_send_custom_command(UNIT, 103, 6, [0, 3, 2, 88])"
    )
    assert run.error is None
    assert holding[3:4] == [600]


def test_signals_stay_when_their_program_has_ended() -> None:
    box = TimeBox()

    async def run() -> tuple[Run, list[bool]]:
        unit = Unit()
        await unit.serve()
        address = f'"127.0.0.1:{unit.port}"'
        shared = cast("Any", box)
        try:
            await run_on(shared, f'modbus_add_signal({address}, 255, 2, 1, "lamp")')
            await run_on(
                shared,
                'modbus_set_output_signal("lamp", True)\n'
                'modbus_set_runstate_dependent_choice("lamp", 1)',
            )
            while not (await unit.coils())[2]:
                await asyncio.sleep(0.01)
            last = await run_on(
                shared,
                'modbus_delete_signal("lamp")\nmodbus_get_signal_status("lamp")',
            )
            return last, (await unit.coils())[2:3]
        finally:
            await box.modbus.close()
            await unit.close()

    last, lamp = asyncio.run(asyncio.wait_for(run(), 20.0))
    assert "there is no signal 'lamp'; modbus_add_signal adds one" in str(last.error)
    assert lamp == [True]


@pytest.mark.parametrize(
    ("line", "error"),
    [
        (
            'modbus_send_custom_command("10.0.0.1", 255, 6, [0, 0, 0, 0])',
            "to this machine only",
        ),
        ('modbus_add_signal("127.0.0.1:x", 255, 0, 1, "x")', "an address such as"),
        ('modbus_add_signal("127.0.0.1", 255, 0, 4, "x")', "0, 1, 2, 3, 15 or 16"),
        ('modbus_add_signal("127.0.0.1", 255, 0, 1, "")', "a name of 1 to 20 bytes"),
        ('modbus_get_error("y")', "there is no signal 'y'"),
        (
            'modbus_add_signal("127.0.0.1:1", 255, 0, 2, "x")\n'
            'modbus_set_output_register("x", 1)',
            "signal 'x' is not an output register",
        ),
        (
            'modbus_add_signal("127.0.0.1:1", 255, 0, 1, "x")\n'
            'modbus_set_output_signal("x", [True, True])',
            "signal 'x' has 1 values, not 2",
        ),
        (
            'modbus_add_signal("127.0.0.1:1", 255, 0, 3, "x")\n'
            'modbus_set_output_register("x", 65536)',
            "a value of signal 'x' is an integer from 0 to 65535",
        ),
    ],
)
def test_what_is_wrong_is_told(line: str, error: str) -> None:
    assert error in str(run_in_time(line).error)


def test_a_signal_of_another_machine_is_invalid() -> None:
    run = run_in_time(
        """
        modbus_add_signal("10.0.0.1", 255, 0, 0, "x")
        while modbus_get_error("x", 2) < 0:
          sync()
        end
        textmsg(modbus_get_error("x", 2))
        modbus_set_signal_watchdog("x", 0)
        modbus_get_signal_status("x")
        """
    )
    assert run.texts == ["13"]
    assert run.errors == [
        "modbus_add_signal: programs connect to this machine only, not to '10.0.0.1'; "
        "other machines need the option --ur-sockets"
    ]
    assert "signal 'x' of 10.0.0.1:502 has been invalid" in str(run.error)
