"""A probe of ``tool0 doctor``: whether the control kernel is compiled."""

from __future__ import annotations

import os

from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import Machine
from tool0.kernel import build, library


def kernel(examined: Machine) -> list[ProbeResult]:
    """Return the compiled kernel, or why Python runs instead and what compiles it."""
    if examined.system == "win32":
        found = "by tool0 on Windows: control runs in Python, more slowly"
        return [ProbeResult("kernel", "not supported", found)]
    status = library.kernel_status()
    if status.library is not None:
        return [ProbeResult("kernel", "ready", f"compiled, {status.path}")]
    found = f"Python only, which is slower: {status.reason}"
    if examined.environ.get(library.VARIABLE):
        remedy = f"unset {library.VARIABLE}"
        return [ProbeResult("kernel", "missing", found, remedy)]
    remedy = library.COMPILE_COMMAND
    try:
        build.find_compiler()
    except build.KernelBuildError as error:
        if examined.environ.get("CC"):
            found, remedy = f"{found}; {error}", "unset CC"
        else:
            found, remedy = f"{found}; no C compiler", f"{remedy} --install-compiler"
    if not os.access(status.path.parent, os.W_OK):
        found += f"; '{status.path.parent}' is read-only for this account"
    return [ProbeResult("kernel", "missing", found, remedy)]
