"""From options to a robot at its initial pose with its controllers running."""

from __future__ import annotations

from tool0.description.camera import default_cameras, merged
from tool0.description.forward_kinematics import joint_positions
from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.engines.registry import make_engine
from tool0.protocol.bus import Bus
from tool0.sensing.collisions import CollisionFinder
from tool0.simulation.assembly import Assembly, Setup, chosen_scene
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.loop import Loop
from tool0.simulation.simulation import Simulation


def start_simulation(
    description: RobotDescription, control: ControlConfig, simulation: SimulationConfig
) -> Simulation:
    """Return a running simulation: the robot holds its pose.

    Raises:
        Tool0Error: If an option or a file is wrong.
    """
    model = description.model
    scene = chosen_scene(description, simulation.scene)
    cameras = merged(default_cameras(model), scene.cameras, simulation.cameras)
    for camera in cameras.values():
        camera.check_on(model)
    assembly = Assembly.of(description, control)
    engine = make_engine(
        simulation.engine,
        description,
        dt=simulation.dt,
        spawn_z=simulation.spawn_z,
        scene=scene,
        options=simulation.engine_options,
    )
    collisions = CollisionFinder(model, engine.world.ground)
    try:
        if not simulation.allow_penetration:
            _require_pose(collisions, assembly, scene)
        core = assembly.core(engine, scene, grasp_assist=simulation.grasp_assist)
        bus = Bus()
        loop = Loop(
            core,
            bus,
            paused=simulation.paused,
            speed=simulation.speed if simulation.realtime else None,
        )
    except BaseException:
        engine.close()
        raise
    config = assembly.choice.config
    return Simulation(
        setup=Setup(assembly=assembly, options=simulation, scene=scene),
        core=core,
        loop=loop,
        bus=bus,
        cameras=cameras,
        ground=engine.world.ground,
        collisions=collisions,
        warnings=(
            *assembly.choice.findings,
            *config.lint([joint.name for joint in model.movable_joints]),
        ),
    )


def _require_pose(
    collisions: CollisionFinder, assembly: Assembly, scene: Scene
) -> None:
    """Raise PenetrationError if the initial pose cannot be.

    A pose that nobody gave is accepted where it meets no object: it is that of a
    description, of which the engine warns.
    """
    description = assembly.description
    model, cell = description.model, description.cell
    given = assembly.control.initial_pose is not None or (
        cell is not None and any(robot.initial_pose for robot in cell.robots)
    )
    if not given and not scene.objects:
        return
    zeros = {
        joint.name: joint.limits.clamp(0.0)
        for joint in model.movable_joints
        if joint.mimic is None
    }
    usual = joint_positions(model, zeros, [0.0] * len(model.movable_joints))
    position = assembly.position
    collisions.require_pose(position, usual if given else position, scene.objects)
