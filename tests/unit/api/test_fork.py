"""A robot in a forked child: its threads are gone, and nothing may wait for them."""

from __future__ import annotations

import json
from pathlib import Path

import fresh_python
import pytest
from served import use_folder

PROGRAM = """
import contextlib, json, os, sys, warnings
warnings.simplefilter("ignore", DeprecationWarning)  # of threads and fork
sys.path.insert(0, sys.argv[2])
import tool0
from served import serving

def outcome(call):
    try:
        return repr(call())
    except Exception as error:
        return f"{type(error).__name__}: {error}"

options = {"realtime": {}, "lock-step": {"realtime": False}, "remote": {}}[sys.argv[1]]
with contextlib.ExitStack() as exits:
    robot = exits.enter_context(tool0.bringup(**options))
    exits.enter_context(serving(robot))
    if sys.argv[1] == "remote":
        robot = exits.enter_context(tool0.connect())
    robot.pause()  # else the goal might end before the child asks for it
    goal = robot.move_joints({"elbow_joint": 1.4})[0]
    stream = robot.subscribe()
    calls = {
        "pause": robot.pause,
        "snapshot": lambda: robot.snapshot,
        "controllers": robot.controllers,
        "run": lambda: robot.run(1.0),
        "wait": goal.wait,
        "cancel": goal.cancel,
        "gripper": robot.gripper.wait,
        "subscribe": robot.subscribe,
        "next": stream.next,
        "following": stream.following,
    }
    read, write = os.pipe()
    if os.fork() == 0:
        found = {name: outcome(call) for name, call in calls.items()}
        exits.close()  # leaves everything to the parent
        with os.fdopen(write, "w") as pipe:
            json.dump({"pid": os.getppid(), **found}, pipe)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as pipe:
        print(pipe.read())
    os.wait()
    robot.resume()
    assert goal.wait(30.0).status is tool0.GoalStatus.SUCCEEDED
    assert tool0.connect().snapshot is not None
"""


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["realtime", "lock-step", "remote"])
def test_every_call_in_a_forked_child_is_refused_and_the_parent_goes_on(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_folder(monkeypatch, tmp_path)
    rigs = str(Path(fresh_python.__file__).parent)
    outcomes = json.loads(fresh_python.run(PROGRAM, kind, rigs))
    parent = outcomes.pop("pid")
    for name, outcome in outcomes.items():
        assert outcome.startswith("ControlError"), (name, outcome)
        assert f"process {parent}," in outcome
        assert "tool0.bringup or tool0.connect" in outcome
