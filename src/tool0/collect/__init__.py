"""Collect episodes of a task in a folder, with many processes or machines.

::

    from tool0.collect import collect

    manifest = collect("Lift", 1000, "lift", workers=4)
    print(manifest.n_succeeded, "of", manifest.n_episodes)
"""

from __future__ import annotations

from tool0.collect.collecting import Progress, collect
from tool0.collect.dataset import Manifest

__all__ = ["Manifest", "Progress", "collect"]
