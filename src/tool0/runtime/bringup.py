"""From options to a robot at its initial pose with its controllers running."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from tool0.control.config import ControllerConfig
from tool0.control.lint import lint
from tool0.control.manager import ControllerManager, Strictness
from tool0.description.camera import default_cameras, merged
from tool0.description.catalogue import (
    RobotDescription,
    default_controllers,
    load_description,
)
from tool0.description.config import (
    UNSET,
    Argument,
    DescriptionConfig,
    File,
    Unset,
)
from tool0.description.model import RobotModel
from tool0.description.positions import joint_positions
from tool0.description.scene import Scene
from tool0.description.scene_file import load_scene
from tool0.errors import (
    ConfigError,
    ControlError,
    EngineUnavailableError,
    nearest_name,
)
from tool0.hardware.engine import Engine
from tool0.hardware.robot_hardware import RobotHardware
from tool0.runtime import commands as ask
from tool0.runtime.bus import Bus
from tool0.runtime.config import ControlConfig, Names, SimulationConfig
from tool0.runtime.core import Core
from tool0.runtime.loop import Loop
from tool0.runtime.mailbox import Mailbox
from tool0.runtime.poses import PoseBook
from tool0.runtime.robot import Robot

DEFAULT_CONTROLLERS = (
    "joint_state_controller",
    "eff_joint_traj_controller",
    "gripper_controller",
)
DEFAULT_STOPPED_CONTROLLERS = ("joint_group_eff_controller",)
"""As in the launch file ``ur5_bringup.launch``; only those that the YAML defines."""
DEFAULT_POSE = "home"
ENGINES = ("mujoco", "gazebo")

Config = TypeVar("Config", DescriptionConfig, ControlConfig, SimulationConfig)


def bringup(
    *,
    arm: str | None = None,
    gripper: str | Unset | None = UNSET,
    prefix: str | None = None,
    robot: File | None = None,
    args: Mapping[str, Argument] | None = None,
    engine: str | None = None,
    scene: Scene | File | None = None,
    controllers_file: File | Sequence[File] | None = None,
    controllers: Names | None = None,
    initial_pose: str | Mapping[str, float] | None = None,
    realtime: bool | None = None,
    speed: float | None = None,
    paused: bool | None = None,
    description: DescriptionConfig = DescriptionConfig(),  # noqa: B008  # frozen
    control: ControlConfig = ControlConfig(),  # noqa: B008  # frozen
    simulation: SimulationConfig = SimulationConfig(),  # noqa: B008  # frozen
) -> Robot:
    """Bring up a robot: its description, physics, drives and controllers.

    ``description``, ``control`` and ``simulation`` hold all options.  The other
    keywords are shorthands for the most used ones; a shorthand that is given (not
    None) replaces the field of the same name::

        cell = SimulationConfig(scene="table_and_bin", grasp_assist=True)
        tool0.bringup(arm="ur5", simulation=cell, realtime=False)

    Args:
        arm: The arm; ur5 if not given.
        gripper: The gripper on tool0; 2f85 if not given, None or "none" for a bare arm.
        prefix: Prefix of all link and joint names.
        robot: Your own URDF or xacro file, instead of an arm and a gripper.
        args: xacro arguments of that file, or further ones of the built-in file.
        engine: The physics engine: "mujoco", or "gazebo" (docs/gazebo.md).
        scene: The objects around the robot: a value, a YAML file, or a built-in scene
            (``table_and_bin``, ``table_and_cubes``).
        controllers_file: ros_control YAML, one file or several; later ones override.
        controllers: Names of the controllers to load and start.
        initial_pose: A named pose, or positions by joint [rad | m].
        realtime: Whether time passes by itself; otherwise only ``run`` and ``wait``
            advance it, as fast as possible.
        speed: Simulated seconds per wall second in real time.
        paused: Whether to start paused.
        description: Which robot.
        control: Its controllers and its initial pose.
        simulation: The physics, the objects around the robot, and time.

    Returns:
        The robot, holding its pose.

    Raises:
        Tool0Error: If an option or a file is wrong.
    """
    description = _with_given(
        description, arm=arm, prefix=prefix, robot=robot, args=args
    )
    if gripper is not UNSET:
        description = replace(description, gripper=gripper)
    control = _with_given(
        control,
        controllers_file=controllers_file,
        controllers=controllers,
        initial_pose=initial_pose,
    )
    simulation = _with_given(
        simulation,
        engine=engine,
        scene=scene,
        realtime=realtime,
        speed=speed,
        paused=paused,
    )
    return _bring_up(load_description(description), control, simulation)


def _with_given(config: Config, **keywords: object) -> Config:
    """Return ``config`` with the keywords that are not None."""
    given = {name: value for name, value in keywords.items() if value is not None}
    changed: Config = replace(config, **given)  # type: ignore[arg-type]  # any field's
    return changed


def _bring_up(
    description: RobotDescription, control: ControlConfig, simulation: SimulationConfig
) -> Robot:
    model = description.model
    scene = _scene(simulation.scene)
    scene.check_beside(model)
    cameras = merged(default_cameras(model), scene.cameras, simulation.cameras)
    for camera in cameras.values():
        camera.check_on(model)
    config = _controller_config(description, control.controllers_file)
    started, stopped = _controller_names(
        config, control.controllers, control.stopped_controllers
    )
    poses = PoseBook(description)
    position = _initial_position(model, poses, control.initial_pose)
    engine = _engine(
        simulation.engine,
        description,
        dt=simulation.dt,
        spawn_z=simulation.spawn_z,
        scene=scene,
        options=simulation.engine_options,
    )
    try:
        core = _core(
            model,
            engine,
            config,
            position,
            scene=scene,
            control_period=control.control_period,
            grasp_assist=simulation.grasp_assist,
        )
        for name in (*started, *stopped):
            core.apply(ask.LoadController(name))
        core.apply(ask.SwitchControllers(start=started, strictness=Strictness.STRICT))
        bus = Bus()
        loop = Loop(
            core,
            Mailbox(),
            bus,
            paused=simulation.paused,
            speed=simulation.speed if simulation.realtime else None,
        )
    except BaseException:
        engine.close()
        raise
    has_own_world = simulation.engine_options.get("world") is not None
    return Robot(
        description=description,
        engine=engine,
        loop=loop,
        bus=bus,
        poses=poses,
        defined_controllers=config.types,
        parameters=config.parameters(),
        joint_limits=core.hardware.limits,
        spawn_z=simulation.spawn_z,
        cameras=cameras,
        ground=None if has_own_world else -simulation.spawn_z,
        grasp_assist=simulation.grasp_assist,
        warnings=lint(config, model),
    )


def _names(names: Names) -> tuple[str, ...]:
    """Return names given as ROS gives them, separated by spaces, or one by one."""
    return tuple(names.split()) if isinstance(names, str) else tuple(names)


def _controller_config(
    description: RobotDescription,
    files: File | Sequence[File] | None,
) -> ControllerConfig:
    if files is None and description.arm is None:
        return ControllerConfig.from_text("")  # your own robot: the brakes hold it
    if files is None:
        return ControllerConfig.from_text(*default_controllers(description))
    given = [files] if isinstance(files, Path | str) else files
    return ControllerConfig.from_files([Path(file).expanduser() for file in given])


def _controller_names(
    config: ControllerConfig, start: Names | None, stopped: Names | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the controllers to start and those to load only."""
    defined = config.names
    for name in (*_names(start or ()), *_names(stopped or ())):
        if name not in defined:
            raise ConfigError(
                f"no controller '{name}' in the YAML{nearest_name(name, set(defined))}"
            )
    wanted = _names(start) if start is not None else DEFAULT_CONTROLLERS
    started = tuple(name for name in wanted if name in defined)
    kept = _names(stopped) if stopped is not None else DEFAULT_STOPPED_CONTROLLERS
    return started, tuple(
        name for name in kept if name in defined and name not in started
    )


def _initial_position(
    model: RobotModel, poses: PoseBook, pose: str | Mapping[str, float] | None
) -> list[float]:
    """Return every movable joint's position, in the order of the model."""
    nearest_to_zero = {
        joint.name: joint.limits.clamp(0.0)
        for joint in model.movable_joints
        if joint.mimic is None
    }
    default = poses.own.get(DEFAULT_POSE)
    given = _positions(poses, pose) if isinstance(pose, str) else (pose or {})
    return joint_positions(
        model,
        {**nearest_to_zero, **(default.positions if default else {}), **given},
        [0.0] * len(model.movable_joints),
    )


def _positions(poses: PoseBook, name: str) -> Mapping[str, float]:
    try:
        return poses.find(name).positions
    except ControlError as error:
        raise ConfigError(str(error)) from None


def _scene(scene: Scene | File | None) -> Scene:
    if scene is None:
        return Scene()
    return scene if isinstance(scene, Scene) else load_scene(scene)


def _engine(
    name: str,
    description: RobotDescription,
    *,
    dt: float,
    spawn_z: float,
    scene: Scene,
    options: Mapping[str, Any],  # each engine's own types
) -> Engine:
    if name not in ENGINES:
        hint = nearest_name(name, set(ENGINES))
        raise EngineUnavailableError(f"unknown engine '{name}'{hint}")
    own = ("world", "gui") if name == "gazebo" else ()
    for option in options:
        if option not in own:
            raise ConfigError(f"engine '{name}' has no option '{option}'")
    if name == "gazebo":
        if description.model.loops:
            raise ConfigError(
                f"Gazebo cannot simulate the loop '{description.model.loops[0].name}'; "
                "use gripper_model mimic or the engine mujoco"
            )
        from tool0.engines.gazebo.engine import GazeboEngine

        world = options.get("world")
        return GazeboEngine(
            description,
            dt,
            spawn_z=spawn_z,
            scene=scene,
            world=None if world is None else Path(world),
            gui=bool(options.get("gui")),
        )
    from tool0.engines.mujoco.gl import import_mujoco

    import_mujoco()
    from tool0.engines.mujoco.engine import MujocoEngine

    return MujocoEngine(description.model, dt, ground=-spawn_z, scene=scene)


def _core(
    model: RobotModel,
    engine: Engine,
    config: ControllerConfig,
    position: list[float],
    *,
    scene: Scene,
    control_period: float | None,
    grasp_assist: bool,
) -> Core:
    overrides = {
        name: limits.over(model.joint(name).limits)
        for name, limits in config.joint_limits().items()
    }
    hardware = RobotHardware(
        model, engine.joint_names, engine.dt, overrides, engine.gravity
    )
    joints = {
        name: replace(joint, limits=hardware.limits.get(name, joint.limits))
        for name, joint in model.joint_by_name.items()
    }
    manager = ControllerManager(hardware, config, joints)
    return Core(
        model=model,
        engine=engine,
        hardware=hardware,
        manager=manager,
        initial_position=position,
        scene=scene,
        control_period=control_period,
        grasp_assist=grasp_assist,
    )
