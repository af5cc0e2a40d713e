"""Probes of the machine itself, its Python and its GPUs."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from pathlib import Path
from typing import Final

from tool0.installation.doctor.machine import (
    ExaminedMachine,
    pip_install_command,
    python_package_version,
    python_requirements,
    required_package,
)
from tool0.installation.doctor.report import ProbeResult

_NO_PERMISSION: Final = "; this account may not use it: after the command, log in again"
_VENDORS: Final = {"0x10de": "NVIDIA", "0x1002": "AMD", "0x8086": "Intel"}


def machine(examined: ExaminedMachine) -> list[ProbeResult]:
    """Return the operating system, processor and memory."""
    n_cores = os.cpu_count() or 1
    parts = [
        examined.name(),
        platform.machine(),
        f"{n_cores} core{'s' if n_cores > 1 else ''}",
    ]
    memory = re.search(r"^MemTotal:\s+(\d+) kB", examined.read("proc/meminfo"), re.M)
    if memory:
        parts.append(f"{int(memory[1]) * 1024 / 1e9:.0f} GB of memory")
    return [ProbeResult(what="machine", state="ready", found=", ".join(parts))]


def python(examined: ExaminedMachine) -> list[ProbeResult]:
    """Return which Python runs this, and whether it has what tool0 needs."""
    del examined
    found = f"{platform.python_version()}, {sys.prefix}"
    names = {text: required_package(text) for text in python_requirements()}
    missing = [t for t, name in names.items() if python_package_version(name) is None]
    if missing:
        return [
            ProbeResult(
                what="python",
                state="missing",
                found=f"{found}: without {', '.join(names[t] for t in missing)}",
                remedy=pip_install_command(*missing),
            )
        ]
    found += f", tool0 {python_package_version('tool0') or 'of unknown version'}"
    return [ProbeResult(what="python", state="ready", found=found)]


def gpu(examined: ExaminedMachine) -> list[ProbeResult]:
    """Return which GPUs there are; nothing of tool0 needs one."""
    if examined.system == "darwin":
        return [ProbeResult(what="gpu", state="ready", found="the Mac's own")]
    try:
        cards = [*_nvidia_cards(examined), *_render_nodes(examined)]
    except subprocess.TimeoutExpired as error:
        found = f"{error.cmd[0]} does not answer: NVIDIA's driver hangs"
        return [ProbeResult(what="gpu", state="unknown", found=found)]
    if not cards:
        found = "none, and none is needed: physics runs on the CPU, browsers draw on it"
        return [ProbeResult(what="gpu", state="missing", found=found)]
    found, remedy = ", ".join(cards), ""
    if not all(os.access(node, os.R_OK) for node in _render_nodes(examined).values()):
        found, remedy = found + _NO_PERMISSION, 'sudo usermod -aG render "$USER"'
    return [ProbeResult(what="gpu", state="ready", found=found, remedy=remedy)]


def _nvidia_cards(examined: ExaminedMachine) -> list[str]:
    """Read the driver's files; run nvidia-smi, which may hang, only without them."""
    files = sorted((examined.root / "proc/driver/nvidia/gpus").glob("*/information"))
    models = (re.search(r"^Model:\s*(.+)$", file.read_text(), re.M) for file in files)
    cards = [model[1].strip() for model in models if model]
    if cards:
        text = examined.read("proc/driver/nvidia/version")
        version = re.search(r"Kernel Module\D+([\d.]+)", text)
        return [*cards, f"driver {version[1]}"] if version else cards
    program = examined.program("nvidia-smi")
    if program is None:
        return []
    query = [program, "--query-gpu=name,driver_version", "--format=csv,noheader"]
    try:
        rows = examined.output_of(query).splitlines()
    except (OSError, subprocess.CalledProcessError):
        return []  # it is installed, and no driver is
    return [row.replace(", ", ", driver ") for row in rows if row]


def _render_nodes(examined: ExaminedMachine) -> dict[str, Path]:
    """Return the nodes that programs draw by, each under a description."""
    nodes = {}
    for node in sorted((examined.root / "dev/dri").glob("renderD*")):
        vendor = examined.read(f"sys/class/drm/{node.name}/device/vendor").strip()
        nodes[f"{_VENDORS.get(vendor, 'a GPU')} ({node})"] = node
    return nodes
