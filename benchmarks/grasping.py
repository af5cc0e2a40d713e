"""Measures how firmly objects are held, and how many picks succeed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import tool0
from tool0.cli.demos.hand import PickOptions, TaskFailure
from tool0.cli.demos.monitor import GraspMonitor
from tool0.cli.demos.picker import Picker
from tool0.cli.demos.setup import Cube, Demo, handover_demo, pick_demo
from tool0.cli.demos.trials import DemoReport
from tool0.description.grasp_frames import pad_links
from tool0.kinematics.chain import find_chains
from tool0.scene import Box, Cylinder, Pose, Scene, SceneObject

Shape = Box | Cylinder

CUBES = {"2f85": (20, 45, 60, 80), "2f140": (20, 60, 90, 120), "hande": (10, 20, 45)}
"""Edge lengths of cubes for each gripper, over the gripper's range [mm]."""
CYLINDER = Cylinder(radius=0.0215, length=0.08)
MASSES = (0.05, 0.5)  # [kg]
FORCE = 60.0
"""Force at each pad [N].  This force is the smallest force of a Hand-E, and a quarter
of the largest force of a 2F-85."""
LIFT = 0.2
HOLD, SHAKE = 5.0, 3.0  # [s]
SHAKEN = 2.0 * 9.81  # [m/s²]
FREQUENCY = 5.0  # [Hz]
AMPLITUDE = 0.072
"""Amplitude of wrist_1 [rad].  With this amplitude, the pads reach an acceleration of 2
g."""
TOP = -0.02
"""Height of the table's top [m]."""
PLACE = (0.45, -0.12)
ITEM = "thing"


@dataclass(frozen=True)
class Held:
    """Result of holding an object that was gripped."""

    failure: str | None
    """Reason why the object is no longer held; None if it is held."""
    slip: float = math.nan
    """Motion between the pads while the object was held without moving the arm [m]."""
    shaken: float = math.nan
    """Motion between the pads while the object was shaken [m]."""
    acceleration: float = math.nan
    """Acceleration of the pads at its peaks while the object was shaken [m/s²]."""


def hold_and_shake(
    engine: str,
    shape: Shape,
    mass: float,
    *,
    force: float = FORCE,
    shake: float = SHAKE,
    description: tool0.DescriptionConfig = tool0.DescriptionConfig(),
) -> Held:
    """Lift an object from the table, hold it at rest, and shake it.

    Args:
        engine: Name of the physics engine.
        shape: Shape of the object.
        mass: Mass of the object [kg].
        force: Force at each pad [N].
        shake: Duration of shaking [s].  At 0, the object is not shaken.
        description: Options of the robot.
    """
    scene = _table_with(shape, mass)
    with tool0.bringup(
        description=description, engine=engine, scene=scene, realtime=False
    ) as robot:
        monitor = GraspMonitor(robot, ITEM)
        picker = Picker(robot, ITEM, PickOptions(force=force, lift=LIFT), monitor)
        try:
            picker.take()
            slip = _slip(monitor, picker, HOLD)
            if not shake:
                return Held(None, slip)
            accelerations: list[float] = []
            shaken = _shake(robot, monitor, picker, shake, accelerations)
        except TaskFailure as failure:
            return Held(f"{monitor.phase}: {failure}")
        return Held(None, slip, shaken, float(np.quantile(accelerations, 0.9)))


@dataclass(frozen=True)
class Trials:
    """Results of all trials with one engine.

    The slips are the largest slips of all trials.
    """

    dropped: int
    slip: float
    """Largest slip of an object that is held at rest [m]."""
    shaken: float
    """Largest slip of an object that is shaken [m]."""


def all_trials(engine: str, gripper: str = "2f85") -> Trials:
    """Lift, hold and shake each object of ``trials``.

    Raises:
        RuntimeError: If an object was shaken with less than the required acceleration.
    """
    description = tool0.DescriptionConfig(gripper=gripper)
    held = [
        hold_and_shake(engine, shape, mass, description=description)
        for _, shape, mass in trials(gripper)
    ]
    kept = [item for item in held if item.failure is None]
    weakest = min(item.acceleration for item in kept)
    if weakest < SHAKEN:
        raise RuntimeError(f"shaken at {weakest:.1f} m/s², not at {SHAKEN:.1f}")
    return Trials(
        dropped=len(held) - len(kept),
        slip=max(item.slip for item in kept),
        shaken=max(item.shaken for item in kept),
    )


def two_kilograms() -> float:
    """Return the slip of 2 kg that a linkage gripper holds with full force [mm]."""
    block = Box(size=(0.045, 0.045, 0.06))
    linkage = tool0.DescriptionConfig(gripper_model="linkage")
    held = hold_and_shake(
        "mujoco", block, 2.0, force=235.0, shake=0.0, description=linkage
    )
    return 1e3 * held.slip if held.failure is None else math.inf


PICKERS = (
    ("ur5", "2f85"),
    ("ur3e", "hande"),
    ("ur5e", "2f140"),
    ("ur10e", "hande"),
    ("ur20", "2f140"),
)
"""Pairs of an arm and a gripper."""
GIVER, TAKER = "ur5+2f85", "ur10e+hande"


def picks(
    engine: str, n_picks: int, seed: int, arm: str = "ur5", gripper: str = "2f85"
) -> DemoReport:
    """Pick a cube from random poses on the table, and place it in the bin."""
    description = tool0.DescriptionConfig(arm=arm, gripper=gripper)
    return _played(pick_demo(Cube(), PickOptions(), description), engine, n_picks, seed)


def handovers(engine: str, n: int, seed: int) -> DemoReport:
    """Hand a cube over between two arms, from random poses on the table."""
    return _played(handover_demo(Cube(), PickOptions(), GIVER, TAKER), engine, n, seed)


def _played(demo: Demo, engine: str, n: int, seed: int) -> DemoReport:
    with tool0.bringup(
        description=demo.description, engine=engine, scene=demo.scene, realtime=False
    ) as robot:
        return demo.play(robot, n, seed=seed)


def trials(gripper: str = "2f85") -> Iterator[tuple[str, Shape, float]]:
    """Yield a name, a shape and a mass [kg] for each trial of a gripper."""
    shapes: dict[str, Shape] = {
        **{f"{mm} mm cube": Box(size=(mm / 1e3,) * 3) for mm in CUBES[gripper]},
        "43 mm cylinder": CYLINDER,
    }
    for (name, shape), mass in itertools.product(shapes.items(), MASSES):
        yield f"{name}, {mass:g} kg", shape, mass


def _table_with(shape: Shape, mass: float) -> Scene:
    height = shape.size[2] if isinstance(shape, Box) else shape.length
    return Scene(
        (
            SceneObject(
                name="table",
                geometry=Box(size=(0.5, 0.8, 0.08)),
                pose=Pose(xyz=(0.6, 0.0, TOP - 0.04)),
            ),
            SceneObject(
                name=ITEM,
                geometry=shape,
                mass=mass,
                pose=Pose(xyz=(*PLACE, TOP + height / 2.0)),
            ),
        )
    )


def _slip(monitor: GraspMonitor, picker: Picker, duration: float) -> float:
    """Hold the object for a simulated ``duration`` [s], and return its slip [m]."""
    monitor.begin("holding")
    monitor.wait(0.5)  # the arm comes to rest
    monitor.start_slip(picker.hand.gripper)
    monitor.wait(duration)
    picker.hand.check_hold()
    assert monitor.slip is not None
    return monitor.slip


def _shake(
    robot: tool0.Robot,
    monitor: GraspMonitor,
    picker: Picker,
    duration: float,
    accelerations: list[float],
) -> float:
    """Swing a wrist, and return the slip of the object between the pads [m].

    The acceleration of the pads in each millisecond is appended to ``accelerations``
    [m/s²].
    """
    monitor.begin("shaking")
    monitor.start_slip(picker.hand.gripper)
    pad_link, _ = pad_links(robot.description.model, robot.gripper.geometry)
    pad = robot.pose(pad_link, "tool0")  # the fingers do not move
    arm = robot.controller("eff_joint_traj_controller")
    names = robot.arm.joint_names
    start = dict(robot.arm.joints)
    wrist = names[3]
    times = np.arange(1, round(250 * duration) + 1) / 250.0
    swing = np.minimum(1.0, np.minimum(times, duration - times) * FREQUENCY / 2.0)
    angles = start[wrist] + AMPLITUDE * swing * np.sin(2 * np.pi * FREQUENCY * times)
    goal = arm.follow(
        [
            tool0.TrajectoryPoint(
                [angle if name == wrist else start[name] for name in names],
                time_from_start=time,
            )
            for time, angle in zip(times.tolist(), angles.tolist(), strict=True)
        ],
        joint_names=names,
    )
    (chain,) = find_chains(robot.description.model).values()
    columns = [robot.engine.joint_names.index(name) for name in chain.joint_names]
    rows = []
    while not goal.status.is_terminal:
        robot.run(robot.control_period)
        position = robot.engine.read().position
        rows.append([position[column] for column in columns])
    T_base_tool0 = chain.forward(np.array(rows)).T_base_tip
    places = T_base_tool0[:, :3] @ (*pad.position, 1.0)
    velocity = np.diff(places, axis=0) / robot.control_period
    steps = np.diff(velocity, axis=0) / robot.control_period
    accelerations.extend(np.linalg.norm(steps, axis=1).tolist())
    monitor.wait(0.5)
    picker.hand.check_hold()
    assert monitor.slip is not None
    return monitor.slip
