"""Any text is a program or is rejected with a place; any program ends or waits."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from urscript_rig import PROGRAMS, run_in_time

from tool0.ur.urscript.program import compile_program
from tool0.ur.urscript_errors import URScriptError

WORDS = [
    "def",
    "f",
    "(",
    ")",
    ":",
    "\n",
    "end",
    "if",
    "else",
    "elif",
    "while",
    "True",
    "False",
    "x",
    "y",
    "p",
    "[",
    "]",
    ",",
    "=",
    "==",
    "+",
    "-",
    "*",
    "/",
    "%",
    "not",
    "and",
    "or",
    "xor",
    "1",
    "2.5",
    ".5",
    "1e3",
    '"',
    "'a'",
    '"s"',
    "#",
    "$",
    "thread",
    "run",
    "join",
    "kill",
    "global",
    "local",
    "return",
    "break",
    "continue",
    "halt",
    "pause",
    "pass",
    "enter_critical",
    "exit_critical",
    "sec",
    "sync",
    "movej",
    "get_actual_joint_positions",
    "str_cat",
    "\t",
    "\r",
    ";",
    ".",
    "!",
    "é",
    "\x00",
]
SOURCES = [path.read_text() for path in sorted(PROGRAMS.glob("*.script"))]
# Statements that take no time, so that what runs ends:
SIMPLE = st.sampled_from(
    [
        "x = x + 1",
        "x = [x, y]",
        "y = x / (y - 1)",
        "if x > y:\ny = x\nelse:\nx = y\nend",
        "x = p[1, 2, 3, 4, 5, 6]",
        "y = x[1]",
        "x[0] = y",
        'x = str_cat(x, "a")',
        "x = norm(x)",
        "x = -x",
        "x = x * x",
        "x = x == y",
        "y = length(x)",
        "x = pose_trans(x, x)",
        "x = make_list(y, x)",
        "while x < 5:\nx = x + 1\nend",
        "sync()",
    ]
)


def compiles_or_tells(text: str) -> None:
    found: URScriptError | None = None
    try:
        compile_program(text, "p")
    except URScriptError as error:
        found = error
    if found is not None:
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        assert 1 <= found.line <= len(lines)
        assert 1 <= found.column <= len(lines[found.line - 1]) + 1
        assert str(found) == f"p:{found.line}:{found.column}: {found.message}"


@given(st.text(max_size=200))
@settings(max_examples=80, deadline=None)
def test_any_text(text: str) -> None:
    compiles_or_tells(text)


@given(st.lists(st.sampled_from(WORDS), max_size=40), st.sampled_from(["", " "]))
@settings(max_examples=150, deadline=None)
def test_words_of_the_language_in_any_order(words: list[str], gap: str) -> None:
    compiles_or_tells(gap.join(words))


@given(
    st.sampled_from(SOURCES),
    st.integers(0, 2000),
    st.integers(0, 30),
    st.sampled_from([*WORDS, ""]),
)
@settings(max_examples=80, deadline=None)
def test_damaged_programs(source: str, start: int, length: int, word: str) -> None:
    start %= len(source)
    compiles_or_tells(source[:start] + word + source[start + length :])


@pytest.mark.slow
@given(st.lists(SIMPLE, max_size=12))
@settings(max_examples=150, deadline=None)
def test_programs_end_or_fail_with_a_place(statements: list[str]) -> None:
    run = run_in_time("x = 1\ny = 2\n" + "\n".join(statements))
    assert run.error is None or isinstance(run.error, URScriptError)
