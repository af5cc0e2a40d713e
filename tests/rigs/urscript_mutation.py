"""URScript programs at random: those of a corpus with lines and tokens changed.

Most of them still compile, so that what they do is tried, and not only the checks.
"""

from __future__ import annotations

import random
import re
from pathlib import Path
from typing import Final

DATA: Final = Path(__file__).parents[1] / "data"
CALLS: Final = tuple((DATA / "urscript_fuzz" / "calls.txt").read_text().splitlines())
"""Statements that call every function of the library."""
HEAD: Final = """\
def program():
  x = 1
  b = True
  text = "abc"
  items = [1, 2, 3]
  m = [[1, 2], [3, 4]]
  s = struct(a = 1, b = "two", c = [1, 2, 3])
  q = get_actual_joint_positions()
  here = get_actual_tcp_pose()
  pose = here
"""
"""The variables of those statements."""
_TOKEN: Final = re.compile(
    r"\d+\.?\d*(?:[eE][-+]?\d+)?|\w+|\"[^\"\n]*\"|[-+*/%<>=!]=?|\s+|."
)
_NUMBER: Final = re.compile(r"\d")
_NAME: Final = re.compile(r"[^\W\d]\w*")
_NUMBERS: Final = (
    *("0", "1", "-1", "2", "0.5", "-0.1", "1e-9", "1e-320", "3.14159", "-6.3", "7"),
    *("100", "-100", "255", "256", "1000", "65536", "1e6", "-1e6", "1e300", "-1e300"),
    *("2147483647", "-2147483647", "2147483648.0", "99999999999999999999"),
)
_VALUES: Final = (
    *("True", "False", '""', '"a"', '"base"', '"é\\n"', "p[0, 0, 0, 0, 0, 0]", "[]"),
    *("p[1e3, 0, 0, 0, 3.2, 0]", "[0, 0, 0, 0, 0, 0]", "[1, 2, 3]", "[[1, 2], [3, 4]]"),
    *(
        "[6.2, -3.1, 3.1, -6.2, 6.2, -6.2]",
        "[-9, 9, -9, 9, -9, 9]",
        "make_list(200, 1)",
    ),
    *("q", "here", "pose", "x", "s", "text", "items", "m", "struct(a = 1)"),
    *("get_target_joint_speeds()", "get_actual_tcp_pose()", "random()", "(1 / 3)"),
    *("pose_trans(here, p[0, 0, -0.3, 0, 0, 0])", "pose_inv(here)", "1e300 * 1e300"),
)
_WORDS: Final = (
    *("def", "end", "if", "else", "while", "thread", "run", "join", "kill", "return"),
    *("break", "continue", "halt", "pause", "global", "local", "(", ")", "[", "]"),
    *(",", ":", "=", "==", "+", "-", "*", "/", "%", "not", "and", "or", "xor", "."),
    *("sec", "enter_critical", "exit_critical", "\n", '"', "#", "$", "p", "\\", "\0"),
)
_WRAPPERS: Final = (
    "while True:\n{}\nsync()\nend",
    "while True:\n{}\nend",
    "i = 0\nwhile i < 30:\n{}\ni = i + 1\nend",
    "if {0}:\n{1}\nend",
    "def own():\n{}\nend\nown()",
    "thread other():\n{}\nend\nrun other()",
    "thread other():\nwhile True:\n{}\nsync()\nend\nend\nx = run other()\nkill x",
    "enter_critical\n{}\nexit_critical",
)


def corpus() -> tuple[str, ...]:
    """Return whole programs: those of the tests, of the docs and of this fuzzing."""
    own = (DATA / "urscript_fuzz" / "programs.txt").read_text().split("---\n")
    tested = [p.read_text() for p in sorted((DATA / "urscript").glob("*.script"))]
    docs = (DATA.parents[1] / "docs/how-to/urscript.md").read_text()
    shown = re.findall(r"(?m)^def (?:.*\n)*?end$", docs)
    return (*own, *tested, *shown)


def mutated(rng: random.Random, programs: tuple[str, ...], port: int) -> str:
    """Return a program.

    Args:
        rng: What decides.
        programs: The corpus.
        port: Where ``PORT`` of the programs is served, as are other numbers of ports.
    """
    text = _composed(rng) if rng.random() < 0.6 else rng.choice(programs)
    for _ in range(rng.choice((0, 1, 1, 1, 2, 4))):
        text = rng.choice(_CHANGES)(text, rng)
    return re.sub(r"PORT|\b(?:50007|1502|8088)\b", str(port), text)


def _composed(rng: random.Random) -> str:
    """Return a program of statements, each with a number or a value changed or not."""
    lines = [_statement(rng) for _ in range(rng.randint(1, 8))]
    return f"{HEAD}{_indented(lines)}end\n"


def _statement(rng: random.Random) -> str:
    line = rng.choice(CALLS)
    for _ in range(rng.choice((0, 0, 0, 1, 1))):
        line = (_change_value if rng.random() < 0.95 else _change_token)(line, rng)
    if rng.random() < 0.1:
        line = rng.choice(_WRAPPERS).format(line, rng.choice(CALLS))
    return line


def _indented(lines: list[str]) -> str:
    return "".join(f"  {line}\n" for line in lines)


def _change_value(text: str, rng: random.Random) -> str:
    """Replace a number or a name by another value."""
    tokens = _TOKEN.findall(text)
    at = [
        k
        for k, token in enumerate(tokens)
        if _NUMBER.match(token)
        or (_NAME.match(token) and (*tokens[k + 1 :], "\n")[0][0] in ",)]\n")
    ]
    if not at:
        return text
    k = rng.choice(at)
    is_number = _NUMBER.match(tokens[k]) is not None
    few = _NUMBERS if is_number and rng.random() < 0.7 else _VALUES
    near = f"{rng.uniform(-4.0, 4.0):.3f}"
    tokens[k] = near if is_number and rng.random() < 0.4 else rng.choice(few)
    return "".join(tokens)


def _change_token(text: str, rng: random.Random) -> str:
    """Remove, repeat, exchange or insert a token."""
    tokens = _TOKEN.findall(text)
    if not tokens:
        return text
    k = rng.randrange(len(tokens))
    match rng.randrange(5):
        case 0:
            del tokens[k]
        case 1:
            tokens.insert(k, tokens[k])
        case 2:
            tokens[k] = rng.choice(_WORDS)
        case 3:
            other = rng.randrange(len(tokens))
            tokens[k], tokens[other] = tokens[other], tokens[k]
        case _:
            tokens.insert(k, f" {rng.choice((*_WORDS, *_VALUES, *_NUMBERS))} ")
    return "".join(tokens)


def _change_line(text: str, rng: random.Random) -> str:
    """Remove, repeat, move or insert a line."""
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    match rng.randrange(5):
        case 0:
            del lines[k]
        case 1:
            lines.insert(k, lines[k])
        case 2:
            lines.insert(rng.randrange(len(lines)), lines.pop(k))
        case _:
            lines.insert(k, _statement(rng))
    return "\n".join(lines)


def _wrap(text: str, rng: random.Random) -> str:
    """Put some lines into a block."""
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    end = min(len(lines), k + rng.randint(1, 3))
    inner = "\n".join(lines[k:end])
    lines[k:end] = [rng.choice(_WRAPPERS).format(inner, inner)]
    return "\n".join(lines)


def _change_byte(text: str, rng: random.Random) -> str:
    k = rng.randrange(len(text) + 1)
    return text[:k] + chr(rng.choice((0, 9, 10, 13, 34, 0x85, 0xE9, 0x2028))) + text[k:]


_CHANGES: Final = (
    *(_change_value,) * 12,
    *(_change_line,) * 6,
    *(_change_token,) * 2,
    *(_wrap,) * 2,
    _change_byte,
)
