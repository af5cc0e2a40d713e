"""Compares tool0's speed with the speed of robosuite's ``Lift`` on one core.

tool0 and robosuite simulate a UR5e with a Robotiq 2F-85 at a table with a cube, with
MuJoCo and steps of 2 ms.  In every step, both programs compute the efforts of a joint
position controller with gravity compensation for a moving arm.  Neither program
renders. robosuite makes its observations 20 times per simulated second, which is the
default of ``Lift``; tool0 publishes a snapshot 125 times per simulated second.

robosuite needs an older MuJoCo and NumPy than tool0.  Therefore, robosuite gets a
separate environment in the user's cache folder, and runs in a separate process.  tool0
and robosuite alternate on one core.
"""

from __future__ import annotations

import contextlib
import math
import os
import statistics
import subprocess
import sys
import time
import venv
from collections.abc import Iterator
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # robosuite's environment does not contain tool0
    import tool0

VERSION = "1.5.1"
REQUIREMENTS = (f"robosuite=={VERSION}", "mujoco==3.3.2", "numpy<2")
CONTROLLERS = ("JOINT_POSITION", "OSC_POSE")
"""Controllers of robosuite.  The second controller, OSC_POSE, is the default of
``Lift`` and needs more computation."""
INSTALL_TIMEOUT = 900.0  # [s]
DT = 0.002
"""Length of a step of both programs [s]."""
STEPS_PER_ACTION = 25
"""Number of steps per action of robosuite, at 20 Hz."""
ACTIONS = 40
"""Number of actions in one measurement, which is 1000 steps or 2 simulated seconds."""
ROUNDS = 9
PERIOD = 40
"""Period of the arms' motion, in actions."""
SWINGING = (1.0, 0.0, 0.0, 1.0, 1.0, 1.0)
"""Amplitude factor of each joint.  With these amplitude factors, the tool remains above
the table and touches nothing."""
SWING = 0.05
"""Amplitude of the joints [rad].  The amplitude equals that of robosuite's joints with
actions of ±1."""
OSC_SWING = (0.0, 0.5, 0.0, 0.0, 0.0, 1.0)
"""Amplitude factors for ``OSC_POSE``: sideways, and about the tool's axis."""
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


class UnavailableError(Exception):
    """Raised if robosuite cannot be installed or imported on this machine."""


def speed_ratios() -> dict[str, float]:
    """Return tool0's steps/s divided by robosuite's, for each controller.

    The blocks of the programs alternate.  Each result is the median of all rounds.

    Raises:
        UnavailableError: If robosuite cannot be installed or imported.
    """
    python = _environment()
    with _one_core(), _swinging() as ours, contextlib.ExitStack() as stack:
        theirs = {
            name: stack.enter_context(_lift(python, name)) for name in CONTROLLERS
        }
        rounds = [
            (_our_seconds(ours), {name: _seconds(p) for name, p in theirs.items()})
            for _ in range(ROUNDS)
        ]
    return {
        name: statistics.median(other[name] / own for own, other in rounds)
        for name in CONTROLLERS
    }


def _environment() -> Path:
    """Return the Python of robosuite's environment, which is created if necessary."""
    from tool0.user_data import cache_folder

    folder = cache_folder() / "benchmarks" / f"robosuite-{VERSION}"
    python = folder / "bin" / "python"
    installed = folder / "installed"
    if installed.exists():
        return python
    try:
        venv.create(folder, clear=True, with_pip=True)
        for arguments in (
            ("-m", "pip", "install", "--quiet", *REQUIREMENTS),
            ("-I", "-c", "import robosuite"),
        ):
            subprocess.run(
                [str(python), *arguments],
                check=True,
                capture_output=True,
                text=True,
                timeout=INSTALL_TIMEOUT,
            )
    except subprocess.CalledProcessError as error:
        *_, last = (error.stderr or str(error)).strip().splitlines()
        raise UnavailableError(last) from error
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UnavailableError(str(error)) from error
    installed.touch()
    return python


@contextlib.contextmanager
def _one_core() -> Iterator[None]:
    """Keep this process and the processes that it starts on one core."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


@contextlib.contextmanager
def _swinging() -> Iterator[tool0.Robot]:
    """Bring up tool0's robot, which swings during all measurements."""
    import tool0
    from benchmarks.tick import arm_controllers
    from tool0.scene import Box, Pose, Scene, SceneObject

    table = SceneObject(
        name="table",
        geometry=Box(size=(0.5, 0.8, 0.08)),
        pose=Pose(xyz=(0.65, 0.05, -0.06)),
    )
    cube = SceneObject(
        name="cube",
        geometry=Box(size=(0.04, 0.04, 0.04)),
        pose=Pose(xyz=(0.6, 0.0, 0.0)),
        mass=0.1,
    )
    with tool0.bringup(
        arm="ur5e",
        gripper="2f85",
        scene=Scene((table, cube)),
        simulation=tool0.SimulationConfig(dt=DT),
        initial_pose="ready",
        realtime=False,
    ) as robot:
        robot.run(1.0)
        (controller,) = arm_controllers(robot)
        start = controller.query_state().positions
        n_points = 2 * (ROUNDS + 1) * ACTIONS
        points = [
            tool0.TrajectoryPoint(
                [
                    q + SWING * share * math.sin(math.tau * k / PERIOD)
                    for q, share in zip(start, SWINGING, strict=True)
                ],
                time_from_start=(k + 1) * STEPS_PER_ACTION * DT,
            )
            for k in range(n_points)
        ]
        controller.follow(points)
        robot.run(1.0)
        yield robot


def _our_seconds(robot: tool0.Robot) -> float:
    start = time.perf_counter()
    robot.run(ACTIONS * STEPS_PER_ACTION * DT)
    return time.perf_counter() - start


@contextlib.contextmanager
def _lift(python: Path, controller: str) -> Iterator[Popen[str]]:
    """Start robosuite's process, and wait until it is ready."""
    process = Popen(
        # -I: this file's folder must not hide modules
        [str(python), "-I", __file__, controller],
        stdin=PIPE,
        stdout=PIPE,
        stderr=DEVNULL,
        text=True,
        env={**os.environ, **ONE_THREAD},
    )
    try:
        _seconds(process)  # compiles the functions with numba
        yield process
    finally:
        process.kill()
        process.communicate()


def _seconds(process: Popen[str]) -> float:
    """Request one block of steps from robosuite, and return its duration [s]."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("\n")
    process.stdin.flush()
    for line in process.stdout:
        if line.startswith("seconds "):
            return float(line.split()[1])
    raise RuntimeError(f"robosuite ended with {process.wait()}")


def _run_lift(controller: str) -> None:
    """Step ``Lift`` by one block for each line of input.

    This function runs in robosuite's process.
    """
    import robosuite
    from robosuite.controllers import (
        load_composite_controller_config,
        load_part_controller_config,
    )

    config = load_composite_controller_config(controller="BASIC")
    part = load_part_controller_config(default_controller=controller)
    config["body_parts"] = {"right": {**part, "gripper": {"type": "GRIP"}}}
    lift = robosuite.make(
        "Lift",
        robots="UR5e",
        gripper_types="Robotiq85Gripper",
        controller_configs=config,
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
        ignore_done=True,
        horizon=10**9,
    )
    n_steps = lift.control_timestep / lift.model_timestep
    if (lift.model_timestep, round(n_steps)) != (DT, STEPS_PER_ACTION):
        raise RuntimeError(f"robosuite has {n_steps} steps of {lift.model_timestep} s")
    lift.reset()
    shares = OSC_SWING if controller == "OSC_POSE" else SWINGING
    k = 0
    for _ in sys.stdin:
        start = time.perf_counter()
        for _ in range(ACTIONS):
            k += 1
            swing = math.cos(math.tau * k / PERIOD)
            lift.step([*(swing * share for share in shares), 0.0])
        print("seconds", time.perf_counter() - start, flush=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        _run_lift(sys.argv[1])
    else:
        sys.path.insert(0, str(Path(__file__).parent.parent))
        for name, ratio in speed_ratios().items():
            print(f"steps/s ÷ robosuite's Lift, {name}: {ratio:.2f}")
