"""Controllers and time of a running bringup: ``tool0 controllers | pause | …``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import columns, print_json
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.cli.outputs import ControllersOutput, GainsOutput, StepOutput

Names = Annotated[tuple[str, ...], Option(is_positional=True, metavar="CONTROLLER ...")]


def show(*, as_json: AsJson = False, bringup: Bringup = DEFAULT) -> None:
    """List the loaded controllers with their types, states and claimed joints.

    Args:
        as_json: Print one JSON object.
    """
    with bringup.connect() as robot:
        found = robot.controllers()
    if as_json:
        listed: ControllersOutput = {"controllers": found}
        print_json(listed)
        return
    rows = [
        (
            status.name,
            status.type,
            status.state,
            " ".join(joint for _, joints in status.claimed for joint in joints),
        )
        for status in found
    ]
    print(columns([("name", "type", "state", "claimed joints"), *rows]), end="")


def load(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Load controllers that the YAML files define, without starting them.

    Args:
        names: Names of the controllers.
    """
    with bringup.connect() as robot:
        for name in names:
            robot.load(name)


def configure(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Configure unconfigured controllers of ROS 2, which makes them inactive.

    Args:
        names: Names of the controllers.
    """
    with bringup.connect() as robot:
        for name in names:
            robot.configure(name)


def unload(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Unload stopped controllers.

    Args:
        names: Names of the controllers.
    """
    with bringup.connect() as robot:
        for name in names:
            robot.unload(name)


def start(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Start loaded controllers at the same instant: all of them, or none.

    Args:
        names: Names of the controllers.
    """
    with bringup.connect() as robot:
        robot.switch(start=names)


def stop(names: Names, bringup: Bringup = DEFAULT) -> None:
    """Stop controllers; the brakes then hold the controllers' joints.

    Args:
        names: Names of the controllers.
    """
    with bringup.connect() as robot:
        robot.switch(stop=names)


def switch(
    start: Annotated[tuple[str, ...], Option(metavar="CONTROLLER ...")] = (),
    stop: Annotated[tuple[str, ...], Option(metavar="CONTROLLER ...")] = (),
    best_effort: bool = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Stop some controllers and start others at the same instant.

    Args:
        start: Controllers to start.
        stop: Controllers to stop.
        best_effort: Skip impossible changes instead of refusing the whole request.
    """
    if not start and not stop:
        raise ConfigError("give --start CONTROLLER ... or --stop CONTROLLER ...")
    with bringup.connect() as robot:
        robot.switch(start=start, stop=stop, strict=not best_effort)


def gains(
    name: Annotated[str, Option(is_positional=True, metavar="CONTROLLER")],
    joint: str | None = None,
    *,
    p: float | None = None,
    i: float | None = None,
    d: float | None = None,
    i_clamp: float | None = None,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Print the PID gains of a controller; with --joint, change them first.

    The gains apply until the controller is unloaded.  To change the gains permanently,
    write the YAML with `tool0 describe controllers`, edit it, and use it with `tool0
    bringup --controllers-file`.

    Args:
        name: Name of the controller.
        joint: Joint whose gains are changed.
        p: Proportional gain: command per unit of position error.
        i: Integral gain: command per unit of the time integral of the position error.
        d: Derivative gain: command per unit of velocity error.
        i_clamp: Maximum magnitude of the integral term.
        as_json: Print one JSON object.
    """
    if joint is None and (p, i, d, i_clamp) != (None,) * 4:
        raise ConfigError("name the joint whose gains change: --joint JOINT")
    with bringup.connect() as robot:
        controller = robot.controller(name)
        if joint is not None:
            controller.set_gains(joint, p=p, i=i, d=d, i_clamp=i_clamp)
        found = controller.gains
    if as_json:
        listed: GainsOutput = {"gains": found}
        print_json(listed)
        return
    rows = [
        (joint, *(f"{value:g}" for value in (g.p, g.i, g.d, g.i_min, g.i_max)))
        for joint, g in found.items()
    ]
    print(columns([("joint", "p", "i", "d", "i_min", "i_max"), *rows]), end="")


controllers = {
    "list": show,
    "load": load,
    "unload": unload,
    "start": start,
    "stop": stop,
    "switch": switch,
    "gains": gains,
}


def pause(bringup: Bringup = DEFAULT) -> None:
    """Pause simulated time."""
    with bringup.connect() as robot:
        robot.pause()


def resume(bringup: Bringup = DEFAULT) -> None:
    """Continue simulated time."""
    with bringup.connect() as robot:
        robot.resume()


def step(
    ticks: Annotated[int, Option(is_positional=True, metavar="TICKS")] = 1,
    *,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Advance a paused simulation, and print the new simulated time.

    Args:
        ticks: Number of control periods.
        as_json: Print one JSON object.
    """
    if ticks < 1:
        raise ConfigError(f"step: need 1 or more ticks, got {ticks}")
    with bringup.connect() as robot:
        robot.step(ticks)
        time = robot.time
    if as_json:
        reached: StepOutput = {"time": time}
        print_json(reached)
    else:
        print(f"t = {time:.3f} s")


def reset(bringup: Bringup = DEFAULT) -> None:
    """Return to time zero and the initial pose; active goals end as PREEMPTED."""
    with bringup.connect() as robot:
        robot.reset()


def estop(release: bool = False, bringup: Bringup = DEFAULT) -> None:
    """Engage the emergency stop: brake every joint immediately, and hold it.

    Args:
        release: Release the emergency stop; the controllers then hold the current
            positions.
    """
    with bringup.connect() as robot:
        robot.emergency_stop(engaged=not release)
