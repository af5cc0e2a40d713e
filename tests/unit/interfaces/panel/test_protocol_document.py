"""``docs/panel-protocol.md`` names everything, and its examples are messages."""

import json
import re
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from tool0.interfaces.panel import protocol

TEXT = (Path(__file__).parents[4] / "docs" / "panel-protocol.md").read_text("utf-8")
MESSAGES = (*get_args(protocol.ClientMessage), *get_args(protocol.ServerMessage))
STRUCTS = [
    item
    for item in vars(protocol).values()
    if isinstance(item, type)
    and issubclass(item, msgspec.Struct)
    and item is not msgspec.Struct
]


def examples() -> list[dict[str, Any]]:
    """Return every JSON object of the document; some blocks hold several."""
    found = []
    for block in re.findall(r"```json\n(.*?)```", TEXT, re.DOTALL):
        rest = block.strip()
        while rest:
            item, end = json.JSONDecoder().raw_decode(rest)
            found.append(item)
            rest = rest[end:].strip()
    return found


@pytest.mark.parametrize("struct", STRUCTS, ids=lambda struct: struct.__name__)
def test_every_field_is_named(struct: type[msgspec.Struct]) -> None:
    for field in struct.__struct_fields__:
        assert f"`{field}`" in TEXT, f"{struct.__name__}.{field}"


@pytest.mark.parametrize("struct", MESSAGES, ids=lambda struct: struct.__name__)
def test_every_message_is_named(struct: type[msgspec.Struct]) -> None:
    assert f"`{struct.__struct_config__.tag}`" in TEXT


def test_every_word_that_a_field_can_be_is_named() -> None:
    words = [
        *get_args(protocol.NoticeCode),
        *get_args(protocol.Severity),
        *get_args(protocol.Mode),
    ]
    assert [word for word in words if f"`{word}`" not in TEXT] == []


@pytest.mark.parametrize("example", examples(), ids=lambda item: item["type"])
def test_every_example_is_a_message(example: dict[str, Any]) -> None:
    kinds = {struct.__struct_config__.tag: struct for struct in MESSAGES}
    msgspec.convert(example, kinds[example["type"]])


def test_every_message_of_the_server_has_an_example() -> None:
    shown = {example["type"] for example in examples()}
    server = {
        struct.__struct_config__.tag for struct in get_args(protocol.ServerMessage)
    }
    assert server <= shown
