"""The build's hook: packages carry the panel's page, wheels the compiled kernel."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
import sysconfig
from pathlib import Path
from types import ModuleType
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).resolve().parent / "tools"))

import web

_ROOT = Path(__file__).resolve().parent
SKIP_PAGE = "TOOL0_SKIP_PANEL"
"""Set to 1, no page is made: the package has the one that is there, or none."""
LICENCES_OF_PAGE = "src/tool0/panel/static/licenses.md"
"""Texts of the licences of the packages that the page bundles; made with the page."""
SKIP_KERNEL = "TOOL0_SKIP_KERNEL"
"""Set to 1, no kernel is compiled: the control tick runs in Python, more slowly."""


class PackageHook(BuildHookInterface):  # type: ignore[type-arg]  # any build's config
    """Makes what is not in git before the files are collected."""

    def dependencies(self) -> list[str]:
        """Return what the build needs and the machine lacks."""
        return [*_needed_by_page(), *_needed_by_kernel(self.target_name)]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make the page and the kernel."""
        _make_page()
        self._add_licences_of_page()
        if self.target_name == "wheel":
            _compile_kernel(build_data, is_editable=version == "editable")

    def _add_licences_of_page(self) -> None:
        """Name them in the metadata, which was read before the page was made."""
        files = self.metadata.core.license_files
        if (_ROOT / LICENCES_OF_PAGE).is_file() and LICENCES_OF_PAGE not in files:
            files.append(LICENCES_OF_PAGE)


# --- the panel's page: in wheels, editable installs and sdists ---


def _needed_by_page() -> list[str]:
    """Return Node, unless it is there or has nothing to do.

    An sdist carries the page that was made with it.
    """
    if _is_set(SKIP_PAGE) or web.is_fresh() or web.has_node():
        return []
    return [web.NODE_WHEEL]


def _make_page() -> None:
    """Make the page if it is stale."""
    if _is_set(SKIP_PAGE):
        return
    try:
        web.build()
    except web.WebError as error:
        raise SystemExit(
            f"tool0: {error}\ntool0: or set {SKIP_PAGE}=1 to do without a new page"
        ) from None


# --- the control kernel: in wheels and editable installs; an sdist has its sources ---


def _needed_by_kernel(target: str) -> list[str]:
    """Return a C compiler, unless one works here or the user names one."""
    if target != "wheel" or _is_set(SKIP_KERNEL) or os.name != "posix":
        return []
    if os.environ.get("CC"):
        return []
    kernel = _kernel_build()
    try:
        kernel.find_compiler()
    except kernel.KernelBuildError:
        return [kernel.ZIG]
    return []


def _compile_kernel(build_data: dict[str, Any], *, is_editable: bool) -> None:
    """Compile; where that fails, the package runs its control in Python."""
    if _is_set(SKIP_KERNEL):
        return
    kernel = _kernel_build()
    try:
        library = kernel.build()
    except kernel.KernelBuildError as error:
        print(
            f"tool0: cannot compile the kernel: {error}\n"
            "tool0: everything works without it, more slowly; see `tool0 doctor`",
            file=sys.stderr,
        )
        return
    if is_editable:  # it is beside its sources
        return
    build_data["artifacts"].append(f"/{library.relative_to(_ROOT).as_posix()}")
    build_data["pure_python"] = False
    build_data["tag"] = f"py3-none-{platform_tag(library)}"


def platform_tag(library: Path) -> str:
    """Return the platform of a wheel with this library.

    On Linux it names the oldest glibc that has all symbols which the library needs
    (PEP 600: ``manylinux_2_34_x86_64``); the kernel needs nothing but libc and libm.
    """
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    needed = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    if not platform.startswith("linux_") or not needed:
        return platform
    major, minor = max((int(major), int(minor)) for major, minor in needed)
    return f"many{platform.replace('linux_', f'linux_{major}_{minor}_', 1)}"


def _kernel_build() -> ModuleType:
    """Return ``tool0.kernel.build``, which works before tool0 is installed."""
    path = _ROOT / "src/tool0/kernel/build.py"
    spec = importlib.util.spec_from_file_location("tool0_kernel_build", path)
    if spec is None or spec.loader is None:
        raise SystemExit(f"tool0: cannot load '{path}'")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _is_set(variable: str) -> bool:
    return os.environ.get(variable, "") not in ("", "0")
