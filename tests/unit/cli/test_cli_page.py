"""docs/reference/cli.md is what tools/cli_docs.py makes of the commands."""

import shlex

import pytest
from document import blocks
from tools.cli_docs import DOCUMENT, document

from tool0.cli import COMMANDS, form_and_readers
from tool0.cli.completion import table
from tool0.cli.options import READERS, BringupOptions
from tool0.cli.parameters import parameters_of
from tool0.cli.parsing import parse

MOST = 500_000  # [bytes]


def test_the_page_is_generated_from_the_commands_as_they_are() -> None:
    text = document()
    assert DOCUMENT.read_text(encoding="utf-8") == text, (
        "run: .venv/bin/python tools/cli_docs.py"
    )
    assert len(text.encode()) < MOST


def test_every_command_and_each_of_its_options_is_on_the_page() -> None:
    text = document()
    for words, following in table().items():
        command, is_options, rest = words.partition(" -")
        if is_options and not rest:
            assert f" tool0 {command}\n" in text, command
            for flag in following:
                assert flag == "--help" or f"`{flag}" in text, (command, flag)


@pytest.mark.parametrize(
    "line",
    [line for b in blocks(DOCUMENT) if b.language == "sh" for line in b.commands()],
)
def test_every_example_is_understood(line: str) -> None:
    program, command, *rest = shlex.split(line, comments=True)
    assert program == "tool0"
    if command == "bringup":
        parse(BringupOptions, command, rest, READERS)
        return
    form, readers = form_and_readers(command)
    assert command in COMMANDS
    assert callable(form)
    flags = {item.flag for item in parameters_of(form, readers)}
    assert {word for word in rest if word.startswith("--")} <= flags
