"""A gamepad, through SDL's standard mapping of its sticks and buttons."""

from __future__ import annotations

import os
import warnings
from typing import Final, final

import numpy as np
from lerobot.teleoperators.utils import TeleopEvents

from lerobot_robot_tool0.device import Array, Command, beyond_dead_zone
from tool0.errors import ControlError

os.environ.setdefault("SDL_NO_SIGNAL_HANDLERS", "1")  # SIGTERM stays the program's
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # pygame's own use of pkg_resources
    import pygame
    from pygame._sdl2 import controller

FACTORS: Final = (0.1, 0.25, 0.5, 1.0)
"""Parts of the largest speed; the D-pad goes up and down in them."""
_FULL: Final = 32767
"""The largest deflection, in SDL's units."""
_STICKS: Final = (
    pygame.CONTROLLER_AXIS_LEFTX,
    pygame.CONTROLLER_AXIS_LEFTY,
    pygame.CONTROLLER_AXIS_RIGHTX,
    pygame.CONTROLLER_AXIS_RIGHTY,
    pygame.CONTROLLER_AXIS_TRIGGERLEFT,
    pygame.CONTROLLER_AXIS_TRIGGERRIGHT,
)
_DEAD_MAN: Final = pygame.CONTROLLER_BUTTON_LEFTSHOULDER
_ENDS: Final = {
    pygame.CONTROLLER_BUTTON_Y: {TeleopEvents.SUCCESS},
    pygame.CONTROLLER_BUTTON_X: {TeleopEvents.RERECORD_EPISODE},
    pygame.CONTROLLER_BUTTON_BACK: {TeleopEvents.FAILURE},
}
"""Each ends the episode, too."""


@final
class Gamepad:
    """Sticks and triggers move the tool while the left shoulder button is held.

    SDL knows the layouts of many gamepads by their identity; others are not used.
    """

    def __init__(self, dead_zone: float, name: str = "") -> None:
        """Open the first gamepad whose name contains ``name``.

        Raises:
            ControlError: If there is none, with the devices that there are.
        """
        self._dead_zone, self._name = dead_zone, name
        self._factor = len(FACTORS) - 1
        self._down: frozenset[int] = frozenset()
        controller.init()
        self._pad = self._found()
        if self._pad is None:
            there = [controller.name_forindex(k) for k in range(controller.get_count())]
            self.close()
            raise ControlError(
                f"no gamepad with a name that contains '{name}' and a layout that SDL "
                f"knows; devices: {[item for item in there if item] or 'none'}"
            )

    def read(self) -> Command | None:
        """Return the command now; None while it is unplugged.

        Gripper and events count when their buttons go down.
        """
        controller.update()
        if self._pad is None or not self._pad.attached():
            self._lose()
            self._pad = self._found()
            self._down = self._pressed()
            return None
        down = self._pressed()
        pressed, self._down = down - self._down, down
        up = pygame.CONTROLLER_BUTTON_DPAD_UP in pressed
        lower = pygame.CONTROLLER_BUTTON_DPAD_DOWN in pressed
        self._factor = min(max(self._factor + up - lower, 0), len(FACTORS) - 1)
        events: set[TeleopEvents] = set()
        for button in pressed & _ENDS.keys():
            events |= {TeleopEvents.TERMINATE_EPISODE, *_ENDS[button]}
        if _DEAD_MAN not in down:
            return Command(shares=np.zeros(6), events=frozenset(events))
        return Command(
            shares=FACTORS[self._factor] * self._shares(down),
            grip="close"
            if pygame.CONTROLLER_BUTTON_A in pressed
            else "open"
            if pygame.CONTROLLER_BUTTON_B in pressed
            else None,
            events=frozenset(events),
        )

    def close(self) -> None:
        """Let go of it."""
        self._lose()
        controller.quit()

    def _shares(self, down: frozenset[int]) -> Array:
        raw = np.array([self._pad.get_axis(axis) for axis in _STICKS]) / _FULL
        shaped = beyond_dead_zone(raw, self._dead_zone)
        x, y, rx, ry, lower, up = np.sign(shaped) * shaped**2  # fine near the middle
        turn = pygame.CONTROLLER_BUTTON_DPAD_LEFT in down
        back = pygame.CONTROLLER_BUTTON_DPAD_RIGHT in down
        return np.array([-y, -x, up - lower, rx, -ry, float(turn) - float(back)])

    def _pressed(self) -> frozenset[int]:
        if self._pad is None:
            return frozenset()
        buttons = range(pygame.CONTROLLER_BUTTON_MAX)
        return frozenset(k for k in buttons if self._pad.get_button(k))

    def _found(self) -> controller.Controller | None:
        controller.update()
        for index in range(controller.get_count()):
            if not controller.is_controller(index):
                continue
            if self._name.lower() in controller.name_forindex(index).lower():
                return controller.Controller(index)
        return None

    def _lose(self) -> None:
        if self._pad is not None:
            self._pad.quit()
        self._pad = None
