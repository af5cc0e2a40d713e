"""The program on the controller: it is URScript of both series."""

import asyncio
import re

import pytest

from tool0.engines.real_robot.control_program import control_program
from tool0.ur.compiling import compiled


@pytest.mark.parametrize("period", [0.002, 0.008], ids=["e-Series", "CB3"])
def test_it_is_a_program_without_anything_left_to_fill_in(period: float) -> None:
    text = control_program("127.0.0.1", 50010, 12345, period)
    asyncio.run(compiled(text, "tool0_control"))
    code = "\n".join(line.partition("#")[0] for line in text.splitlines())
    assert not re.search(r"\$|each\(|\[#\]", code)
    assert 'socket_open("127.0.0.1", 50010, "tool0_knots")' in text


def test_a_cb3_computes_with_numbers_only() -> None:
    text = control_program("127.0.0.1", 50010, 1, 0.008)
    (line,) = (line for line in text.splitlines() if "local x = [c0[0]" in line)
    assert line.count("c0[") == 6
