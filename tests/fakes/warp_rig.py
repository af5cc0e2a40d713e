"""MuJoCo Warp in tests: where it is installed, and on which device."""

from __future__ import annotations

import importlib.util
import os

import pytest

DEVICE = "TOOL0_TEST_DEVICE"
"""Names the device of the tests that simulate on it: ``cuda``, or ``warp:cpu``."""


def has_warp() -> bool:
    return importlib.util.find_spec("mujoco_warp") is not None


needs_warp = pytest.mark.skipif(
    not has_warp(), reason="MuJoCo Warp is not installed: pip install 'tool0[gpu]'"
)


def device_under_test() -> str:
    """Return the device to simulate on, or skip visibly: compiling takes minutes."""
    if not has_warp():
        pytest.skip("MuJoCo Warp is not installed: pip install 'tool0[gpu]'")
    if not (device := os.environ.get(DEVICE)):
        pytest.skip(f"set {DEVICE}=cuda, or warp:cpu; it compiles for minutes at first")
    return device
