"""The gains of JointTrajectoryController in ROS 2, which uses control_toolbox."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tool0.description.model import Joint
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean
from tool0.protocol.controllers import UNLIMITED, Gains, Unwinding

_GAINS = (
    *("p", "i", "d", "i_clamp", "i_clamp_min", "i_clamp_max", "ff_velocity_scale"),
    *("u_clamp_min", "u_clamp_max", "error_deadband", "tracking_time_constant"),
)
_UNWINDING = {
    "none": Unwinding.NONE,
    "conditional_integration": Unwinding.CONDITIONAL_INTEGRATION,
    "back_calculation": Unwinding.BACK_CALCULATION,
    "legacy": Unwinding.NONE,
}
"""Values of the parameter for the anti-windup strategy; the first value is the default.
Only ROS 2 Jazzy has the value ``legacy``."""
_OTHER_GAINS = (
    *("u_clamp_min", "u_clamp_max", "saturation", "error_deadband", "save_i_term"),
    *("antiwindup", "antiwindup_strategy", "tracking_time_constant"),
    *("angle_wraparound", "normalize_error"),
)
"""Additional gains that some versions of ROS 2 read."""


def read_joint_gains(
    parameters: Namespace, joints: Sequence[Joint]
) -> tuple[tuple[Gains, ...], tuple[float, ...]]:
    """Return the gains and the velocity feed-forward factor of each joint."""
    found = [_gains_of(parameters, f"gains/{joint.name}") for joint in joints]
    feed_forward = [
        parameters.number(f"gains/{joint.name}/ff_velocity_scale", 0.0)
        for joint in joints
    ]
    return tuple(found), tuple(feed_forward)


def _gains_of(parameters: Namespace, path: str) -> Gains:
    """Return the gains at ``path``.

    The integral itself is clamped, as it is in ROS 2.
    """
    number = parameters.number
    p, i, d = (number(f"{path}/{gain}", 0.0) for gain in ("p", "i", "d"))
    symmetric = abs(_bound(parameters, f"{path}/i_clamp", UNLIMITED))
    low = _bound(parameters, f"{path}/i_clamp_min", -UNLIMITED)
    high = _bound(parameters, f"{path}/i_clamp_max", UNLIMITED)
    parameters.mark_adjustable(*(f"{path}/{gain}" for gain in _GAINS))
    parameters.accept(*(f"{path}/{gain}" for gain in _OTHER_GAINS))
    unwinding = choice(parameters, f"{path}/antiwindup_strategy", tuple(_UNWINDING))
    tracking_time = parameters.not_negative(f"{path}/tracking_time_constant", 0.0)
    u_min = _bound(parameters, f"{path}/u_clamp_min", -UNLIMITED)
    u_max = _bound(parameters, f"{path}/u_clamp_max", UNLIMITED)
    deadband = parameters.not_negative(f"{path}/error_deadband", 0.0)
    try:
        return Gains(
            p=p,
            i=i,
            d=d,
            i_min=-abs(low) if abs(low) < UNLIMITED else -symmetric,
            i_max=abs(high) if abs(high) < UNLIMITED else symmetric,
            antiwindup=True,
            u_min=u_min,
            u_max=u_max,
            error_deadband=deadband,
            unwinding=_UNWINDING[unwinding],
            tracking_time=tracking_time or _tracking_time(p, i, d),
        )
    except ConfigError as error:
        entry = parameters.find(path) or parameters.entry
        raise ConfigError(str(error), entry.location) from None


def _tracking_time(p: float, i: float, d: float) -> float:
    """Return the default tracking time constant of control_toolbox [s].

    The default applies if the parameter is 0.
    """
    ratio = (math.sqrt(d / i) if d / i > 0.0 else p / i) if i else 1.0
    return ratio if ratio > 0.0 else 1.0


def _bound(parameters: Namespace, path: str, default: float) -> float:
    """Return the number at ``path``; the number may be infinite."""
    entry = parameters.find(path)
    if entry is not None and entry.scalar in {math.inf, -math.inf}:
        return math.copysign(UNLIMITED, entry.scalar)
    return parameters.number(path, default)


def choice(parameters: Namespace, path: str, valid: tuple[str, ...]) -> str:
    """Return the string at ``path``, which must be one of ``valid``.

    The first valid string is the default.
    """
    text = parameters.text(path, valid[0])
    entry = parameters.find(path)
    if entry is not None and text not in valid:
        raise ConfigError(
            f"'{entry.key}' cannot be '{text}'{did_you_mean(text, valid)}",
            entry.location,
        )
    return text
