"""A gamepad of SDL's own: the same library that reads it, without hardware.

It is a virtual joystick of the SDL that pygame loads: what reads gamepads there finds,
opens and loses it like one of USB.
"""

from __future__ import annotations

import ctypes
import sys
import threading
from pathlib import Path
from typing import Final

from lerobot_robot_tool0.gamepad import controller, pygame

FULL: Final = 32767
_GAMEPAD: Final = 1
_AXES, _BUTTONS = 6, 15
_TRIGGERS: Final = (
    pygame.CONTROLLER_AXIS_TRIGGERLEFT,
    pygame.CONTROLLER_AXIS_TRIGGERRIGHT,
)
_RAW_BUTTONS: Final = {
    pygame.CONTROLLER_BUTTON_A: 0,
    pygame.CONTROLLER_BUTTON_B: 1,
    pygame.CONTROLLER_BUTTON_X: 2,
    pygame.CONTROLLER_BUTTON_Y: 3,
    pygame.CONTROLLER_BUTTON_BACK: 4,
    pygame.CONTROLLER_BUTTON_LEFTSHOULDER: 9,
    pygame.CONTROLLER_BUTTON_DPAD_UP: 11,
    pygame.CONTROLLER_BUTTON_DPAD_DOWN: 12,
    pygame.CONTROLLER_BUTTON_DPAD_LEFT: 13,
}
"""Button → its number on a virtual joystick: VIRTUAL_JoystickGetGamepadMapping in
https://github.com/libsdl-org/SDL/blob/release-2.28.4/src/joystick/virtual/SDL_virtualjoystick.c
"""


class VirtualGamepad:
    """Plugged in from the start; its triggers rest, its sticks are in the middle."""

    def __init__(self) -> None:
        lines = Path("/proc/self/maps").read_text().splitlines()
        (path,) = {line.split()[-1] for line in lines if "libSDL2-2" in line}
        sdl = self._sdl = ctypes.CDLL(path)
        sdl.SDL_JoystickOpen.restype = ctypes.c_void_p
        for name in ("SDL_JoystickSetVirtualAxis", "SDL_JoystickSetVirtualButton"):
            getattr(sdl, name).argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
        sdl.SDL_JoystickClose.argtypes = [ctypes.c_void_p]
        controller.init()
        self._index: int | None = None
        self.plug_in()

    def plug_in(self) -> None:
        self._index = self._sdl.SDL_JoystickAttachVirtual(_GAMEPAD, _AXES, _BUTTONS, 0)
        assert self._index >= 0
        self._joystick = self._sdl.SDL_JoystickOpen(self._index)
        for axis in _TRIGGERS:
            self.push(axis, 0.0)

    def unplug(self) -> None:
        if self._index is not None and controller.get_init():  # SDL has not ended
            self._sdl.SDL_JoystickDetachVirtual(self._index)
            self._sdl.SDL_JoystickClose(self._joystick)
        self._index = None

    def push(self, axis: int, share: float) -> None:
        """Deflect a stick, -1 … 1, or a trigger, 0 … 1."""
        raw = 2.0 * share - 1.0 if axis in _TRIGGERS else share
        self._sdl.SDL_JoystickSetVirtualAxis(self._joystick, axis, round(raw * FULL))

    def press(self, button: int, down: bool = True) -> None:
        self._sdl.SDL_JoystickSetVirtualButton(
            self._joystick, _RAW_BUTTONS[button], int(down)
        )


def push_forward_at_a_line() -> None:
    """Plug a gamepad in; at a line on the standard input, hold its stick forward."""
    pad = VirtualGamepad()

    def push() -> None:
        sys.stdin.readline()
        pad.press(pygame.CONTROLLER_BUTTON_LEFTSHOULDER)
        pad.push(pygame.CONTROLLER_AXIS_LEFTY, -1.0)

    threading.Thread(target=push, daemon=True).start()
