"""Ownership by one process: threads and connections cannot be forked or pickled."""

from __future__ import annotations

import os
from typing import NoReturn, final

from tool0.errors import ControlError


@final
class OwnProcess:
    """The process in which a robot was created."""

    def __init__(self) -> None:
        self._pid = os.getpid()

    @property
    def is_this(self) -> bool:
        """Whether the current process, rather than its parent, created the robot."""
        return os.getpid() == self._pid

    def check(self) -> None:
        """Raise ControlError in a forked child, where a call would never return."""
        if not self.is_this:
            raise ControlError(
                f"this robot belongs to process {self._pid}, and this is a fork of it; "
                "call tool0.bringup or tool0.connect here (with multiprocessing, use "
                "the start method 'spawn')"
            )


def refuse_pickle() -> NoReturn:
    """Raise TypeError, because simulations and connections cannot be pickled."""
    raise TypeError(
        "a robot cannot be pickled or copied; give other processes the name of its "
        "bring-up, and call tool0.connect(name) there"
    )
