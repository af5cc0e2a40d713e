"""Requests and calls of the API with wrong values: an error of tool0, or a result."""

from __future__ import annotations

import inspect
import random
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache, partial
from typing import Any

import pytest
from fuzzing import SCALE, Trial, anything, made, value_of

import tool0
from tool0.protocol.methods import methods

N_REQUESTS = 600 * SCALE
N_CALLS = 400 * SCALE
SEED = 11
ARM = "eff_joint_traj_controller"
LASTING = {"run", "step"}
"""Methods that do what they are asked for as long as they are asked."""
KEPT = {"close", "subscribe"}
"""Those that end the robot, or leave something behind."""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tool0.Robot]:
    folder = tmp_path_factory.mktemp("fuzzed")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name in ("XDG_DATA_HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "HOME"):
            patch.setenv(name, str(folder / name))
        with tool0.bringup(scene="table_and_cubes", realtime=False) as robot:
            yield robot


@pytest.mark.timeout(600 * SCALE)
def test_requests(robot: tool0.Robot) -> None:
    kinds = [kind for name, kind in sorted(methods().items()) if name not in LASTING]
    trial = Trial("requests")
    for number in range(N_REQUESTS):
        rng = random.Random(f"{SEED}.{number}")
        request = made(rng.choice(kinds), rng)
        if isinstance(request, dict):  # it is refused where it is made
            continue
        trial.carry_out(
            partial(robot.channel.call, request), f"case {number}: {request!r}"
        )
        if number % 50 == 0:
            recover(robot)
    trial.check()


@pytest.mark.timeout(600 * SCALE)
def test_calls_of_the_api(robot: tool0.Robot) -> None:
    trial = Trial("calls of the API")
    for number in range(N_CALLS):
        rng = random.Random(f"{SEED}.{number}")
        owner, name = rng.choice(operations(robot))
        method = getattr(owner, name)
        words, keywords = arguments_of(getattr(type(owner), name), rng)
        said = (
            f"case {number}: {type(owner).__name__}.{name}(*{words!r}, **{keywords!r})"
        )
        case = partial(method, *words, **keywords)
        trial.carry_out(partial(carried_out, case), said)
        if number % 50 == 0:
            recover(robot)
    trial.check()


def carried_out(case: Callable[[], object]) -> None:
    """Carry a call out; a recording in memory ends, or it would go on meanwhile."""
    result = case()
    if isinstance(result, tool0.Recording):
        result.stop()


def recover(robot: tool0.Robot) -> None:
    """Make the robot usable again, whatever was asked of it."""
    for repair in (
        partial(robot.emergency_stop, engaged=False),
        robot.stop_recording,
        robot.resume,
        robot.reset,
    ):
        with suppress(tool0.Tool0Error):
            repair()
    robot.run(0.01)


def operations(robot: tool0.Robot) -> list[tuple[Any, str]]:
    """Return the public methods of the robot's handles."""
    handles = [robot, robot.arm, robot.gripper, robot.scene, robot.episodes]
    handles += [robot.programs, robot.arm.motion, robot.arm.control_box]
    handles += [robot.force_torque, robot.controller(ARM)]
    found = []
    for handle in handles:
        for name in sorted(dir(type(handle))):
            member = getattr(type(handle), name)
            if name[0] != "_" and callable(member) and name not in LASTING | KEPT:
                found.append((handle, name))
    return found


def arguments_of(function: Any, rng: random.Random) -> tuple[list[Any], dict[str, Any]]:
    """Return arguments that its signature takes, of types that more or less fit."""
    hints = hints_of(function)
    positional, keywords = [], {}
    for name, parameter in list(inspect.signature(function).parameters.items())[1:]:
        if parameter.default is not parameter.empty and rng.random() < 0.5:
            if parameter.kind is parameter.POSITIONAL_OR_KEYWORD:
                break
            continue
        value = value_of(hints.get(name, Any), rng)
        if name == "timeout":
            value = rng.choice((0.0, 0.01, -1.0, float("nan"), "x"))
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if parameter.kind is parameter.KEYWORD_ONLY:
            keywords[name] = value
        else:
            positional.append(value)
    return positional, keywords


@cache
def hints_of(function: Any) -> dict[str, Any]:
    """Return the types of the arguments, as far as they can be looked up here."""
    found = {}
    for name, text in inspect.get_annotations(function).items():
        with suppress(NameError, TypeError, AttributeError):
            found[name] = eval(text, function.__globals__ | vars(tool0))
    return found


def test_values_are_of_every_kind() -> None:
    kinds = {type(anything(random.Random(k))).__name__ for k in range(300)}
    assert {"NoneType", "bool", "int", "float", "str", "bytes", "list"} <= kinds
