"""From options to a robot at its initial pose with its controllers running."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from tool0.control.config import ControllerConfig
from tool0.control.lint import lint
from tool0.control.manager import ControllerManager, Strictness
from tool0.description.camera import default_cameras, merged
from tool0.description.forward_kinematics import joint_positions
from tool0.description.model import RobotModel
from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.description.scene_file import load_scene
from tool0.engines.registry import make_engine
from tool0.errors import ConfigError, ControlError
from tool0.hardware.engine import Engine
from tool0.hardware.robot_hardware import RobotHardware
from tool0.runtime.bus import Bus
from tool0.runtime.config import ControlConfig, SimulationConfig
from tool0.runtime.controllers import choose_controllers
from tool0.runtime.core import Core
from tool0.runtime.loop import Loop
from tool0.runtime.poses import PoseBook
from tool0.runtime.simulation import Simulation


def start_simulation(
    description: RobotDescription, control: ControlConfig, simulation: SimulationConfig
) -> Simulation:
    """Return a running simulation: the robot holds its pose.

    Raises:
        Tool0Error: If an option or a file is wrong.
    """
    model = description.model
    cell = description.cell
    scene = simulation.scene or (cell and cell.scene) or Scene()
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    scene.check_beside(model)
    cameras = merged(default_cameras(model), scene.cameras, simulation.cameras)
    for camera in cameras.values():
        camera.check_on(model)
    config, started, stopped, findings = choose_controllers(description, control)
    poses = PoseBook(description)
    position = _initial_position(model, poses, control.initial_pose)
    engine = make_engine(
        simulation.engine,
        description,
        dt=simulation.dt,
        spawn_z=simulation.spawn_z,
        scene=scene,
        options=simulation.engine_options,
    )
    try:
        hardware, manager = _hardware(model, engine, config)
        core = Core(
            model=model,
            engine=engine,
            hardware=hardware,
            manager=manager,
            initial_position=position,
            scene=scene,
            control_period=control.control_period,
            grasp_assist=simulation.grasp_assist,
        )
        for name in (*started, *stopped):
            manager.load(name)
        manager.switch(started, (), Strictness.STRICT, core.state)
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
    return Simulation(
        description=description,
        core=core,
        loop=loop,
        bus=bus,
        poses=poses,
        defined_controllers=config.types,
        parameters=config.parameters(),
        spawn_z=simulation.spawn_z,
        cameras=cameras,
        ground=engine.world.ground,
        warnings=(
            *findings,
            *lint(config, [joint.name for joint in model.movable_joints]),
        ),
    )


def _initial_position(
    model: RobotModel, poses: PoseBook, pose: str | Mapping[str, float] | None
) -> list[float]:
    """Return every movable joint's position, in the order of the model."""
    try:
        given = poses.find(pose).positions if isinstance(pose, str) else pose or {}
    except ControlError as error:
        raise ConfigError(str(error)) from None
    zeros = [0.0] * len(model.movable_joints)
    return joint_positions(model, {**poses.start(), **given}, zeros)


def _hardware(
    model: RobotModel, engine: Engine, config: ControllerConfig
) -> tuple[RobotHardware, ControllerManager]:
    """Return the robot's hardware and its controllers, with the limits of the YAML."""
    overrides = {
        name: replace(model.joint(name).limits, **limits)
        for name, limits in config.joint_limits().items()
    }
    hardware = RobotHardware(
        model, engine.joint_names, engine.dt, overrides, engine.world.gravity
    )
    joints = {
        name: replace(joint, limits=hardware.limits.get(name, joint.limits))
        for name, joint in model.joint_by_name.items()
    }
    return hardware, ControllerManager(hardware, config, joints)
