"""Malformed programs, each with the place and the words of its rejection."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from raises_naming import raises_naming
from tools.urscript_docs import GUIDES, PAGES, page

from tool0.errors import Tool0Error
from tool0.ur.urscript.library.table import library
from tool0.ur.urscript.program import compile_program
from tool0.ur.urscript.unsupported import reason_against
from tool0.ur.urscript_errors import URScriptError

DATA = Path(__file__).parents[3] / "data" / "urscript"
CASES = re.findall(
    r"(.*?)\n>>> ([^\n]*)\n", (DATA / "malformed.txt").read_text(), flags=re.DOTALL
)


def test_there_are_enough_cases() -> None:
    assert len(CASES) >= 50


@pytest.mark.parametrize(("text", "expected"), CASES)
def test_it_is_rejected_where_it_is_wrong(text: str, expected: str) -> None:
    with pytest.raises(URScriptError) as caught:
        compile_program(text.removeprefix("\n"), "p")
    assert str(caught.value) == f"p:{expected}"
    assert expected.startswith(f"{caught.value.line}:{caught.value.column}: ")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = " + "(" * 101 + "1" + ")" * 101, "nested deeper than 100"),
        ("x = " + "-" * 101 + "1", "nested deeper than 100"),
        ("x = " + "not " * 101 + "True", "nested deeper than 100"),
        ("if True:\n" * 101 + "end\n" * 101, "nested deeper than 100"),
        ("#" * 1_000_001, "1000001 characters"),
        ("x = [" + "1," * 10_000 + "1]", "at most 10000 elements"),
        ('x = "' + "a" * 600 + '" + "' + "b" * 600 + '"', "at most 1023 bytes"),
        ('x = "' + "a" * 1100 + '"', "at most 1023 bytes"),
        (
            "x = " + "a" * 100_000,
            "p:1:405: unexpected 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaa'",
        ),
        ("x = 1e999", "too large"),
        ("x = [[1, 2], [3]]", "equal lengths"),
        ("x = [[[1]]]", "nested once"),
        ("x = 2147483647 + 1", "32 bits"),
    ],
)
def test_limits_hold_before_anything_runs(text: str, words: str) -> None:
    with pytest.raises(URScriptError, match=words):
        compile_program(text, "p")


@pytest.mark.slow
def test_100_levels_and_long_chains_are_no_problem() -> None:
    compile_program("x = " + "(" * 100 + "1" + ")" * 100)
    compile_program("if True:\n" * 100 + "end\n" * 100)
    compile_program("x = 1" + " + 1" * 20_000)
    compile_program("x = 1\nif x == 0:\n" + "elif x == 1:\n" * 2_000 + "end")


def test_line_endings_tabs_labels_and_one_line_programs() -> None:
    assert compile_program("def a():\r\n\tsync()\r\nend\r\n").name == "a"
    assert compile_program("def a():\r  sync()\rend\r").name == "a"
    assert compile_program("def a(): sync() end").name == "a"
    assert compile_program('def a():\n  $ 1 "Robot Program"\n  sync()\nend').name == "a"
    assert compile_program("set_digital_out(0, True)\n", "line").name == "line"
    assert compile_program("sec s():\n set_digital_out(0, True)\nend").is_secondary
    with raises_naming(URScriptError, "t:2:5: unknown variable"):
        compile_program("x = 1\r\ny = z\r\n", "t")


def test_of_several_definitions_the_last_one_is_the_program() -> None:
    text = "def helper():\n  return 1\nend\ndef main():\n  x = helper()\nend\n"
    assert compile_program(text).name == "main"


def test_a_program_may_define_functions_that_the_library_has() -> None:
    compile_program("def rq_open(a, b, c):\n  sync()\nend\nrq_open(1, 2, 3)\n")


def test_no_supported_function_counts_as_unsupported() -> None:
    assert {name for name in library() if reason_against(name)} == set()


@pytest.mark.parametrize(
    ("name", "signature"),
    [
        ("movej", "movej(q, a=1.4, v=1.05, t=0, r=0)"),
        ("movel", "movel(pose, a=1.2, v=0.25, t=0, r=0)"),
        ("movep", "movep(pose, a=1.2, v=0.25, r=0)"),
        ("movec", "movec(pose_via, pose_to, a=1.2, v=0.25, r=0, mode=0)"),
        ("servoj", "servoj(q, a=0, v=0, t=0.002, lookahead_time=0.1, gain=300)"),
        ("str_find", "str_find(src, target, start_from=0)"),
        ("set_tcp", 'set_tcp(pose, tcp_name="")'),
        ("socket_open", 'socket_open(address, port, socket_name="socket_0")'),
    ],
)
def test_signatures_are_those_of_the_manual(name: str, signature: str) -> None:
    assert library()[name].signature == signature


def test_errors_are_errors_of_tool0() -> None:
    assert issubclass(URScriptError, Tool0Error)


@pytest.mark.parametrize("name", PAGES)
def test_the_documentation_lists_every_function(name: str) -> None:
    found = (GUIDES / name).read_text("utf-8")
    assert found == page(name), "run: .venv/bin/python tools/urscript_docs.py"
