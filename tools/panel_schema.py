"""Write ``web/protocol.schema.json``: the protocol of connections, for TypeScript."""

from __future__ import annotations

import inspect
import json
from pathlib import Path
from typing import Any, get_args

import msgspec

from tool0.interfaces.panel.protocol import ViewMessage
from tool0.requests.codec import Reply
from tool0.requests.messages import EventMessage, Hello
from tool0.requests.table import entries

SCHEMA = Path(__file__).parent.parent / "web" / "protocol.schema.json"


def schema_text() -> str:
    """Return the schema of ``Requests``, method → params, and of ``ServerMessage``."""
    requests = {
        name: entry.request
        for name, entry in sorted(entries().items())
        if entry.request.__module__.startswith("tool0.")
        if not entry.is_local
    }
    messages = [Hello, Reply, *get_args(ViewMessage), *get_args(EventMessage)]
    refs, components = msgspec.json.schema_components(
        [*requests.values(), *messages], ref_template="#/$defs/{name}"
    )
    components["Requests"] = {
        "title": "Requests",
        "type": "object",
        "properties": dict(zip(requests, refs, strict=False)),
        "required": list(requests),
    }
    components["ServerMessage"] = {
        "title": "ServerMessage",
        "anyOf": refs[len(requests) :],
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
        '    { "$ref": "#/$defs/ServerMessage" }\n'
        "  ],\n"
        f'  "$defs": {{\n{definitions}\n  }}\n'
        "}\n"
    )


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
