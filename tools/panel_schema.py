"""Write ``web/protocol.schema.json``, the protocol of connections for TypeScript."""

from __future__ import annotations

import inspect
import json
from pathlib import Path
from typing import Any, get_args

import msgspec

from tool0.panel.protocol import ViewMessage
from tool0.protocol.codec import EventMessage, Hello, Reply, wire_type
from tool0.protocol.methods import contract
from tool0.protocol.request import response_type

SCHEMA = Path(__file__).parent.parent / "web" / "protocol.schema.json"


def schema_text() -> str:
    """Return the schema of ``Requests``, ``Responses`` and ``ServerMessage``.

    ``Requests`` and ``Responses`` are objects whose keys are the methods.
    """
    rows = dict(sorted(contract().items()))
    responses = [wire_type(response_type(request)) for request in rows.values()]
    messages = [Hello, Reply, *get_args(ViewMessage), *get_args(EventMessage)]
    refs, components = msgspec.json.schema_components(
        [*rows.values(), *responses, *messages],
        ref_template="#/$defs/{name}",
        # for types that are not plain data
        schema_hook=lambda kind: {"title": kind.__name__},
    )
    count = len(rows)
    for title, found in (
        ("Requests", refs[:count]),
        ("Responses", refs[count : 2 * count]),
    ):
        components[title] = {
            "title": title,
            "type": "object",
            "properties": dict(zip(rows, found, strict=True)),
            "required": list(rows),
        }
    components["ServerMessage"] = {
        "title": "ServerMessage",
        "anyOf": refs[2 * count :],
    }
    definitions = ",\n".join(
        f"    {json.dumps(name)}: "
        + json.dumps(_without_indents(components[name]), ensure_ascii=False)
        for name in sorted(components)
    )
    return (
        "{\n"
        '  "$schema": "https://json-schema.org/draft/2020-12/schema",\n'
        '  "title": "Protocol",\n'
        '  "anyOf": [\n'
        '    { "$ref": "#/$defs/Requests" },\n'
        '    { "$ref": "#/$defs/Responses" },\n'
        '    { "$ref": "#/$defs/ServerMessage" }\n'
        "  ],\n"
        f'  "$defs": {{\n{definitions}\n  }}\n'
        "}\n"
    )


def _without_indents(part: Any) -> Any:  # Any: JSON value
    """Return JSON in which docstrings have no indentation."""
    if isinstance(part, dict):
        return {
            key: inspect.cleandoc(item)
            if key == "description" and isinstance(item, str)
            else _without_indents(item)
            for key, item in part.items()
        }
    if isinstance(part, list):
        return [_without_indents(item) for item in part]
    return part


if __name__ == "__main__":
    SCHEMA.write_text(schema_text(), encoding="utf-8")
