"""The options of a task's environment and their checks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Literal, NamedTuple, final

from tool0.description.look import BRIGHTEST
from tool0.errors import ConfigError, did_you_mean

ActionMode = Literal["joint", "cartesian", "pose"]
ObservationMode = Literal["state", "dict", "goal", "image"]
RewardMode = Literal["dense", "sparse"]

_CHOICES = {
    "action": ("joint", "cartesian", "pose"),
    "observation": ("state", "dict", "goal", "image"),
    "reward": ("dense", "sparse"),
}

_LARGEST = {
    "joint_noise": (0.2, " rad"),
    "colour": (1.0, ""),
    "lamp": (2.0, " m"),
    "camera": (0.2, " m"),
    "camera_turn": (0.5, " rad"),
}
"""Upper bound and unit of each random deviation, by name."""
_NAMES = {"arm": "ur5", "gripper": "2f85"}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Randomisation:
    """Variation between episodes, in addition to the poses of objects and goals.

    Factors are drawn uniformly for each movable object.  For a constant factor, use a
    range with equal ends.
    """

    mass: tuple[float, float] = (0.5, 2.0)
    """Range of the factor on the mass that the task specifies."""
    friction: tuple[float, float] = (0.8, 1.25)
    """Range of the factor on the friction coefficient that the task specifies."""
    size: tuple[float, float] = (1.0, 1.0)
    """Range of the factor on the size of each object in ``Task.resizable``, clipped to
    sizes that the gripper can grasp; by default, sizes are constant."""
    joint_noise: float = 0.03
    """Largest deviation of an arm's joints from the start pose [rad]."""
    colour: float = 0.15
    """Largest change in an object's red, green and blue values, which are within 0 … 1;
    it affects only images."""
    brightness: tuple[float, float] = (0.6, 1.2)
    """Range of the light's brightness, relative to the default; it affects only
    images."""
    lamp: float = 1.0
    """Largest displacement of the lamp along each axis [m]; it affects only images."""
    camera: float = 0.02
    """Largest displacement of a camera along each axis [m]; it affects only images."""
    camera_turn: float = 0.03
    """Largest rotation of a camera about each axis [rad]; it affects only images."""

    def __post_init__(self) -> None:
        for name in ("mass", "friction", "size", "brightness"):
            given = getattr(self, name)
            low, high = _pair(given, f"randomise.{name}")
            if not 0.0 < low <= high < math.inf:
                raise ConfigError(
                    f"randomise.{name} must be two numbers above 0, the smaller first, "
                    f"got {given}"
                )
        if self.brightness[1] > BRIGHTEST:
            raise ConfigError(
                f"randomise.brightness must be at most {BRIGHTEST:g}, got "
                f"{self.brightness}"
            )
        for name, (most, unit) in _LARGEST.items():
            if not 0.0 <= getattr(self, name) <= most:
                raise ConfigError(
                    f"randomise.{name} must be 0 … {most:g}{unit}, got "
                    f"{getattr(self, name)}"
                )


class ImageKeys(NamedTuple):
    """Keys of one camera's images in observations."""

    rgb: str
    depth: str
    segmentation: str


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EnvOptions:
    """The options of an environment, given as arguments of ``gymnasium.make``."""

    arm: str = "ur5"
    """Name of an arm in the catalogue."""
    gripper: str = "2f85"
    """Name of a gripper in the catalogue."""
    action: ActionMode = "cartesian"
    """Kind of action: joint, cartesian or pose (docs/how-to/gym.md)."""
    observation: ObservationMode = "state"
    """Kind of observation (docs/how-to/gym.md)."""
    reward: RewardMode = "dense"
    """Kind of reward: "dense" for a reward in each step, or "sparse" for a reward only
    on success."""
    control_rate: float = 20.0
    """Actions per simulated second [Hz]."""
    terminate_on_success: bool = True
    """Whether an episode ends when the task succeeds."""
    randomise: bool | Randomisation = False
    """Whether to randomize masses, friction coefficients, start poses and other
    properties, or the ranges of these properties."""
    camera: str | tuple[str, ...] = "scene"
    """The cameras for images: "scene", "wrist" or both."""
    depth: bool = False
    """Whether observations also have depth images."""
    segmentation: bool = False
    """Whether observations also have segmentation images."""
    image_size: tuple[int, int] = (96, 96)
    """Width and height of images in observations and from ``render`` [pixels]."""
    dt: float = 0.001
    """Length of a physics step [s]."""
    threads: int | None = None
    """Number of threads that step the copies; the default is that of
    ``tool0.Batch``."""
    device: str = "cpu"
    """The device that computes the physics; see ``tool0.Batch``."""

    def __post_init__(self) -> None:
        for name, choices in _CHOICES.items():
            value = getattr(self, name)
            if value not in choices:
                raise ConfigError(
                    f"{name} must be one of {', '.join(choices)}; got {value!r}"
                )
        for name, known in _NAMES.items():
            value = getattr(self, name)
            if not isinstance(value, str):
                raise ConfigError(
                    f"{name} must be one name, such as '{known}'; got {value!r}"
                )
        if not isinstance(self.terminate_on_success, bool):
            raise ConfigError(
                "terminate_on_success must be True or False, got "
                f"{self.terminate_on_success!r}"
            )
        for name in ("depth", "segmentation"):
            value = getattr(self, name)
            if value not in {True, False}:
                raise ConfigError(f"{name} must be True or False, got {value!r}")
            if value and self.observation != "image":
                raise ConfigError(f"{name} needs observation='image'")
        names = self.cameras if isinstance(self.camera, str | tuple | list) else ()
        if (
            not names
            or len(set(names)) < len(names)
            or not all(isinstance(name, str) for name in names)
        ):
            raise ConfigError(
                "camera must be a name, such as 'scene', or several different ones; "
                f"got {self.camera!r}"
            )
        if not isinstance(self.randomise, bool | Randomisation):
            raise ConfigError(
                "randomise must be True, False or a tool0.gym.Randomisation, got "
                f"{self.randomise!r}"
            )
        if not (_is_number(self.dt) and 0.0 < self.dt <= 0.01):
            raise ConfigError(f"dt must be above 0 and at most 0.01 s, got {self.dt}")
        if not (_is_number(self.control_rate) and 1.0 <= self.control_rate <= 200.0):
            raise ConfigError(
                f"control_rate must be 1 … 200 Hz, got {self.control_rate}"
            )
        if not math.isclose(self.ticks * self.dt * self.control_rate, 1.0):
            raise ConfigError(
                f"a period of control_rate {self.control_rate:g} Hz must be a whole "
                f"number of steps of {self.dt:g} s; take 20, 25, 50 or 100 Hz"
            )
        _pair(self.image_size, "image_size")

    @property
    def cameras(self) -> tuple[str, ...]:
        """The cameras for images: at least one."""
        return (self.camera,) if isinstance(self.camera, str) else tuple(self.camera)

    @property
    def image_keys(self) -> dict[str, ImageKeys]:
        """Keys of the images in observations, by camera."""
        names = self.cameras
        if len(names) == 1:
            return {names[0]: ImageKeys(*ImageKeys._fields)}
        return {
            name: ImageKeys(*(f"{kind}_{name}" for kind in ImageKeys._fields))
            for name in names
        }

    @property
    def ticks(self) -> int:
        """Physics steps per action."""
        return round(1.0 / (self.control_rate * self.dt))

    @property
    def period(self) -> float:
        """Simulated time per action [s]."""
        return self.ticks * self.dt

    @property
    def ranges(self) -> Randomisation | None:
        """Ranges of the random properties; None if randomization is disabled."""
        if self.randomise is True:
            return Randomisation()
        return self.randomise or None


def read_options(given: Mapping[str, object]) -> EnvOptions:
    """Return the options that the keyword arguments specify, or raise ConfigError."""
    names = [item.name for item in fields(EnvOptions)]
    for name in given:
        if name not in names:
            raise ConfigError(f"unknown option '{name}'{did_you_mean(name, names)}")
    return EnvOptions(**given)  # type: ignore[arg-type]  # checked in __post_init__


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _pair(value: object, what: str) -> tuple[float, float]:
    if not (isinstance(value, tuple | list) and len(value) == 2) or not all(
        map(_is_number, value)
    ):
        raise ConfigError(f"{what} must be two numbers, got {value!r}")
    return value[0], value[1]
