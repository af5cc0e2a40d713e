"""Functions of the control box, and which functions there are."""

from __future__ import annotations

import asyncio
from typing import Any, cast

import pytest
from urscript_rig import PROGRAMS, TimeBox, run_in_time, run_on

from tool0.ur.rtde_sensor import RtdeSensor
from tool0.ur.urscript.library.table import library
from tool0.ur.urscript.unsupported import reason_against


def test_every_function_of_the_manual_is_there_or_refused_with_a_reason() -> None:
    names = (PROGRAMS / "manual_functions.txt").read_text().split()
    assert len(names) > 250
    missing = [name for name in names if name not in library()]
    assert [name for name in missing if reason_against(name) is None] == []


def test_encoders_count_what_programs_set() -> None:
    run = run_in_time(
        """
        encoder_enable_set_tick_count(0, 2)
        encoder_set_tick_count(0, 65530)
        before = encoder_get_tick_count(0)
        encoder_set_tick_count(0, 864)
        delta = encoder_get_tick_count(0) - before
        textmsg(delta)
        textmsg(encoder_unwind_delta_tick_count(0, delta))
        textmsg(encoder_unwind_delta_tick_count(0, -3))
        encoder_set_tick_count(0, 65536)
        """
    )
    assert run.texts == ["-64666", "870", "-3"]
    assert "count is 65536; it is from 0 to 65535" in str(run.error)


def test_what_does_not_change_is_told() -> None:
    run = run_in_time(
        """
        set_baselight_solid(0, 0, 255)
        pause_on_error_code(50, 1)
        set_base_acceleration([0, 0, 0])
        textmsg(get_base_acceleration())
        textmsg(get_joint_temp(5))
        textmsg(force_mode_get_damping(), force_mode_get_gain_scaling())
        textmsg(get_actual_joint_accelerations())
        set_base_acceleration([0, 0, 1])
        """
    )
    zeros = "[0, 0, 0]"
    assert run.texts == [zeros, "25", "0.0051", "[0, 0, 0, 0, 0, 0]"]
    assert "the base does not move: [0, 0, 0] is needed" in str(run.error)


def test_outputs_of_rtde_are_values() -> None:
    run = run_in_time(
        """
        write_output_integer_register(3, 7)
        write_output_boolean_register(64, True)
        textmsg(get_rtde_value("output_int_register_3"))
        textmsg(get_rtde_value("output_bit_register_64"))
        textmsg(get_rtde_value("joint_temperatures"))
        textmsg(get_rtde_value("nothing"))
        """
    )
    assert run.texts == ["7", "True", "[25, 25, 25, 25, 25, 25]"]
    assert "RTDE has no output 'nothing'" in str(run.error)


@pytest.mark.slow
def test_a_program_ends_when_its_watchdog_is_not_served() -> None:
    box = TimeBox()

    async def run() -> Any:
        text = (
            'rtde_set_watchdog("input_int_register_0", 2, "stop")\n'
            "while True:\n  sync()\nend"
        )
        task = asyncio.create_task(run_on(cast("Any", box), text))
        for _ in range(6):
            await asyncio.sleep(0.1)
            box.registers.written({"input_int_register_0"})
        assert not task.done()
        return await task

    outcome = asyncio.run(asyncio.wait_for(run(), 20.0))
    assert str(outcome.error) == (
        "RTDE watchdog: 'input_int_register_0' was not written for 0.5 s"
    )


@pytest.mark.parametrize(
    ("call", "error"),
    [
        ('rtde_set_watchdog("x", 10)', "RTDE has no input 'x'"),
        ('rtde_set_watchdog("input_int_register_0", 0)', "it is greater than 0"),
        ('rtde_set_watchdog("input_int_register_0", 9, "go")', "the action is 'go'"),
    ],
)
def test_a_watchdog_that_cannot_be_is_refused(call: str, error: str) -> None:
    assert error in str(run_in_time(call).error)


def test_a_paused_program_waits_for_its_watchdog_no_more() -> None:
    box = TimeBox()

    async def run() -> None:
        text = (
            'rtde_set_watchdog("input_int_register_0", 50)\nwhile True:\n  sync()\nend'
        )
        task = asyncio.create_task(run_on(cast("Any", box), text))
        while not box.programs.is_paused:
            await asyncio.sleep(0.01)
        task.cancel()
        await asyncio.wait([task])

    asyncio.run(asyncio.wait_for(run(), 20.0))


def test_forces_of_rtde_are_measured_at_the_sensor() -> None:
    sensor = RtdeSensor()
    sensor.read((0.0, 0.0, 5.0, 0.0, 0.0, 0.0))
    assert not sensor.is_used
    sensor.set_offset((0.1, 0.0, 0.0))
    assert sensor.is_used
    assert sensor.wrench == pytest.approx((0.0, 0.0, 5.0, 0.0, -0.5, 0.0))
    sensor.tare()
    assert sensor.wrench == pytest.approx((0.0,) * 6)


def test_pass_can_be_a_variable() -> None:
    run = run_in_time(
        """
        def f():
          local pass = 1
          pass
          return pass + 1
        end
        if True:
          pass
        end
        textmsg(f())
        """
    )
    assert run.texts == ["2"]


def test_a_statement_begins_where_the_one_before_it_ends() -> None:
    run = run_in_time('x = [1, 2] y = x[1] if y == 2: textmsg(y) end textmsg("end")')
    assert run.texts == ["2", "end"]


def test_settings_of_an_installation_are_accepted() -> None:
    run = run_in_time(
        """
        tool_wrench_limit_disable()
        motion_version_set(2)
        set_tool_communication(True, 115200, 0, 1, 1.5, 3.5)
        textmsg(motion_version_get())
        set_tool_communication(True, 115201, 0, 1, 1.5, 3.5)
        """
    )
    assert run.texts == ["2"]
    assert "115201 baud with parity 0 is not possible" in str(run.error)
