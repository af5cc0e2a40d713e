"""Bring-up of a simulated or real robot from options."""

from __future__ import annotations

from tool0.description.camera import default_cameras, merged
from tool0.description.forward_kinematics import joint_positions
from tool0.description.robot import RobotDescription
from tool0.hardware.own_drives import OwnDrives
from tool0.protocol.bus import Bus
from tool0.sensing.collisions import CollisionFinder
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.executor import Executor
from tool0.simulation.loop import Loop
from tool0.simulation.setup import Setup
from tool0.simulation.simulation import Simulation


def start_simulation(
    description: RobotDescription, control: ControlConfig, simulation: SimulationConfig
) -> Simulation:
    """Return a running simulation in which the robot holds its pose.

    Raises:
        Tool0Error: If an option or a file is invalid.
    """
    model = description.model
    setup = Setup.of(description, control, simulation)
    cameras = merged(default_cameras(model), setup.scene.cameras, simulation.cameras)
    for camera in cameras.values():
        camera.check_on(model)
    engine = setup.make_engine()
    collisions = CollisionFinder(model, engine.world.ground)
    try:
        is_real = isinstance(engine, OwnDrives)
        if not simulation.allow_penetration and not is_real:
            _require_pose(collisions, setup)
        executor = Executor(setup.make_core(engine))
        bus = Bus()
        loop = Loop(
            executor,
            bus,
            paused=simulation.paused,
            speed=simulation.speed if simulation.realtime else None,
        )
    except BaseException:
        engine.close()
        raise
    return Simulation(
        setup=setup,
        executor=executor,
        loop=loop,
        bus=bus,
        cameras=cameras,
        ground=engine.world.ground,
        collisions=collisions,
        warnings=(
            *setup.scene.far_objects(model),
            *setup.choice.findings,
            *setup.choice.config.lint([joint.name for joint in model.movable_joints]),
        ),
    )


def _require_pose(collisions: CollisionFinder, setup: Setup) -> None:
    """Raise PenetrationError if the initial pose causes impermissible contacts.

    A default pose, which the user did not specify, is accepted if the robot does not
    touch an object in this pose.  A default pose is defined by the description, and the
    engine issues a warning about penetrations in the pose.
    """
    model, cell, objects = (
        setup.description.model,
        setup.description.cell,
        setup.scene.objects,
    )
    given = setup.control.initial_pose is not None or (
        cell is not None and any(robot.initial_pose for robot in cell.robots)
    )
    if not given and not objects:
        return
    zeros = {
        joint.name: joint.limits.clamp(0.0)
        for joint in model.movable_joints
        if joint.mimic is None
    }
    usual = joint_positions(model, zeros, [0.0] * len(model.movable_joints))
    position = setup.position
    collisions.require_pose(position, usual if given else position, objects)
