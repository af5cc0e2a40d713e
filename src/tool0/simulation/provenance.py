"""The software versions and the computer that affect simulation results."""

from __future__ import annotations

import platform
from importlib.metadata import version

from tool0.engines.registry import batch_engine, engine_definition
from tool0.kernel.build import source_digest
from tool0.kernel.library import kernel_status


def current_versions(engine: str) -> dict[str, str]:
    """Return the versions of tool0, Python and the engine's package."""
    found = {"tool0": version("tool0"), "python": platform.python_version()}
    return found | engine_definition(engine).versions()


def batch_versions() -> dict[str, str]:
    """Return the versions of tool0, the batch engine's package and numpy."""
    engine = engine_definition(batch_engine())
    found = {"tool0": version("tool0")} | engine.versions()
    return found | {"numpy": version("numpy")}


def kernel_digest() -> str:
    """Return a digest of the kernel's sources and compiler flags."""
    return source_digest()[:16]


def current_platform() -> str:
    """Return the operating system and the processor of the computer."""
    return f"{platform.system()} {platform.machine()}"


def is_kernel_compiled() -> bool:
    """Return whether compiled code executes the ticks.

    Simulation results do not depend on compiled code.
    """
    return kernel_status().library is not None


def is_deterministic(engine: str) -> bool:
    """Return whether identical input produces bit-identical results on an engine."""
    return engine_definition(engine).is_deterministic
