"""The page of the panel's protocol names every field, and its examples are messages."""

import json
import re
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from tool0.panel import protocol
from tool0.protocol.codec import Hello, Reply, decode_request
from tool0.protocol.state_message import StateMessage

PAGE = Path(__file__).parents[3] / "docs/reference/panel-protocol.md"
TEXT = PAGE.read_text(encoding="utf-8")
MESSAGES = {
    str(struct.__struct_config__.tag): struct
    for struct in (*get_args(protocol.ViewMessage), Hello, Reply)
}
STRUCTS = [
    item
    for item in vars(protocol).values()
    if isinstance(item, type)
    and issubclass(item, msgspec.Struct)
    and item not in (msgspec.Struct, StateMessage)
]
"""``requests.md`` has the fields of a state; the view has some of them."""


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


def test_every_value_of_a_choice_is_named() -> None:
    words = [*get_args(protocol.NoticeCode), *get_args(protocol.Severity)]
    assert [word for word in words if f"`{word}`" not in TEXT] == []


def test_every_example_is_a_message() -> None:
    for example in examples():
        if "type" in example:
            msgspec.convert(example, MESSAGES[example["type"]])
        else:
            decode_request(json.dumps(example))


def test_every_message_has_an_example() -> None:
    assert {example.get("type") for example in examples()} >= set(MESSAGES)
