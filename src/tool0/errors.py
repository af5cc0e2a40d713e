"""The error hierarchy: every error that tool0 raises on purpose is a ``Tool0Error``.

Tool0Error
├── ModelError                  physically impossible parameters
│   ├── LimitsError
│   └── UnreachableError        a pose that the arm cannot reach
├── DescriptionError            XML, YAML parameters or a mesh that cannot be read
├── ConfigError                 a setting that is unknown, missing or out of range
├── PenetrationError            a pose or an object that penetrates a body
├── EngineError
│   ├── EngineUnavailableError  the engine is not installed, or does not answer
│   └── DivergenceError         the physics state is not finite, or grows without bound
├── ControlError
│   ├── ClaimError              two controllers claim the same joint
│   ├── GoalRejectedError       a goal that a controller refuses, with an error code
│   ├── GoalTimeoutError        a goal is still active; also a TimeoutError
│   ├── NotOfferedError         a request that this robot does not support
│   ├── ProgramError            a program that cannot be executed
│   └── RequestError            a value of the wrong type or out of bounds
├── GymUnavailableError         Gymnasium is not installed; also an ImportError
├── CollectError                episodes cannot be collected
├── RecordingError              a recording cannot be written or read
├── RenderError                 no picture or video can be made
└── TransportError              a peer violated the protocol, or an address is in use
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import final

_CANDIDATES = 8
"""Number of the most similar names that are compared character by character."""
_MOST_NAMES = 500
_LONGEST_NAME = 100
"""Maximum number and maximum length of the names that are searched for similar ones;
the search time grows with both values."""


@final
@dataclass(frozen=True, slots=True)
class SourceLocation:
    """A location in a user's file."""

    file: Path | None
    """Path of the file; None if the text is not from a file."""
    line: int | None = None
    """Line number, counted from 1; None if the line is unknown."""

    def __str__(self) -> str:
        """Return ``file:line``, in the notation of compilers."""
        name = "<string>" if self.file is None else str(self.file)
        return name if self.line is None else f"{name}:{self.line}"


class Tool0Error(Exception):
    """Base of every error that tool0 raises on purpose."""


class _LocatedError(Tool0Error):
    """An error in the content of a file."""

    def __init__(self, message: str, location: SourceLocation | None = None) -> None:
        super().__init__(message if location is None else f"{location}: {message}")
        self.message = message
        self.location = location


class ModelError(_LocatedError):
    """Parameters that are physically impossible for a robot."""


class LimitsError(ModelError):
    """Joint limits that contradict each other."""


class UnreachableError(ModelError):
    """A pose that the arm cannot reach, or a line that the arm cannot follow."""


class DescriptionError(_LocatedError):
    """XML, parameters or a mesh that cannot be read."""


class ConfigError(_LocatedError):
    """A setting that is unknown, missing or out of range."""


class PenetrationError(Tool0Error):
    """A pose or an object would penetrate a body.

    The physics would separate the bodies violently.
    """


class EngineError(Tool0Error):
    """The physics engine failed."""


class EngineUnavailableError(EngineError):
    """The physics engine is not installed, or does not answer."""


class RosUnavailableError(Tool0Error):
    """ROS is not installed, or its master does not answer."""


class GymUnavailableError(Tool0Error, ImportError):
    """Gymnasium is not installed."""


class DivergenceError(EngineError):
    """The physics state or its input is not finite or grows without bound."""

    def __init__(
        self, joint: str, time: float, quantity: str = "state", kind: str = "joint"
    ) -> None:
        """Report the diverged joint (or other ``kind`` of element), and the time."""
        super().__init__(
            f"the {quantity} of {kind} '{joint}' diverged at t = {time:.3f} s; reset "
            "the simulation, and look for overlapping bodies and unbounded efforts"
        )
        self.joint = joint
        self.time = time


class ControlError(Tool0Error):
    """A request that the controller manager or a controller refuses."""


class ClaimError(ControlError):
    """Two controllers claim the same joint."""


class NoSuchPartError(ControlError, KeyError):
    """A part that the robot does not have, such as a gripper or a camera."""

    __str__ = Exception.__str__  # str() of a KeyError puts the message in quotes


class NotOfferedError(ControlError):
    """A request that this robot does not support; other robots may support it."""


class GoalRejectedError(ControlError):
    """A goal that a controller refuses; the motion in progress continues.

    ``code`` is the error code of control_msgs/FollowJointTrajectoryResult: -1
    INVALID_GOAL, -2 INVALID_JOINTS, -3 OLD_HEADER_TIMESTAMP.
    """

    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3

    def __init__(self, message: str, code: int = INVALID_GOAL) -> None:
        super().__init__(message)
        self.code = code


class GoalTimeoutError(ControlError, TimeoutError):
    """A goal was still active when the wait for it ended."""


class CollisionError(ControlError):
    """A start, target or path of a motion is in collision, or too close to a body."""


class PlanningError(ControlError):
    """No collision-free motion was found; the message contains the reason."""


class ProgramError(ControlError):
    """A program that cannot be executed; the message states the step and the reason."""


class RequestError(ControlError):
    """A request with a value that has the wrong type or is out of bounds."""

    def __init__(self, method: str, problem: str) -> None:
        super().__init__(f"{method}: {problem}")
        self.method = method
        self.problem = problem


class CollectError(Tool0Error):
    """Episodes cannot be collected; the completed episodes are kept."""


class PolicyError(Tool0Error):
    """A policy cannot be loaded or queried, or its actions cannot be executed."""


class RecordingError(Tool0Error):
    """A recording cannot be written, or a file is not a recording."""


class RenderError(Tool0Error):
    """An image or a video cannot be made, usually because software is missing."""


class TransportError(Tool0Error):
    """A peer violated the protocol or is missing, or an address is in use."""


def nearest_name(name: str, valid: Collection[str], cutoff: float = 0.6) -> str | None:
    """Return the valid name that is most similar to ``name``, or None.

    A valid name that differs only by a prefix is preferred: for ``tool0``, this is
    ``left_tool0``.  Otherwise, the name with the fewest different characters is
    returned, ignoring case: for ``UR6``, this is ``ur5``, not ``ur16e``.

    Args:
        name: The unknown name.
        valid: The names to choose from.
        cutoff: Minimum similarity, from 0 (any) to 1 (identical).
    """
    import difflib

    if not name or len(name) > _LONGEST_NAME or len(valid) > _MOST_NAMES:
        return None
    names = sorted(item for item in valid if 0 < len(item) <= _LONGEST_NAME)
    prefixed = [
        item for item in names if item.endswith(f"_{name}") or name.endswith(f"_{item}")
    ]
    if len(prefixed) == 1:
        return prefixed[0]
    if name in names:
        return name
    folded = {item.lower(): item for item in names}
    close = difflib.get_close_matches(
        name.lower(), folded, n=_CANDIDATES, cutoff=cutoff
    )
    nearest = min(close, key=lambda item: _edits(name.lower(), item), default=None)
    return None if nearest is None else folded[nearest]


def is_typo(written: str, meant: str | None) -> bool:
    """Return whether two names differ by only a few characters.

    The limit is two characters, or fewer for short names.  The comparison ignores case.
    """
    if meant is None or max(len(written), len(meant)) > _LONGEST_NAME:
        return False
    return _edits(written.lower(), meant.lower()) <= min(2, len(meant) // 3)


def _edits(written: str, meant: str) -> int:
    """Return the number of characters that differ."""
    import difflib

    pair = difflib.SequenceMatcher(None, written, meant, autojunk=False)
    return sum(
        max(i2 - i1, j2 - j1)
        for tag, i1, i2, j1, j2 in pair.get_opcodes()
        if tag != "equal"
    )


def did_you_mean(name: str, valid: Collection[str]) -> str:
    """Return ``"; did you mean 'x'?"``, or ``"; valid: a, b"`` if none is similar."""
    near = nearest_name(name, valid)
    if near is not None:
        return f"; did you mean '{near}'?"
    return f"; valid: {', '.join(sorted(valid)) or '(none)'}"
