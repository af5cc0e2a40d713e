"""Programs as Python scripts that call ``run_program``, with loops in Python."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from msgspec import NODEFAULT, Struct
from msgspec.structs import fields

from tool0.protocol.program import CommentStep, LoopStep, Program, Step

_WIDTH = 88
_HEAD = '''\
"""{title}: exported by tool0.

Run it beside `tool0 bringup`; the name of the bring-up may follow.
"""

import sys

import tool0

NAME = {name!r}
{settings}

def run(robot: tool0.Robot, *steps) -> None:
    """Execute steps, and end the script if one of them fails."""
    program = tool0.Program(name=NAME, steps=steps{arguments})
    end = robot.run_program(program).wait()
    if end.state != "succeeded":
        sys.exit(f"{{NAME}} {{end.state}}: {{end.error}}")


def main() -> None:
    with tool0.connect(*sys.argv[1:]) as robot:
'''
_TAIL = """


if __name__ == "__main__":
    main()
"""


def python_text(program: Program) -> str:
    """Return a script that executes a program through the Python API.

    Consecutive moves are in the same call, so that they are blended.
    """
    settings = {
        item.name: getattr(program, item.name)
        for item in fields(Program)
        if item.name not in {"format", "name", "steps"}
    }
    given = {
        name: value
        for name, value in settings.items()
        if not _is_default(program, name)
    }
    body = _body(program, program.steps, 8) or [" " * 8 + "pass"]
    head = _HEAD.format(
        title=_one_line(program.name).replace('"', "'"),
        name=program.name,
        settings="".join(f"{k.upper()} = {_code(v, 0)}\n" for k, v in given.items()),
        arguments="".join(f", {name}={name.upper()}" for name in given),
    )
    return head + "\n".join(body) + _TAIL


def _body(program: Program, steps: Sequence[Step], indent: int) -> list[str]:
    """Return the lines of Python code for a sequence of steps."""
    space = " " * indent
    lines: list[str] = []
    batch: list[str] = []

    def flush() -> None:
        if any(not line.lstrip().startswith("#") for line in batch):
            lines.extend([f"{space}run(", f"{space}    robot,", *batch, f"{space})"])
        else:
            lines.extend(line[4:] for line in batch)
        batch.clear()

    for step in steps:
        if isinstance(step, CommentStep):
            batch.append(f"{space}    # {_one_line(step.text)}")
        elif isinstance(step, LoopStep):
            flush()
            lines.append(f"{space}{_loop(program, step)}:")
            lines += _body(program, step.steps, indent + 4)
        else:
            batch.append(f"{space}    {_code(step, indent + 4)},")
    flush()
    return lines


def _loop(program: Program, loop: LoopStep) -> str:
    if loop.times is not None:
        return f"for _ in range({loop.times})"
    if loop.while_input is None:
        return "while True"
    arm = "robot.arm" if program.arm is None else f"robot.arms[{program.arm!r}]"
    level = "" if loop.level else "not "
    return f"while {level}{arm}.control_box.state.digital_inputs[{loop.while_input}]"


def _code(value: Any, indent: int) -> str:
    """Return a value as Python code; a long value is split into several lines."""
    if isinstance(value, Struct):
        parts = [
            f"{item.name}={_code(getattr(value, item.name), indent + 4)}"
            for item in fields(value)
            if not _is_default(value, item.name)
        ]
        return _joined(f"tool0.{type(value).__name__}(", parts, ")", indent)
    if isinstance(value, dict):
        parts = [f"{key!r}: {_code(item, indent + 4)}" for key, item in value.items()]
        return _joined("{", parts, "}", indent)
    return repr(value)


def _joined(opening: str, parts: Sequence[str], closing: str, indent: int) -> str:
    short = f"{opening}{', '.join(parts)}{closing}"
    if "\n" not in short and indent + len(short) < _WIDTH - 10:
        return short
    space = " " * (indent + 4)
    lines = "".join(f"{space}{part},\n" for part in parts)
    return f"{opening}\n{lines}{' ' * indent}{closing}"


def _is_default(value: Struct, name: str) -> bool:
    item = next(item for item in fields(value) if item.name == name)
    default = item.default
    if item.default_factory is not NODEFAULT:
        default = item.default_factory()
    return bool(getattr(value, name) == default)


def _one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("\\", "/").strip()
