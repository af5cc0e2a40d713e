import random

import pytest

from tool0.errors import TransportError
from tool0.ur.client_interface.scripts import (
    MAX_LINE,
    MAX_PROGRAM,
    UNNAMED,
    Script,
    ScriptReader,
)

PICK = """def pick():
  # if a comment has words such as def, while: they are no blocks
  popup("if this ends", "def")
  thread watch():
    while True:
      sync()
    end
  end
  if get_digital_in(0):
    movej([0, 0, 0, 0, 0, 0])
  elif get_digital_in(1):
    end_force_mode()
  else:
    stopj(1)
  end
end
"""
LIGHT = "sec light():\n  set_digital_out(1, True)\nend\n"
MOVE = "movej([0,0,0,0,0,0], a=1, v=1)\n"
ALL = [
    Script(PICK, "pick"),
    Script(MOVE, UNNAMED),
    Script(LIGHT, "light", is_secondary=True),
]
TEXT = f"\n# comment\r\n{PICK}{MOVE}\n{LIGHT}".encode()


def test_programs_are_blocks_and_single_lines():
    assert list(ScriptReader().read(TEXT)) == ALL


@pytest.mark.parametrize("seed", range(5))
def test_text_may_arrive_in_pieces_of_any_size(seed):
    chance, reader, found, start = random.Random(seed), ScriptReader(), [], 0
    while start < len(TEXT):
        end = start + chance.randint(1, 40)
        found += reader.read(TEXT[start:end])
        start = end
    assert found == ALL


def test_lines_may_end_with_carriage_returns():
    windows = PICK.replace("\n", "\r\n").encode()
    assert list(ScriptReader().read(windows)) == [Script(PICK, "pick")]


def test_an_unfinished_program_waits():
    reader = ScriptReader()
    assert list(reader.read(b"def f():\n  sync()\nend")) == []
    (script,) = reader.read(b"\n")
    assert script.text == "def f():\n  sync()\nend\n"


def test_a_block_may_be_one_line():
    (script,) = ScriptReader().read(b"def f(): sync() end\n")
    assert script == Script("def f(): sync() end\n", "f")


def test_bytes_that_are_no_text_are_programs_that_cannot_be_compiled():
    (script,) = ScriptReader().read(b"\xff\xfe\x00\n")
    assert script.name == UNNAMED


def test_long_lines_and_programs_are_refused():
    with pytest.raises(TransportError, match=f"a line has more than {MAX_LINE} bytes"):
        list(ScriptReader().read(b"a" * (MAX_LINE + 1)))
    endless = b"def f():\n" + b"  sync()\n" * (MAX_PROGRAM // 9 + 1)
    with pytest.raises(TransportError, match=f"program has more than {MAX_PROGRAM}"):
        list(ScriptReader().read(endless))


def test_a_call_of_the_program_before_it_starts_nothing_else() -> None:
    text = PICK + "pick()\n" + "pick()  # now\n" + "other()\n"
    assert list(ScriptReader().read(text.encode())) == [
        Script(PICK, "pick"),
        Script("other()\n", UNNAMED),
    ]


def test_a_program_without_its_end_has_a_name() -> None:
    reader = ScriptReader()
    assert list(reader.read(PICK.removesuffix("end\n").encode())) == []
    assert reader.unfinished == "pick"
    assert len(list(reader.read(b"end\n"))) == 1
    assert reader.unfinished == ""
