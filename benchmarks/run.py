"""Run every benchmark, and print its result with its bound: ``make bench``."""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from benchmarks import (
    batch,
    cells,
    collect,
    drives,
    gazebo,
    golden,
    grasping,
    grip,
    gym,
    kinematics,
    page,
    panel,
    panel_cameras,
    planning,
    process,
    recording,
    rest,
    robosuite,
    ros1,
    ros2,
    stop_under_flood,
    streams,
    tick,
    ur,
)
from tool0.description.catalogue import arms, grippers
from tool0.installation.gazebo.status import gazebo_status
from tool0.installation.ros1.packages import ros1_status
from tool0.installation.ros2.installation import find_ros2

N_HANDOVERS = 20
N_PLANS = 20
"""Number of problems of each set.  ``benchmarks/planning.py`` uses 100."""


@dataclass(frozen=True)
class Figure:
    """A measured value, with its bound and its aim."""

    name: str
    value: float
    bound: float
    aim: float

    @property
    def holds(self) -> bool:
        """Whether the bound is kept.

        If the aim is greater than the bound, the value must not be less than the bound.
        If the aim is smaller than the bound, the value must not be greater than the
        bound.
        """
        if self.aim >= self.bound:
            return self.value >= self.bound
        return self.value <= self.bound

    def __str__(self) -> str:
        verdict = "ok" if self.holds else "MISSED"
        numbers = f"{self.value:>10.3g} {self.bound:>10.3g} {self.aim:>10.3g}"
        return f"{self.name:<58} {numbers}  {verdict}"


def figures() -> Iterator[Figure]:
    """Measure the figures one after another."""
    yield from _speed_figures()
    many = batch.cost()
    name = f"batch of {batch.N_COPIES} on {batch.THREADS} threads: steps/s ÷ raw"
    yield Figure(name, many.ratio, 0.85, 0.95)
    same = many.same_threads
    yield Figure("the same ÷ raw on as many threads at once", same, 0.85, 0.95)
    yield Figure("the same, with actions and arrays", many.with_actions, 0.75, 0.9)
    yield Figure("memory of a copy [MB]", many.bytes_per_copy / 1e6, 2.0, 1.0)
    learning = gym.cost()
    name = f"Lift, {gym.N_COPIES} copies on {gym.THREADS} threads: steps/s ÷ raw"
    yield Figure(name, learning.ratio, 0.7, 0.85)
    same = learning.same_threads
    yield Figure("the same ÷ raw on as many threads at once", same, 0.7, 0.85)
    ratio = collect.speed_ratio()
    yield Figure("collect with 2 workers ÷ 1 worker", ratio, 1.8, 1.95)
    eight = f"{cells.N_ROBOTS} robots"
    yield Figure(f"{eight}: start-up ÷ that of one", cells.start_ratio(), 5.0, 2.5)
    yield from _planning_figures()
    for name in golden.SCENARIOS:
        worst = golden.compare(name, "mujoco").worst
        yield Figure(f"difference from {name} [mrad]", 1e3 * worst, 10.0, 3.0)
    yield Figure(
        "start to end of a bring-up ÷ import mujoco", process.start_ratio(), 3.0, 2.0
    )
    yield Figure("import tool0 ÷ import mujoco", process.import_ratio(), 0.2, 0.1)
    yield Figure("resident memory, headless [MB]", process.memory(), 100.0, 80.0)
    trips = [kinematics.round_trip(arm) for arm in arms()]
    name = f"inverse kinematics, {len(trips)} arms x {kinematics.N_POSES} poses"
    n_missed = sum(trip.n_missed for trip in trips)
    yield Figure(f"{name}: missed", n_missed, 0.5, 0.0)
    worst = max(trip.worst for trip in trips)
    yield Figure(f"{name}: error [m]", worst, 1e-9, 1e-13)
    for name, opening in rest.OPENINGS.items():
        velocity = rest.rms_velocity(opening, "mujoco")
        yield Figure(f"gripper at rest, {name}: rms [rad/s]", velocity, 1e-4, 1e-6)
    yield from _grasp_figures("mujoco", n_picks=50)
    held = grasping.two_kilograms()
    yield Figure("mujoco: slip of 2 kg held at 235 N, linkage [mm]", held, 0.1, 0.05)
    yield from _drive_figures()
    yield from _panel_figures()
    for readers, rate in ((1, 125.0), (5, 125.0), (1, 500.0), (5, 500.0)):
        ratio = streams.tick_cost_ratio(readers, rate)
        name = f"tick's CPU, {readers} readers at {rate:g} Hz ÷ none"
        yield Figure(name, ratio, 1.3, 1.05)
    yield from _stop_figures()
    share, rate = recording.recording_cost()
    yield Figure("recording: processor time [% of a core]", 100.0 * share, 5.0, 4.0)
    yield Figure("recording: data [kB/s]", rate / 1000.0, 300.0, 150.0)
    if (why := ros1_status().why_not(["rospy", "roscore"])) is None:
        yield from _ros1_figures()
    else:
        print(f"no ROS 1 can run here, so none is measured: {why}")
    if find_ros2() is not None:
        yield from _ros2_figures()
    else:
        print("no ROS 2 can run here, so none is measured")
    if importlib.util.find_spec("rtde_control") is not None:
        yield from _ur_figures()
    else:
        print("ur_rtde is not installed, so the UR interface is not measured")
    found = gazebo_status()
    if found.can_run:
        yield from _gazebo_figures()
    else:
        print(
            f"no Gazebo can run here, so none is measured: {'; '.join(found.missing)}"
        )


def _speed_figures() -> Iterator[Figure]:
    for moving in (False, True):
        state = "moving" if moving else "holding"
        name = f"steps/s ÷ raw mj_step, {state}"
        yield Figure(name, tick.speed_ratio(moving=moving), 0.75, 0.85)
        ratio = tick.speed_ratio(moving=moving, scene="table_and_cubes")
        yield Figure(f"{name}, table and cubes", ratio, 0.75, 0.85)
        for robots in (cells.TWO, cells.ROBOTS):
            ratio = cells.speed_ratio(robots, moving=moving)
            yield Figure(f"{name}, {len(robots)} robots", ratio, 0.75, 0.85)
    yield Figure("steps/s ÷ the original's", tick.speed_against_original(), 20.0, 25.0)
    try:
        ratios = robosuite.speed_ratios()
    except robosuite.UnavailableError as why:
        print(f"no robosuite can run here, so it is not measured: {why}")
    else:
        for controller, ratio in ratios.items():
            yield Figure(f"steps/s ÷ robosuite's, {controller}", ratio, 7.0, 9.0)


def _grasp_figures(engine: str, n_picks: int) -> Iterator[Figure]:
    force, speed = grip.force_error(engine), grip.speed_error(engine)
    yield Figure(f"{engine}: worst error of a grip's force [%]", 1e2 * force, 10.0, 2.0)
    yield Figure(f"{engine}: worst error of its speed [%]", 1e2 * speed, 10.0, 2.0)
    delay = grip.detection_delay(engine)
    yield Figure(f"{engine}: from contact to knowing it [s]", delay, 0.2, 0.15)
    for gripper in grippers():
        trials = grasping.all_trials(engine, gripper)
        name = f"{engine}: {gripper}"
        yield Figure(f"{name}: things shaken at 2 g, dropped", trials.dropped, 0, 0)
        yield Figure(f"{name}: worst slip in 5 s [mm]", 1e3 * trials.slip, 0.1, 0.05)
        shaken = 1e3 * trials.shaken
        yield Figure(f"{name}: worst slip, shaken for 3 s [mm]", shaken, 5.0, 1.0)
    for arm, gripper in grasping.PICKERS:
        report = grasping.picks(engine, n_picks, 1, arm, gripper)
        name = f"{engine}: {arm} + {gripper}: of {n_picks} picks succeed"
        bound = math.floor(0.98 * n_picks) if engine == "mujoco" else n_picks
        yield Figure(name, report.n_succeeded, bound, n_picks)
    report = grasping.handovers(engine, N_HANDOVERS, seed=1)
    name = f"{engine}: of {N_HANDOVERS} handovers succeed"
    yield Figure(name, report.n_succeeded, N_HANDOVERS - 1, N_HANDOVERS)


def _planning_figures() -> Iterator[Figure]:
    for each in planning.reports(N_PLANS):
        name = f"plans, {each.name}"
        yield Figure(f"{name}: solved within 2 s [%]", 100.0 * each.share, 99.0, 100.0)
        yield Figure(f"{name}: median time [ms]", 1e3 * each.time(0.5), 50.0, 20.0)
        yield Figure(f"{name}: p95 [ms]", 1e3 * each.time(0.95), 500.0, 150.0)
        yield Figure(f"{name}: length ÷ best of 20", each.ratio, 1.25, 1.1)
        yield Figure(f"{name}: poses too near", each.violations, 0, 0)
    share = planning.twelve_joints(N_PLANS)
    yield Figure(
        "plans of two crossing arms within 5 s [%]", 100.0 * share, 95.0, 100.0
    )
    _, contacts = planning.executed(N_PLANS)
    yield Figure("plans executed, empty and with a cube: contacts", contacts, 0, 0)


def _drive_figures() -> Iterator[Figure]:
    rows = list(drives.rows())
    for row in rows:
        print(row)
    radius = max(max(row.free, row.loaded) for row in rows)
    yield Figure(f"spectral radius of {len(rows)} robots", radius, 1.0, 0.999)
    drift = max(row.drift for row in rows)
    yield Figure("their drift from home in 10 s [mrad]", 1e3 * drift, 20.0, 10.0)
    moved = [row.motions for row in rows if row.has_derived_gains]
    path = max(motions.path for motions in moved)
    yield Figure("derived gains, rated payload: path [mrad]", 1e3 * path, 50.0, 20.0)
    final = max(motions.final for motions in moved)
    yield Figure("derived gains, rated payload: final [mrad]", 1e3 * final, 2.0, 1.0)


def _gazebo_figures() -> Iterator[Figure]:
    cost = gazebo.steps()
    native = f"the {1e6 * cost.native:.0f} in C++"
    yield Figure(f"Gazebo: µs/step above {native}", 1e6 * cost.lock_step, 35.0, 20.0)
    exchange = 1e6 * cost.exchange
    yield Figure("Gazebo: of those, the exchange without a tick", exchange, 25.0, 10.0)
    for name, seconds in (("holding", cost.holding), ("moving", cost.moving)):
        ratio = 1.0 / seconds / gazebo.ORIGINAL_STEPS
        yield Figure(f"Gazebo: steps/s ÷ the original's, {name}", ratio, 1.0, 2.0)
    start = gazebo.start_seconds() / gazebo.ORIGINAL_START
    yield Figure("Gazebo: start to end of a bring-up ÷ the original's", start, 1.0, 0.5)
    for name in golden.SCENARIOS:
        ours, theirs = (golden.compare(name, e) for e in ("gazebo", "mujoco"))
        yield Figure(f"Gazebo: from {name} [mrad]", 1e3 * ours.worst, 10.0, 3.0)
        beside = 1e3 * ours.worst_beside(theirs)
        yield Figure(f"Gazebo: from MuJoCo, {name} [mrad]", beside, 10.0, 3.0)
    for name, opening in rest.OPENINGS.items():
        velocity = rest.rms_velocity(opening, "gazebo")
        yield Figure(
            f"Gazebo: gripper at rest, {name}: rms [rad/s]", velocity, 1e-3, 1e-4
        )
    yield from _grasp_figures("gazebo", n_picks=10)
    mimic = rest.mimic_error("gazebo")
    yield Figure("Gazebo: mimic error at 0.8 rad/s [rad]", mimic.moving, 3e-4, 1e-4)
    yield Figure("Gazebo: mimic error at rest [rad]", mimic.at_rest, 1e-5, 1e-6)


def _stop_figures() -> Iterator[Figure]:
    """Measure how much floods delay the reply to a stop."""
    for name, measure in stop_under_flood.MEASURED.items():
        if "ROS 2" in name and find_ros2() is None:
            continue
        for load, delays in measure().items():
            title = f"stop by {name} ({load}) ÷ none, p99"
            yield Figure(title, delays.p99, 3.0, 1.5)


def _ros1_figures() -> Iterator[Figure]:
    delay = ros1.latency()
    yield Figure("ROS 1: command → effort, p50 [ms]", 1e3 * delay.p50, 5.0, 1.5)
    yield Figure("ROS 1: command → effort, p99 [ms]", 1e3 * delay.p99, 50.0, 10.0)
    ratio = delay.p50 / delay.plain_p50
    yield Figure("ROS 1: command → effort ÷ rospy alone, p50", ratio, 5.0, 2.0)


def _ros2_figures() -> Iterator[Figure]:
    states = ros2.joint_states()
    error = abs(states.rate - ros2.RATE)
    yield Figure("ROS 2: /joint_states at 500 Hz: error of the rate", error, 1.0, 0.1)
    yield Figure("ROS 2: their age at a subscriber, p50 [ms]", 1e3 * states.p50, 2, 0.5)
    yield Figure("ROS 2: their age at a subscriber, p99 [ms]", 1e3 * states.p99, 3, 1.5)
    for realtime, name in ((True, "in real time"), (False, "as fast as possible")):
        ratio = ros2.speed_ratio(realtime=realtime)
        yield Figure(f"ROS 2: steps/s with the node ÷ without, {name}", ratio, 0.97, 1)
    delay = ros2.latency()
    yield Figure("ROS 2: command → effort, p50 [ms]", 1e3 * delay.p50, 5.0, 2.0)
    yield Figure("ROS 2: command → effort, p99 [ms]", 1e3 * delay.p99, 50.0, 10.0)
    start = ros2.start_seconds()
    yield Figure("ROS 2: bring-up until all controllers are active [s]", start, 5, 2.5)


def _ur_figures() -> Iterator[Figure]:
    samples = ur.samples()
    share = 100.0 * samples.in_time
    yield Figure("UR: RTDE samples at 500 Hz at most 1 ms late [%]", share, 99.0, 99.9)
    yield Figure("UR: their age at a client, p50 [ms]", 1e3 * samples.p50, 1.0, 0.4)
    ratio = ur.speed_ratio()
    yield Figure("UR: steps/s with it and a client ÷ without", ratio, 0.95, 1.0)
    delay = ur.latency()
    yield Figure("UR: servoJ target → effort, p50 [ms]", 1e3 * delay.p50, 2.0, 1.0)
    yield Figure("UR: servoJ target → effort, p99 [ms]", 1e3 * delay.p99, 4.0, 2.0)
    connecting = ur.connecting()
    yield Figure("UR: connecting RTDEReceive [s]", connecting.receive, 0.5, 0.1)
    yield Figure("UR: connecting RTDEControl [s]", connecting.control, 1.0, 0.3)


def _panel_figures() -> Iterator[Figure]:
    costs = panel.costs()
    alone = costs.pop(panel.ALONE)
    yield Figure("ticks late per 10 s, panel without pages", alone.overruns, 1e4, 0.0)
    for name, cost in costs.items():
        more = cost.overruns - alone.overruns
        yield Figure(f"more ticks late per 10 s, {name}", more, 200.0, 20.0)
        processor = 100.0 * (cost.cpu - alone.cpu)
        yield Figure(f"more of a processor [%], {name}", processor, 25.0, 10.0)
    rate = costs[panel.FEW].bytes_per_second / 1e3
    yield Figure("sent to a page [kB/s]", rate, 100.0, 50.0)
    images = panel_cameras.rates()
    yield Figure("camera images to a page [1/s]", images.images, 10.0, 25.0)
    share = images.images / images.capacity
    yield Figure("the same, of what can be rendered", share, 0.5, 0.8)
    more = images.late_with - images.late_without
    yield Figure("more ticks late per 10 s, 1 camera", more, 2000.0, 200.0)
    if page.chromium() is None:
        print("no Chromium is installed, so the page is not measured")
        return
    found = page.page_figures()
    yield Figure("page: controls can be used after [s]", found.controls, 1.0, 0.5)
    yield Figure("page: scene is complete after [s]", found.scene, 2.0, 1.0)
    yield Figure("page: frames/s, simple mode, software GL", found.rate, 20.0, 30.0)


def main() -> int:
    """Print a table, and return 1 if a bound was missed."""
    print(f"{'figure':<58} {'measured':>10} {'bound':>10} {'aim':>10}")
    missed = 0
    for figure in figures():
        print(figure, flush=True)
        missed += not figure.holds
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
