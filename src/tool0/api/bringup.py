"""``tool0.bringup``: a robot in this process."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import tool0.recording.episodes  # registers the handlers for episode requests
import tool0.recording.requests  # noqa: F401
from tool0.api.robot import Robot
from tool0.description.config import (
    UNSET,
    Argument,
    Cell,
    DescriptionConfig,
    File,
    Unset,
)
from tool0.description.loading import load_description
from tool0.description.scene import Scene
from tool0.engines.registry import HARDWARE
from tool0.protocol.backend import Backend
from tool0.protocol.channel import LocalChannel
from tool0.simulation.bringup import start_simulation
from tool0.simulation.config import ControlConfig, Names, SimulationConfig
from tool0.simulation.handlers.backend import SimulationBackend
from tool0.simulation.handlers.state import stop_after_freezes
from tool0.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

Config = TypeVar("Config", DescriptionConfig, ControlConfig, SimulationConfig)


def bringup(
    *,
    arm: str | None = None,
    gripper: str | Unset | None = UNSET,
    prefix: str | None = None,
    robot: File | None = None,
    cell: Cell | File | None = None,
    args: Mapping[str, Argument] | None = None,
    ros2_control: bool | None = None,
    engine: str | None = None,
    hardware: str | None = None,
    scene: Scene | File | None = None,
    controllers_file: File | Sequence[File] | None = None,
    controllers: Names | None = None,
    initial_pose: str | Mapping[str, float] | None = None,
    realtime: bool | None = None,
    speed: float | None = None,
    paused: bool | None = None,
    record: File | None = None,
    description: DescriptionConfig = DescriptionConfig(),
    control: ControlConfig = ControlConfig(),
    simulation: SimulationConfig = SimulationConfig(),
) -> Robot:
    """Bring up a robot: its description, physics, drives and controllers.

    ``description``, ``control`` and ``simulation`` contain all options.  The other
    keywords are shorthands for frequently used options.  A shorthand that is not None
    replaces the field with the same name::

        cell = SimulationConfig(scene="table_and_bin", grasp_assist=True)
        tool0.bringup(arm="ur5", simulation=cell, realtime=False)

    Args:
        arm: The arm; the default is ur5.
        gripper: The gripper on the arm's flange; the default is 2f85.  For an arm
            without a gripper, use None or "none".
        prefix: Prefix of all link and joint names.
        robot: Your own URDF or xacro file, instead of an arm and a gripper.
        cell: Several robots and a scene: a ``Cell``, or a YAML file
            (docs/how-to/cells.md).
        args: xacro arguments of your own file, or additional arguments of the built-in
            file.
        ros2_control: Whether built-in robots have ``<ros2_control>`` tags, and
            therefore use controllers of ROS 2 (docs/how-to/ros2.md).
        engine: The physics engine: "mujoco", or "gazebo" (docs/how-to/gazebo.md).
        hardware: The address of a real robot, instead of an engine
            (docs/how-to/hardware.md).
        scene: The objects around the robot: a ``Scene``, a YAML file, or a built-in
            scene (``table_and_bin``, ``table_and_cubes``, ``shelf``).
        controllers_file: One or several YAML files of ros_control or ros2_control;
            later files override earlier files.
        controllers: Names of the controllers to load and start.
        initial_pose: A named pose, or positions by joint [rad | m].
        realtime: Whether simulated time passes in real time; otherwise, only ``run``
            and ``wait`` advance time, as fast as possible.
        speed: Simulated seconds per wall second if ``realtime`` is true.
        paused: Whether simulated time is paused at the start.
        record: An MCAP file in which the robot is recorded until it is closed
            (docs/how-to/recordings.md).
        description: Options of the robot.
        control: Options of the robot's controllers and initial pose.
        simulation: Options for the physics, the objects around the robot, and time.

    Returns:
        The robot, which holds its pose.  The ``warnings`` of the robot are also logged.

    Raises:
        Tool0Error: If an option or a file is wrong.
    """
    description = _with_given(
        description,
        arm=arm,
        prefix=prefix,
        robot=robot,
        cell=cell,
        args=args,
        ros2_control=ros2_control,
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
        hardware=hardware,
        scene=scene,
        realtime=realtime,
        speed=speed,
        paused=paused,
        record=record,
    )
    if simulation.hardware is not None:
        options = {**simulation.engine_options, "address": simulation.hardware}
        simulation = replace(simulation, engine=HARDWARE, engine_options=options)
        if ros2_control is None and _is_of_catalogue(description, control):
            description = replace(description, ros2_control=True)
    robot_description = load_description(description, spawn_z=simulation.spawn_z)
    is_recorded = simulation.record is not None
    # start the recording at time zero
    held = replace(simulation, paused=True) if is_recorded else simulation
    started = start_simulation(robot_description, control, held)
    stop_after_freezes(started)
    recorded = Robot(LocalChannel(_backend(started)))
    for warning in recorded.warnings:
        logger.warning("tool0: warning: %s", warning)
    if simulation.record is None:
        return recorded
    try:
        recorded.start_recording(simulation.record, overwrite=simulation.overwrite)
    except BaseException:
        recorded.close()
        raise
    loop = recorded.simulation.loop
    loop.call(lambda: loop.set_paused(simulation.paused))
    return recorded


def _is_of_catalogue(description: DescriptionConfig, control: ControlConfig) -> bool:
    """Return whether the robot, its interfaces and its controllers are built in."""
    chosen = (description.robot, description.transmission_hw_interface)
    return chosen == (None, None) and control.controllers_file is None


def _backend(started: Simulation) -> Backend:
    """Return the backend of a robot that was brought up."""
    if started.core.own_drives is None:
        return SimulationBackend(started)
    from tool0.simulation.real_robot.backend import RealRobotBackend

    return RealRobotBackend(started)


def _with_given(config: Config, **keywords: object) -> Config:
    """Return ``config`` with fields replaced by the keywords that are not None."""
    given = {name: value for name, value in keywords.items() if value is not None}
    changed: Config = replace(config, **given)  # type: ignore[arg-type]  # any field's
    return changed
