"""Addresses for robots of tests: each listens at the real ports of a UR."""

from __future__ import annotations

import random


def free_host() -> str:
    """Return an address in 127.0.0.0/8 that no other test uses.

    Chance chooses it: there are millions of addresses, and a few tests.
    """
    chance = random.SystemRandom()
    second, third = chance.randint(1, 254), chance.randint(0, 255)
    return f"127.{second}.{third}.{chance.randint(1, 200)}"
