"""From words to options without tyro, where the words leave no doubt.

Importing tyro and reading its types takes 0.1 s of a start-up of 0.3 s.  What is not
plainly right goes to tyro, which then also writes the help and the mistakes: so there
is one grammar, and this reads a part of it faster (a test compares the two).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Final

from tool0.cli.options import (
    BringupOptions,
    ControllerOptions,
    PanelOptions,
    RobotOptions,
    RosOptions,
    SimulationOptions,
)
from tool0.cli.parsing import gathered

_SCALAR: Final[dict[str, Callable[[str], object]]] = {
    "str": str,
    "str | None": str,
    "float | None": float,
    "int | None": int,
    "Path | None": Path,
}
_SEVERAL: Final[dict[str, Callable[[str], object]]] = {
    "tuple[str, ...]": str,
    "tuple[Path, ...]": Path,
}


def read_bringup(arguments: Sequence[str]) -> BringupOptions | None:
    """Return the options, or None if tyro should have a look."""
    groups = (
        RobotOptions,
        ControllerOptions,
        SimulationOptions,
        PanelOptions,
        RosOptions,
    )
    form = {f"--{_dashed(f.name)}": (g, f) for g in groups for f in fields(g)}
    values: dict[type, dict[str, object]] = {group: {} for group in groups}
    words = gathered(arguments)
    while words:
        option = words.pop(0)
        negated = option.startswith("--no-")
        group, item = form.get(option.replace("--no-", "--", 1), (None, None))
        if group is None or item is None or item.name in values[group]:
            return None
        texts: list[str] = []
        while words and not words[0].startswith("-"):
            texts.append(words.pop(0))
        # Annotations are strings here: `from __future__ import annotations`.
        value = _value(str(item.type), texts, negated=negated)
        if value is None:
            return None
        values[group][item.name] = value
    return BringupOptions(
        description=RobotOptions(**values[RobotOptions]),  # type: ignore[arg-type]
        control=ControllerOptions(**values[ControllerOptions]),  # type: ignore[arg-type]
        simulation=SimulationOptions(**values[SimulationOptions]),  # type: ignore[arg-type]
        panel=PanelOptions(**values[PanelOptions]),  # type: ignore[arg-type]
        ros=RosOptions(**values[RosOptions]),  # type: ignore[arg-type]
    )


def _value(kind: str, texts: list[str], *, negated: bool) -> object:
    """Return the value of one option, or None in any doubt."""
    if kind == "bool":
        return not negated if not texts else None
    if negated or not texts or "None" in texts:  # tyro reads None as no value
        return None
    try:
        if kind in _SEVERAL:
            return tuple(_SEVERAL[kind](text) for text in texts)
        if len(texts) == 1 and kind in _SCALAR:
            return _SCALAR[kind](texts[0])
    except ValueError:
        return None
    if kind.startswith("Literal[") and len(texts) == 1:
        choices = [word.strip("'\"") for word in kind[8:-1].split(", ")]
        return texts[0] if texts[0] in choices else None
    return None


def _dashed(name: str) -> str:
    return name.replace("_", "-")
