"""Any options of a bring-up as keywords, for tests that pass them on."""

from dataclasses import fields
from typing import Any

import tool0


def configured(**options: Any) -> dict[str, Any]:
    """Return keywords of ``tool0.bringup`` for fields of its configuration values."""
    keywords = {}
    for name, kind in (
        ("description", tool0.DescriptionConfig),
        ("control", tool0.ControlConfig),
        ("simulation", tool0.SimulationConfig),
    ):
        own = {item.name for item in fields(kind)} & options.keys()
        keywords[name] = kind(**{option: options.pop(option) for option in own})
    assert not options, options
    return keywords
