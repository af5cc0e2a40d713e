"""Write ``web/protocol.schema.json``: the panel's protocol, for TypeScript."""

from __future__ import annotations

import inspect
import json
from pathlib import Path
from typing import Any, get_args

import msgspec

from tool0.interfaces.panel import protocol

SCHEMA = Path(__file__).parent.parent / "web" / "protocol.schema.json"


def schema_text() -> str:
    """Return the schema of every message, with a union of what each side may send."""
    unions = {
        "ClientMessage": get_args(protocol.ClientMessage),
        "ServerMessage": get_args(protocol.ServerMessage),
    }
    messages = [message for union in unions.values() for message in union]
    _, components = msgspec.json.schema_components(
        messages, ref_template="#/$defs/{name}"
    )
    for name, union in unions.items():
        components[name] = {
            "title": name,
            "anyOf": [{"$ref": f"#/$defs/{message.__name__}"} for message in union],
        }
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Message",
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in unions],
        "$defs": _without_indents(components),
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def _without_indents(part: Any) -> Any:  # Any: JSON
    """Return JSON with docstrings as they read, not as they are indented."""
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
