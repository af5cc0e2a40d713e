"""Measures the stability and accuracy of the built-in controllers for all robots."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import tool0
from tool0.control.default_controllers import controllers_yaml, default_controllers
from tool0.control.parameters import RobotJoints
from tool0.control.ros1.joint_trajectory import JointTrajectorySpec
from tool0.description.bodies import JointDynamics
from tool0.description.catalogue import NO_GRIPPER, arms, grippers
from tool0.description.loading import assemble
from tool0.description.model import Inertial, RobotModel
from tool0.description.robot import RobotDescription
from tool0.protocol.channel import LocalChannel
from tool0.protocol.controllers import Gains
from tool0.simulation.bringup import start_simulation
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.handlers.backend import SimulationBackend

N_POSES = 1500
N_MOVES = 8
SPEED = 0.8
"""Speed of the motions, as a fraction of the joints' largest velocities."""
PERIOD = 0.001  # [s]
SETTLE = 0.5
"""Time from the end of a motion to the measurement of its final error [s]."""
HOLD = 10.0  # [s]
DENSITY = 2700.0
"""Density of the payload, which is a cube [kg/m³]."""
NUDGE = 1e-6
"""Step for the derivative of the gravity loads [rad]."""
RANGES = ((-3.1, 3.1), (-2.9, -0.3), (-2.3, 2.3), (-3.1, 3.1), (-3.1, 3.1), (-3.1, 3.1))
"""Ranges of the joint positions between which motions are executed [rad]."""


@dataclass(frozen=True)
class Tracking:
    """The largest errors of several motions of one robot."""

    path: float
    """Largest error during a motion [rad]."""
    final: float
    """Largest error at the time SETTLE after the end of a motion [rad]."""
    duration: float
    """Duration of the longest motion [s]."""
    n_motions: int


def rated_payload(description: RobotDescription) -> float:
    """Return the rated payload minus the mass of the gripper [kg]."""
    (robot,) = description.robots
    rated = float(robot.arm.load("specifications")["payload"])
    model = description.model
    beyond = model.links_from(f"{robot.prefix}tool0")
    inertials = [model.link(name).inertial for name in beyond]
    return max(rated - sum(item.mass for item in inertials if item), 0.0)


def with_payload(model: RobotModel, mass: float) -> RobotModel:
    """Return the robot with a cube of ``mass`` [kg] around its flange."""
    if mass <= 0.0:
        return model
    moment = mass * (mass / DENSITY) ** (2.0 / 3.0) / 6.0
    cube = Inertial(mass=mass, ixx=moment, iyy=moment, izz=moment)
    links = [
        replace(link, inertial=cube) if link.name == "tool0" else link
        for link in model.links
    ]
    return replace(model, links=tuple(links))


def spectral_radius(
    description: RobotDescription, *, loaded: bool, n_poses: int = N_POSES
) -> float:
    """Return the largest spectral radius of a closed-loop tick in random poses.

    The state consists of the positions, velocities and integrals of the driven joints.
    The system is linearized about rest in a pose, with the derivative of gravity and
    semi-implicit Euler integration.
    """
    model = description.model
    gains = _gains(description)
    if loaded:
        model = with_payload(model, rated_payload(description))
    dynamics = JointDynamics(model)
    names = [joint.name for joint in model.movable_joints]
    driven = [names.index(name) for name in gains]
    p, i, d = (np.diag([getattr(g, k) for g in gains.values()]) for k in "pid")
    n, dt, rng = len(driven), PERIOD, np.random.default_rng(seed=0)
    lower = [max(model.joint(name).limits.lower, -np.pi) for name in gains]
    upper = [min(model.joint(name).limits.upper, np.pi) for name in gains]
    compensated = [
        model.transmission_by_joint[name].gravity_compensation for name in gains
    ]
    eye, zero, worst = np.eye(n), np.zeros((n, n)), 0.0
    for _ in range(n_poses):
        q = np.zeros(len(names))
        q[driven] = rng.uniform(lower, upper)
        inverse = np.linalg.inv(
            dynamics.mass_matrix(q.tolist())[np.ix_(driven, driven)]
        )
        load = np.array(dynamics.static_effort(q.tolist()))[driven]
        slope = np.zeros((n, n))
        for column, joint in enumerate(driven):
            near = q.copy()
            near[joint] += NUDGE
            change = np.array(dynamics.static_effort(near.tolist()))[driven] - load
            slope[:, column] = change / NUDGE
        slope[compensated] = 0.0
        # the order is integral, effort, and step of the engine
        effort = np.hstack([-p - i * dt - slope, -d, i])
        velocity = np.hstack([zero, eye, zero]) + dt * inverse @ effort
        step = np.vstack(
            [
                np.hstack([eye, zero, zero]) + dt * velocity,
                velocity,
                np.hstack([-dt * eye, zero, eye]),
            ]
        )
        # the integral state of a joint without integral gain has the eigenvalue 1 and
        # causes no motion
        kept = np.r_[: 2 * n, 2 * n + np.flatnonzero(np.diag(i))]
        worst = max(worst, np.abs(np.linalg.eigvals(step[np.ix_(kept, kept)])).max())
    return float(worst)


def tracking(description: RobotDescription, *, n_moves: int = N_MOVES) -> Tracking:
    """Move the loaded arm between random postures, and from its stretched posture."""
    rng = np.random.default_rng(seed=1)
    arm = list(_gains(description))[:6]
    lower, upper = np.array(RANGES).T
    stretched = np.array([0.0, -0.05, 0.0, -1.5708, -1.5708, 0.0])
    postures = [stretched, np.array([1.5, -1.5, 0.0, -1.5708, 0.0, 1.0]), stretched]
    postures += list(rng.uniform(lower, upper, size=(20 * n_moves, 6)))
    path = final = duration = 0.0
    done = 0
    for start, end in itertools.pairwise(postures):
        with loaded_robot(description, dict(zip(arm, start, strict=True))) as robot:
            robot.run(2.0)  # the integral compensates the load
            robot.contacts()
            touched = False
            with robot.record(rate=500) as recording:
                goals = robot.move_joints(
                    dict(zip(arm, end.tolist(), strict=True)),
                    speed=SPEED,
                    collision="ignore",
                )
                began = robot.time
                while any(goal.result is None for goal in goals):
                    robot.run(0.01)
                    touched = touched or bool(robot.contacts())
                took = robot.time - began
                robot.run(SETTLE)
            if touched:
                continue  # the arm touched itself
            columns = [recording.joint_names.index(name) for name in arm]
            error = np.abs(recording.desired_position - recording.position)[:, columns]
            path = max(path, float(error.max()))
            final = max(final, float(error[-1].max()))
            duration = max(duration, took)
            done += 1
        if done == n_moves:
            break
    return Tracking(path=path, final=final, duration=duration, n_motions=done)


def drift(description: RobotDescription) -> float:
    """Return the largest deviation from the home pose during HOLD [rad | m]."""
    simulation = SimulationConfig(realtime=False)
    with _robot(description, ControlConfig(), simulation) as robot:
        start = robot.snapshot.positions
        driven = description.model.transmission_by_joint
        worst = 0.0
        while robot.time < HOLD:
            robot.run(0.02)
            now = robot.snapshot.positions
            worst = max(worst, *(abs(now[name] - start[name]) for name in driven))
        if robot.warnings:
            raise RuntimeError(f"{description.title}: {robot.warnings}")
        return worst


def loaded_robot(description: RobotDescription, pose: dict[str, float]) -> tool0.Robot:
    """Return the robot with its rated payload, high above the ground."""
    model = with_payload(description.model, rated_payload(description))
    with TemporaryDirectory() as folder:
        file = Path(folder) / "controllers.yaml"
        file.write_text(controllers_yaml(description), encoding="utf-8")
        return _robot(
            replace(description, model=model),
            ControlConfig(controllers_file=file, initial_pose=pose),
            SimulationConfig(realtime=False, spawn_z=4.0),
        )


def descriptions() -> Iterator[RobotDescription]:
    """Yield every arm with every gripper, and every arm without a gripper."""
    for arm in arms():
        for gripper in (NO_GRIPPER, *grippers()):
            yield assemble(arm, gripper, pedestal_height=0.0)


def _robot(
    description: RobotDescription, control: ControlConfig, simulation: SimulationConfig
) -> tool0.Robot:
    return tool0.Robot(
        LocalChannel(
            SimulationBackend(start_simulation(description, control, simulation))
        )
    )


def _gains(description: RobotDescription) -> dict[str, Gains]:
    """Return the gains of all driven joints, with the arm's joints first."""
    config, model = default_controllers(description), description.model
    interfaces = {item.joint: item.interfaces for item in model.transmissions}
    joints = RobotJoints(model.joint_by_name, interfaces)
    specs = [config.spec(name, joints) for name in config.names]
    return {
        joint: gains
        for spec in specs
        if isinstance(spec, JointTrajectorySpec)
        for joint, gains in zip(spec.joints, spec.gains, strict=True)
    }


@dataclass(frozen=True)
class Row:
    """The measurements of one robot."""

    title: str
    has_derived_gains: bool
    free: float
    """Spectral radius without a payload."""
    loaded: float
    """Spectral radius with the rated payload."""
    drift: float
    """Largest deviation from the home pose [rad | m]."""
    motions: Tracking

    def __str__(self) -> str:
        return (
            f"| {self.title} | {self.free:.4f} | {self.loaded:.4f} | "
            f"{1e3 * self.drift:.1f} | {1e3 * self.motions.path:.1f} | "
            f"{1e3 * self.motions.final:.1f} |"
        )


def rows(only: Collection[str] = ()) -> Iterator[Row]:
    """Yield the measurements of all arms, or of some arms, with every gripper."""
    for description in descriptions():
        (robot,) = description.robots
        if not only or robot.arm.name in only:
            yield Row(
                title=description.title,
                has_derived_gains=not robot.arm.file("gains.yaml").is_file(),
                free=spectral_radius(description, loaded=False),
                loaded=spectral_radius(description, loaded=True),
                drift=drift(description),
                motions=tracking(description),
            )


if __name__ == "__main__":
    for row in rows(sys.argv[1:]):
        print(row, flush=True)
