"""OpenGL contexts for rendering without a screen.

MuJoCo's own modules create the contexts.  They are imported separately here because
``mujoco`` itself reads ``MUJOCO_GL`` only at its first import; on Linux, it needs a
screen if that is not set.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import sys
from typing import Any, Final

from tool0.errors import EngineUnavailableError, RenderError

PACKAGES: Final = "libegl1 libopengl0 libgl1-mesa-dri"
"""Debian and Ubuntu packages; libosmesa6 is the alternative without EGL."""

_MODULES: Final = {
    "egl": "mujoco.egl",
    "osmesa": "mujoco.osmesa",
    "glfw": "mujoco.glfw",
    "glx": "mujoco.glfw",
    "glew": "mujoco.glfw",
    "cgl": "mujoco.cgl",
}
"""Value of MUJOCO_GL → module that creates the context."""


def import_mujoco() -> None:
    """Import ``mujoco``, which loads the OpenGL library that MUJOCO_GL names.

    Raises:
        EngineUnavailableError: If the import fails with MUJOCO_GL set.
        ImportError: If the import fails without MUJOCO_GL.
    """
    try:
        importlib.import_module("mujoco")
    except Exception as error:  # the exception depends on the OpenGL
        wanted = os.environ.get("MUJOCO_GL")
        if not wanted:
            raise
        raise EngineUnavailableError(
            f"MuJoCo cannot be imported: {error or type(error).__name__}; unset "
            f"MUJOCO_GL, which is '{wanted}'"
        ) from error


def make_context(width: int, height: int) -> Any:  # none of MuJoCo's is typed
    """Return a GL context for images up to this size [pixels]; it is not yet current.

    Raises:
        RenderError: If there is no OpenGL; the message names the packages to install.
    """
    kind = kind_of_context()
    try:
        return importlib.import_module(_MODULES[kind]).GLContext(width, height)
    except Exception as error:  # the exception depends on the library
        raise RenderError(
            f"cannot render images: OpenGL by {kind} does not work here "
            f"({error or type(error).__name__}); on Debian and Ubuntu "
            f"run `apt-get install {PACKAGES}`"
        ) from error


def kind_of_context() -> str:
    """Return MUJOCO_GL or, if it is not set, the best value; or raise RenderError."""
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
    # PyOpenGL keeps the library that it tries first, so only one can be tried.
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
    """Return whether EGL finds a device, as the library alone is not enough."""
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
