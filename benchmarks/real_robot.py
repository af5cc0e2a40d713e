"""Measures a real robot through an unreliable network: stopping and path errors.

usage: python benchmarks/real_robot.py [CUTS] [PATH_SECONDS]

The robot is a ur5 (125 Hz) that tool0's own UR controller simulates in another process.
"""

from __future__ import annotations

import random
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/rigs"))

from real_robot_rig import RealRobotRig, real_robot
from waits import until

from tool0.errors import ControlError
from tool0.protocol.control_box_state import ProgramState

JOINT = "shoulder_pan_joint"
LEVER = 0.5
"""Approximate distance of the tool from the joint's axis [m]."""
SETTLING = 5.0
"""Time in which tool0 measures the delay of the network [wall s]."""
STILL = 0.01
"""Speed below which a joint is at rest [rad/s]."""


def cut_once(
    rig: RealRobotRig, chance: random.Random, *, silent: bool
) -> tuple[float, float]:
    """Return the time from a cut to rest [s], and a later motion [rad].

    The motion is the largest motion after the connection is restored.
    """
    speed = chance.uniform(0.005, 0.25) / LEVER  # [rad/s]
    here = rig.robot.joint_state.position[JOINT]
    to = here + (0.8 if here < 0.0 else -0.8)
    controller = rig.robot.controller("scaled_joint_trajectory_controller")
    controller.move({JOINT: to}, duration=abs(to - here) / speed)
    with rig.twin() as twin:
        states = twin.subscribe(rate=125)
        until(
            lambda: abs(twin.joint_state.velocity[JOINT]) > 0.3 * speed,
            lambda: f"motion at {speed:.3f} rad/s ({rig.state.motion_failure})",
        )
        wait = chance.uniform(0.0, 0.5)
        end = time.monotonic() + wait
        while time.monotonic() < end:
            states.next(1.0)
        before = twin.snapshot.time
        if silent:
            rig.proxy.hold()
        else:
            rig.proxy.cut()
        rest = None
        for _ in range(125):
            state = states.next(5.0)
            assert state is not None
            index = state.joint_names.index(JOINT)
            if abs(state.velocity[index]) > STILL:
                rest = None
            elif rest is None:
                rest = state.time
        place = twin.joint_state.position[JOINT]
        rig.proxy.mend()
        until(lambda: is_connected(rig), "the link")
        moved = 0.0
        for _ in range(60):
            state = states.next(5.0)
            assert state is not None
            index = state.joint_names.index(JOINT)
            moved = max(moved, abs(state.position[index] - place))
        states.close()
    if rest is None:
        raise AssertionError("the arm did not rest")
    rig.enable()
    return rest - before, moved


def is_connected(rig: RealRobotRig) -> bool:
    link = rig.state.link
    return link is not None and link.is_connected


def path_errors(rig: RealRobotRig, duration: float) -> tuple[float, float, int]:
    """Return the rms and the largest path error [rad], and the number of stops."""
    errors: list[float] = []
    stops = 0
    end = time.monotonic() + duration
    name = "scaled_joint_trajectory_controller"
    ends = (0.6, -0.6)
    k = 0
    while time.monotonic() < end:
        (goal,) = rig.robot.move_joints({JOINT: ends[k % 2]}, speed=0.3)
        k += 1
        while not goal.status.is_terminal:
            try:
                state = rig.robot.controller(name).state
            except ControlError:  # the controller has stopped
                break
            errors.append(max(map(abs, state.error.positions)))
            time.sleep(0.02)
        if rig.state.program is not ProgramState.PLAYING:
            stops += 1
            print("   stopped:", rig.state.motion_failure)
            if not (rig.state.link and rig.state.link.is_enabled):
                until(lambda: is_connected(rig), "the link")
                rig.enable()
            else:
                rig.box.play()
    rms = (sum(e * e for e in errors) / len(errors)) ** 0.5
    return rms, max(errors), stops


def main() -> None:
    cuts = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
    chance = random.Random(1)
    with real_robot() as rig:
        rig.enable()
        for what, jitter, loss in (("none", 0.0, 0.0), ("0-40 ms, 1 %", 0.04, 0.01)):
            rig.proxy.jitter, rig.proxy.loss = jitter, loss
            time.sleep(SETTLING)
            rig.robot.move_joints({JOINT: -0.6}, speed=0.3)[0].wait()
            rms, most, stops = path_errors(rig, seconds)
            print(
                f"jitter {what}: rms {1e3 * rms:.2f}, most {1e3 * most:.2f} mrad, "
                f"{stops} stops in {seconds:g} s"
            )
        rig.proxy.jitter = rig.proxy.loss = 0.0
        for what, silent in (("cable pulled", True), ("connections reset", False)):
            found = [cut_once(rig, chance, silent=silent) for _ in range(cuts)]
            times = sorted(rest for rest, _ in found)
            print(
                f"{what}: rest after {1e3 * times[len(times) // 2]:.0f} ms (median), "
                f"{1e3 * times[-1]:.0f} ms (longest of {cuts}); moved later by "
                f"{1e3 * max(moved for _, moved in found):.2f} mrad"
            )


if __name__ == "__main__":
    main()
