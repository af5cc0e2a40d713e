"""The build's hook: wheels, sdists and editable installs carry the panel's page."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).resolve().parent / "tools"))

import web

SKIP = "TOOL0_SKIP_PANEL"
"""Set to 1, no page is made: the package has the one that is there, or none."""


class PageHook(BuildHookInterface):  # type: ignore[type-arg]  # any build's config
    """Makes the page before the files are collected."""

    def dependencies(self) -> list[str]:
        """Return what the build needs: Node, unless it is there or has nothing to do.

        An sdist carries the page that was made with it.
        """
        if _is_skipped() or web.is_fresh() or web.has_node():
            return []
        return [web.NODE_WHEEL]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make the page if it is stale."""
        del version, build_data
        if _is_skipped():
            return
        try:
            web.build()
        except web.WebError as error:
            raise SystemExit(
                f"tool0: {error}\ntool0: or set {SKIP}=1 to do without a new page"
            ) from None


def _is_skipped() -> bool:
    return os.environ.get(SKIP, "") not in ("", "0")
