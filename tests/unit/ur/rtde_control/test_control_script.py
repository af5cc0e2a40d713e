"""Only what the program's revisions have in common is needed to recognise one."""

import pytest

from tool0.errors import ConfigError, ControlError
from tool0.ur.rtde_control.script import parse

PROGRAM = """\
def rtde_control():
    global reg_offset_float = # float register offset
{offset}    global reg_offset_int = # int register offset
{offset}    global is_servoing = 0
    def exec_move_path():
        # inject move path
{path}    end
    def rtde_cmd():
      return read_input_integer_reg(0)
    end
    def signal_done_with_cmd():
        write_output_integer_reg(0, 2)
    end
    def process_cmd(cmd):
        if cmd == 1:
            q = 0
        elif cmd == 33:
            q = 1
        end
    end
        textmsg("RTDE Control Script Loaded (14.02.2024-12:23)")
end
"""
JOINTS = (
    "\tsignal_async_progress({})\n\tmovej([0,-1.5,1.5e-05,-1,2,+.5],a=1.4,v=1,r=0)\n"
)
LINE = "\tmovel(p[-0.1,-0.4,0.2,0,3.14,0],a=1.2,v=0.25,r=0.02)\n"


def text(offset: int = 0, path: str = "") -> str:
    return PROGRAM.format(offset=offset, path=path)


def test_tells_ur_rtdes_program_from_others() -> None:
    script = parse(text())
    assert script is not None
    assert script.name == "rtde_control"
    assert script.revision == "14.02.2024-12:23"
    assert script.codes == {1, 33}
    assert script.path == ()
    for other in ("", "movej([0,0,0,0,0,0])\n", "def rtde_control():\n  sync()\nend\n"):
        assert parse(other) is None


@pytest.mark.parametrize("offset", [0, 24])
def test_reads_the_offset_of_the_registers(offset: int) -> None:
    script = parse(text(offset))
    assert script is not None
    assert script.offset == offset


def test_rejects_another_offset() -> None:
    with pytest.raises(ConfigError, match="0 or 24"):
        parse(text(7))


def test_reads_the_path_that_the_client_inserts() -> None:
    script = parse(text(path=JOINTS.format(0) + LINE))
    assert script is not None
    first, second = script.path
    assert (first.kind, first.pose) == ("joint", None)
    assert first.q == (0.0, -1.5, 1.5e-05, -1.0, 2.0, 0.5)
    assert (first.a, first.v, first.r) == (1.4, 1.0, 0.0)
    assert (second.kind, second.q) == ("linear", None)
    assert second.pose == (-0.1, -0.4, 0.2, 0.0, 3.14, 0.0)
    assert (second.a, second.v, second.r) == (1.2, 0.25, 0.02)


@pytest.mark.parametrize(
    "line",
    [
        "\tmovec(p[0,0,0,0,0,0],a=1,v=1,r=0)\n",
        "\tmovej([0,0,0,0,0],a=1,v=1,r=0)\n",
        "\tmovej([0,0,0,0,0,nan],a=1,v=1,r=0)\n",
        "\tset_standard_digital_out(0, True)\n",
    ],
)
def test_rejects_a_path_that_ur_rtde_does_not_write(line: str) -> None:
    with pytest.raises(ConfigError, match=r"rtde_control, line 9: .* is not a move"):
        parse(text(path=JOINTS.format(0) + line))


def test_rejects_moves_without_speed() -> None:
    with pytest.raises(ControlError, match="above 0"):
        parse(text(path=LINE.replace("v=0.25", "v=0")))
