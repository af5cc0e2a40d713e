"""Setup of a simulation, which creates the cores of a bring-up or a batch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import final

from tool0.control.config import ControllerConfig
from tool0.control.manager import ControllerManager, Strictness
from tool0.description.config import File
from tool0.description.forward_kinematics import joint_positions
from tool0.description.model import RobotModel
from tool0.description.poses import PoseStore
from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.description.scene_file import load_scene
from tool0.engines.registry import HARDWARE, make_engine
from tool0.errors import ConfigError, ControlError
from tool0.hardware.engine import Engine
from tool0.hardware.own_drives import OwnDrives
from tool0.hardware.robot_hardware import RobotHardware
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.controllers import ControllerChoice, choose_controllers
from tool0.simulation.core import Core


@final
@dataclass(frozen=True, kw_only=True)
class Setup:
    """Description and options of a simulation, and the resulting choices."""

    description: RobotDescription
    control: ControlConfig
    options: SimulationConfig
    scene: Scene
    """Objects at the start of the simulation."""
    choice: ControllerChoice
    """Chosen controllers."""
    poses: PoseStore
    position: list[float]
    """Initial pose [rad | m], shape (n_joints,), in the order of the model."""

    @staticmethod
    def of(
        description: RobotDescription, control: ControlConfig, options: SimulationConfig
    ) -> Setup:
        """Choose the scene, the controllers and the initial pose.

        Raises:
            Tool0Error: If an option or a file is invalid.
        """
        scene = chosen_scene(description, options.scene)
        is_real = options.engine == HARDWARE
        choice = choose_controllers(description, control, is_real=is_real)
        poses = PoseStore(description)
        position = _initial_position(description.model, poses, control.initial_pose)
        return Setup(
            description=description,
            control=control,
            options=options,
            scene=scene,
            choice=choice,
            poses=poses,
            position=position,
        )

    def make_engine(self) -> Engine:
        """Return an engine with the robot and the objects.

        Raises:
            Tool0Error: If an option is invalid.
        """
        options = self.options
        return make_engine(
            options.engine,
            self.description,
            dt=options.dt,
            spawn_z=options.spawn_z,
            scene=self.scene,
            options=options.engine_options,
        )

    def make_core(self, engine: Engine) -> Core:
        """Return a core at the initial pose, with running controllers."""
        config, started, stopped, _ = self.choice
        hardware, manager = _hardware(self.description.model, engine, config)
        is_real = isinstance(engine, OwnDrives)
        core = Core(
            model=self.description.model,
            engine=engine,
            hardware=hardware,
            manager=manager,
            initial_position=engine.read().position if is_real else self.position,
            scene=self.scene,
            control_period=engine.dt if is_real else self._control_period(engine.dt),
            grasp_assist=self.options.grasp_assist,
        )
        for name in (*started, *stopped):
            manager.load(name)
        manager.switch(started, (), Strictness.STRICT, core.state)
        if isinstance(engine, OwnDrives):
            for arm in core.arms:
                arm.stop(core.state)
            # Simulated time may be paused before the first tick, but the state is
            # needed.
            core.arms.follow(engine.report, core.state)
        return core

    def _control_period(self, dt: float) -> float | None:
        """Return the control period from the options or from the YAML [s].

        Raises:
            ConfigError: If the period in the YAML is not a multiple of ``dt`` [s].
        """
        period = self.control.control_period or self.choice.config.control_period
        if period is None or period == self.control.control_period:
            return period
        steps = max(round(period / dt), 1)
        if not math.isclose(steps * dt, period, rel_tol=1e-9):
            raise ConfigError(
                f"the controller_manager's update_rate {1.0 / period:g} Hz is a period "
                f"of {period:g} s, which is no multiple of the physics step {dt:g} s; "
                "choose another rate, dt or control_period"
            )
        return steps * dt


def chosen_scene(description: RobotDescription, scene: Scene | File | None) -> Scene:
    """Return the given scene, or the scene of the cell if no scene is given.

    ConfigError is raised if the scene is invalid.  The scene is checked together with
    the robot.
    """
    cell = description.cell
    found = scene or (cell and cell.scene) or Scene()
    if not isinstance(found, Scene):
        found = load_scene(found)
    found.check_beside(description.model)
    return found


def _initial_position(
    model: RobotModel, poses: PoseStore, pose: str | Mapping[str, float] | None
) -> list[float]:
    """Return the initial positions of all movable joints, in the order of the model."""
    try:
        given = poses.find(pose).positions if isinstance(pose, str) else pose or {}
    except ControlError as error:
        raise ConfigError(str(error)) from None
    zeros = [0.0] * len(model.movable_joints)
    return joint_positions(model, {**poses.start(), **given}, zeros)


def _hardware(
    model: RobotModel, engine: Engine, config: ControllerConfig
) -> tuple[RobotHardware, ControllerManager]:
    """Return the robot's hardware and controllers, with limits from the YAML."""
    overrides = {
        name: replace(model.joint(name).limits, **limits)
        for name, limits in config.joint_limits().items()
    }
    hardware = RobotHardware(
        model, engine.joint_names, engine.dt, overrides, engine.world.gravity
    )
    if isinstance(engine, OwnDrives):
        hardware.gripper_delay = engine.gripper_delay
    joints = {
        name: replace(joint, limits=hardware.limits.get(name, joint.limits))
        for name, joint in model.joint_by_name.items()
    }
    return hardware, ControllerManager(hardware, config, joints, model)
