"""From options to a robot that stands there with its controllers running."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from tool0.control.config import ControllerConfig
from tool0.control.lint import lint
from tool0.control.manager import ControllerManager, Strictness
from tool0.description.camera import Camera, default_cameras, merged
from tool0.description.catalogue import (
    RobotDescription,
    assemble,
    default_controllers,
    load_robot,
)
from tool0.description.model import RobotModel
from tool0.description.scene import Scene
from tool0.description.scene_file import load_scene
from tool0.errors import (
    ConfigError,
    ControlError,
    EngineUnavailableError,
    did_you_mean,
)
from tool0.hardware.engine import Engine
from tool0.hardware.robot_hardware import RobotHardware
from tool0.runtime import commands as ask
from tool0.runtime.bus import Bus
from tool0.runtime.core import Core
from tool0.runtime.initial_pose import joint_positions
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
"""As the launch file ``ur5_bringup.launch`` has them; those that the YAML defines."""
DEFAULT_POSE = "home"
ENGINES = ("mujoco", "gazebo")

Names = str | Sequence[str]


def bringup(
    *,
    arm: str = "ur5",
    gripper: str | None = "2f85",
    prefix: str = "",
    robot: Path | str | None = None,
    args: Mapping[str, str] | None = None,
    joint_limit_params: Path | str | None = None,
    kinematics_params: Path | str | None = None,
    physical_params: Path | str | None = None,
    visual_params: Path | str | None = None,
    gripper_params: Path | str | None = None,
    gripper_joint_limit_params: Path | str | None = None,
    transmission_hw_interface: str | None = None,
    safety_limits: bool | None = None,
    safety_pos_margin: float | None = None,
    safety_k_position: float | None = None,
    tf_prefix: str | None = None,
    mount_xyz: Sequence[float] | None = None,
    mount_rpy: Sequence[float] | None = None,
    meshes: str | None = None,
    gripper_model: str = "mimic",
    engine: str = "mujoco",
    spawn_z: float = 0.1,
    scene: Scene | Path | str | None = None,
    cameras: Sequence[Camera] = (),
    world: Path | str | None = None,
    gazebo_gui: bool = False,
    dt: float = 0.001,
    control_period: float | None = None,
    grasp_assist: bool = False,
    controllers_file: Path | str | Sequence[Path | str] | None = None,
    controllers: Names | None = None,
    stopped_controllers: Names | None = None,
    initial_pose: str | Mapping[str, float] | None = None,
    paused: bool = False,
    realtime: bool = True,
    speed: float = 1.0,
) -> Robot:
    """Bring a robot up: description, physics, drives, controllers.

    Args:
        arm: The arm; ``tool0.description.catalogue.arms()`` lists them.
        gripper: The gripper on tool0; None or "none" for a bare arm.
        prefix: Starts every link's and joint's name.
        robot: A person's own URDF or xacro file, instead of arm and gripper.
        args: xacro arguments of that file, or further ones of ours, as ``base_xyz``.
        joint_limit_params: YAML that replaces the arm's joint limits.
        kinematics_params: YAML that replaces the arm's kinematics.
        physical_params: YAML that replaces the arm's masses and inertias.
        visual_params: YAML that replaces the arm's shapes.
        gripper_params: YAML that replaces the gripper's masses and drive.
        gripper_joint_limit_params: YAML that replaces the gripper's joint limits.
        transmission_hw_interface: ``hardware_interface/…JointInterface`` of all joints.
        safety_limits: Whether the arm's joints get soft limits.
        safety_pos_margin: Distance of the soft limits from the hard ones [rad].
        safety_k_position: Gain of the soft limits [1/s].
        tf_prefix: For publishers of transforms; the robot itself stays as it is.
        mount_xyz: Where the gripper sits on tool0 [m].
        mount_rpy: How it is turned there [rad].
        meshes: "tool0" for ours, "upstream" for those of ur_description.
        gripper_model: "mimic" for fingers that follow their drive, "linkage" for real
            ones that wrap around what they meet (MuJoCo alone; docs/adr/0009).
        engine: The physics: "mujoco", or "gazebo" (docs/gazebo.md).
        spawn_z: Height of the robot's root above the ground [m], as in the launch
            files of ur_gazebo: the outstretched arm must clear the ground.
        scene: What stands and lies around the robot, the YAML file that says so, or the
            name of a scene that comes along: ``table_and_bin``, ``table_and_cubes``.
        cameras: Further cameras; one named as another takes its place (docs/camera.md).
        world: A world file of Gazebo's; left out, an empty one with ground.
        gazebo_gui: Whether to open Gazebo's own window, gzclient.
        dt: Length of a physics step [s].
        control_period: Time between controller updates [s]; ``dt`` if left out.
        grasp_assist: Whether to cheat: what the gripper grips is fixed to it until it
            opens, whatever friction and force say.
        controllers_file: ros_control YAML, one or several; later ones override.
        controllers: Names to load and start.
        stopped_controllers: Names to load only.
        initial_pose: A named pose, saved ones included, or positions by joint
            [rad | m] on top of the default pose.
        paused: Whether to begin paused.
        realtime: Whether time passes by itself; otherwise only ``run`` and ``wait``
            make it pass, as fast as possible.
        speed: Simulated seconds per wall second in real time.

    Returns:
        The robot, holding its pose.

    Raises:
        Tool0Error: If anything about the options or the files is wrong.
    """
    options = {
        "joint_limit_params": _path(joint_limit_params),
        "kinematics_params": _path(kinematics_params),
        "physical_params": _path(physical_params),
        "visual_params": _path(visual_params),
        "gripper_params": _path(gripper_params),
        "gripper_joint_limit_params": _path(gripper_joint_limit_params),
        "transmission_hw_interface": transmission_hw_interface,
        "safety_limits": safety_limits,
        "safety_pos_margin": safety_pos_margin,
        "safety_k_position": safety_k_position,
        "tf_prefix": tf_prefix,
        "mount_xyz": None if mount_xyz is None else tuple(mount_xyz),
        "mount_rpy": None if mount_rpy is None else tuple(mount_rpy),
        "meshes": meshes,
        "gripper_model": gripper_model,
    }
    if robot is None:
        description = assemble(arm, gripper, prefix=prefix, **options, **(args or {}))
    else:
        _refuse_catalogue_options(robot, {"prefix": prefix, **options})
        description = load_robot(Path(robot), args or {})
    model = description.model
    surroundings = _scene(scene)
    surroundings.check_beside(model)
    seeing = merged(default_cameras(model), surroundings.cameras, cameras)
    for camera in seeing.values():
        camera.check_on(model)
    config = _controller_config(description, controllers_file)
    started, stopped = _controller_names(config, controllers, stopped_controllers)
    poses = PoseBook(description)
    position = _initial_position(model, poses, initial_pose)
    physics = _engine(
        engine,
        description,
        dt=dt,
        spawn_z=spawn_z,
        scene=surroundings,
        world=_path(world),
        gazebo_gui=gazebo_gui,
    )
    try:
        core = _core(
            model,
            physics,
            config,
            position,
            scene=surroundings,
            control_period=control_period,
            grasp_assist=grasp_assist,
        )
        for name in (*started, *stopped):
            core.apply(ask.LoadController(name))
        core.apply(ask.SwitchControllers(start=started, strictness=Strictness.STRICT))
        bus = Bus()
        loop = Loop(
            core, Mailbox(), bus, paused=paused, speed=speed if realtime else None
        )
    except BaseException:
        physics.close()
        raise
    return Robot(
        description=description,
        engine=physics,
        loop=loop,
        bus=bus,
        poses=poses,
        defined_controllers=config.types,
        parameters=config.parameters(),
        joint_limits=core.hardware.limits,
        spawn_z=spawn_z,
        cameras=seeing,
        ground=None if world else -spawn_z,  # a person's world has what it has
        grasp_assist=grasp_assist,
        warnings=lint(config, model),
    )


def _refuse_catalogue_options(robot: Path | str, options: dict[str, object]) -> None:
    """Raise if options are given that only a robot of the catalogue can heed."""
    given = [
        name
        for name, value in options.items()
        if value not in (None, False, "", "tool0", "mimic")  # as if left out
    ]
    if given:
        raise ConfigError(
            f"{', '.join(given)}: not for a robot of your own; '{robot}' takes what "
            "it declares with <xacro:arg>, by args"
        )


def _path(path: Path | str | None) -> Path | None:
    return None if path is None else Path(path)


def _names(names: Names) -> tuple[str, ...]:
    """Return names given as ROS gives them, separated by spaces, or one by one."""
    return tuple(names.split()) if isinstance(names, str) else tuple(names)


def _controller_config(
    description: RobotDescription,
    files: Path | str | Sequence[Path | str] | None,
) -> ControllerConfig:
    if files is None and description.arm is None:
        return ControllerConfig.from_text("")  # a person's robot: the brakes hold it
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
                f"no controller '{name}' in the YAML{did_you_mean(name, set(defined))}"
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


def _scene(scene: Scene | Path | str | None) -> Scene:
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
    world: Path | None,
    gazebo_gui: bool,
) -> Engine:
    if name not in ENGINES:
        hint = did_you_mean(name, set(ENGINES))
        raise EngineUnavailableError(f"unknown engine '{name}'{hint}")
    if name == "gazebo":
        if description.model.loops:
            raise ConfigError(
                f"Gazebo cannot have the loop '{description.model.loops[0].name}'; "
                "use gripper_model mimic or the engine mujoco"
            )
        from tool0.engines.gazebo.engine import GazeboEngine

        return GazeboEngine(
            description, dt, spawn_z=spawn_z, scene=scene, world=world, gui=gazebo_gui
        )
    if world is not None or gazebo_gui:
        raise ConfigError(
            f"a world file and Gazebo's window need engine 'gazebo', not '{name}'"
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
