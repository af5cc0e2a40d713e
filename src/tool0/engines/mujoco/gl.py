"""OpenGL contexts for rendering without a display.

The contexts are created by modules of MuJoCo.  These modules are imported directly,
because the package ``mujoco`` reads ``MUJOCO_GL`` only when it is first imported.  On
Linux, ``mujoco`` needs a display if ``MUJOCO_GL`` is not set.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import sys
from typing import Any, Final

from tool0.errors import EngineUnavailableError, RenderError

PACKAGES: Final = "libegl1 libopengl0 libgl1-mesa-dri"
"""Debian and Ubuntu packages for rendering with EGL.  The alternative without EGL is
libosmesa6."""

_MODULES: Final = {
    "egl": "mujoco.egl",
    "osmesa": "mujoco.osmesa",
    "glfw": "mujoco.glfw",
    "glx": "mujoco.glfw",
    "glew": "mujoco.glfw",
    "cgl": "mujoco.cgl",
}
"""Map from a value of MUJOCO_GL to the module that creates the context."""


def import_mujoco() -> None:
    """Import ``mujoco``, which loads the OpenGL library selected by MUJOCO_GL.

    Raises:
        EngineUnavailableError: If the import fails and MUJOCO_GL is set.
        ImportError: If the import fails and MUJOCO_GL is not set.
    """
    try:
        importlib.import_module("mujoco")
    # The type of the exception depends on the OpenGL library.
    except Exception as error:
        wanted = os.environ.get("MUJOCO_GL")
        if not wanted:
            raise
        raise EngineUnavailableError(
            f"MuJoCo cannot be imported: {error or type(error).__name__}; unset "
            f"MUJOCO_GL, which is '{wanted}'"
        ) from error


def make_context(width: int, height: int) -> Any:  # without type annotations
    """Return a GL context for images up to this size [pixels]; it is not made current.

    Raises:
        RenderError: If there is no OpenGL library.  The message lists the packages to
            install.
    """
    kind = kind_of_context()
    try:
        return importlib.import_module(_MODULES[kind]).GLContext(width, height)
    except Exception as error:  # the type of the exception depends on the library
        raise RenderError(
            f"cannot render images: OpenGL by {kind} does not work here "
            f"({error or type(error).__name__}); on Debian and Ubuntu "
            f"run `apt-get install {PACKAGES}`"
        ) from error


def kind_of_context() -> str:
    """Return the value of MUJOCO_GL, or the best value if MUJOCO_GL is not set.

    Raises:
        RenderError: If MUJOCO_GL has an unknown value, or no OpenGL library is usable.
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower().strip()
    if wanted in _MODULES:
        return wanted
    if wanted not in ("", "on", "enable", "enabled", "true", "1"):
        raise RenderError(
            f"cannot render images: MUJOCO_GL is '{wanted}'; unset it, or set it "
            "to egl or osmesa"
        )
    if sys.platform != "linux":
        return "cgl" if sys.platform == "darwin" else "glfw"
    # PyOpenGL keeps the first library that it tries, and therefore only one library can
    # be tried.
    platform = os.environ.get("PYOPENGL_PLATFORM", "")
    if platform in ("", "egl") and _egl_has_device():
        return "egl"
    if platform in ("", "osmesa") and _has("libOSMesa.so.8", "libOSMesa.so.6"):
        return "osmesa"
    raise RenderError(
        "cannot render images: there is neither EGL with a device, such as Mesa "
        "in software, nor OSMesa; on Debian and Ubuntu "
        f"run `apt-get install {PACKAGES}`, or install libosmesa6"
    )


def _has(*libraries: str) -> bool:
    for name in libraries:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def _egl_has_device() -> bool:
    """Return whether EGL finds a device, since the library alone is not sufficient."""
    try:
        egl = ctypes.CDLL("libEGL.so.1")
        egl.eglGetProcAddress.restype = ctypes.c_void_p
        address = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    except (OSError, AttributeError):
        return False
    if not address:
        return False
    query = ctypes.CFUNCTYPE(
        ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(ctypes.c_int)
    )(address)
    count = ctypes.c_int(0)
    return bool(query(0, None, ctypes.byref(count))) and count.value > 0
