"""Engine, drives and controllers as one machine: a tick, and an answer per command."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, final

from tool0.control.forward_command import ForwardCommandController
from tool0.control.goal import Goal
from tool0.control.gripper_action import GripperActionController
from tool0.control.joint_trajectory import JointTrajectoryController
from tool0.control.manager import ControllerManager
from tool0.description.model import RobotModel
from tool0.description.positions import joint_positions
from tool0.description.scene import Scene
from tool0.errors import ConfigError, ControlError
from tool0.hardware.drive_bounds import DriveBounds
from tool0.hardware.engine import Engine
from tool0.hardware.joint_state import JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.runtime import commands as ask
from tool0.runtime.joint_moves import joints_by_controller, planned_motion
from tool0.runtime.surroundings import Surroundings
from tool0.sensing.force_torque_sensor import ForceTorqueSensor
from tool0.sensing.grasp_assist import GraspAssist


@final
class Core:
    """What the loop drives.  Only the thread that owns the tick may touch it."""

    def __init__(
        self,
        *,
        model: RobotModel,
        engine: Engine,
        hardware: RobotHardware,
        manager: ControllerManager,
        initial_position: Sequence[float],
        scene: Scene | None = None,
        control_period: float | None = None,
        grasp_assist: bool = False,
    ) -> None:
        """Put the robot into its initial pose.

        Args:
            model: The robot.
            engine: The physics.
            hardware: The drives, over the engine's joints.
            manager: The controllers, over the drives.
            initial_position: [rad | m], shape (n_joints,), in the engine's order.
            scene: What the engine was made with around the robot.
            control_period: Time between updates of the controllers [s]; a whole
                multiple of the engine's step, and that step if left out.
            grasp_assist: Whether to cheat: to fix to the gripper what it grips.
        """
        self._model = model
        self.engine = engine
        self.hardware = hardware
        self.manager = manager
        self.surroundings = Surroundings(model, engine, scene or Scene())
        self.ticks = 0
        self.control_period = engine.dt if control_period is None else control_period
        self._steps_per_tick = _whole_multiple(self.control_period, engine.dt)
        self._initial = list(initial_position)
        self._start = self._initial
        self._commanded: set[str] = set()
        self.when_goal_starts: Callable[[Goal], None] = lambda goal: None
        self._sensors: tuple[ForceTorqueSensor, ...] = ()
        self.grasp_assist = GraspAssist(model, engine) if grasp_assist else None
        engine.reset(self._initial)
        self.state: JointState = engine.read()
        self._before = self.state
        """What the last step of the physics began from."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.ticks * self.control_period

    def tick(self) -> None:
        """Update the controllers once and advance by one control period."""
        state = self.state
        engine, hardware = self.engine, self.hardware
        self.manager.update(state, self.control_period)
        for _ in range(self._steps_per_tick):
            before = state
            engine.write(hardware.efforts(state))
            engine.step()
            state = engine.read()
        self.state, self._before = state, before
        self.ticks += 1
        for sensor in self._sensors:
            sensor.tick(before, state, engine.contacts)

    def apply(self, command: ask.CoreCommand) -> Any:  # the answer is the command's
        """Carry out ``command`` now, between two ticks, and return its answer."""
        match command:
            case ask.LoadController(name, config):
                return self.manager.load(name, config)
            case ask.UnloadController(name):
                return self.manager.unload(name)
            case ask.SwitchControllers():
                return self.manager.switch(
                    command.start, command.stop, command.strictness, self.state
                )
            case ask.FollowTrajectory():
                name = command.controller
                trajectory = self._drivable(name, JointTrajectoryController)
                goal = trajectory.follow(command.goal, self.time)
                self._bind(name, command.goal.joint_names, command.bounds)
                return self._watch(goal)
            case ask.CommandTrajectory():
                name = command.controller
                trajectory = self._drivable(name, JointTrajectoryController)
                trajectory.command(command.goal, self.time)
                self._bind(name, command.goal.joint_names)
                self._note_commanded(name)
            case ask.MoveJoints():
                return self._move_joints(command)
            case ask.SteerJoints():
                self._steer_joints(command)
            case ask.CommandGripper():
                name = command.controller
                gripper = self._drivable(name, GripperActionController)
                position, effort = command.position, command.max_effort
                bounds, joint = command.bounds, gripper.spec.joint.name
                goal = gripper.command(position, effort, self.time, bounds)
                self._bind(name, (joint,), {joint: bounds})
                return self._watch(goal)
            case ask.CommandJoints():
                name = command.controller
                forward = self._drivable(name, ForwardCommandController)
                forward.command(command.values)
                self._bind(name)
                self.manager.release_brakes(name, self.state)
                self._note_commanded(name)
            case ask.CancelGoal(goal):
                self._cancel(goal)
            case ask.QueryState():
                return self._running(
                    command.controller, JointTrajectoryController
                ).query_state(command.time)
            case ask.ReadController(name):
                return self._running(name, JointTrajectoryController).state()
            case ask.ReadSpec(name):
                return self.manager.spec(name)
            case ask.ReadContacts():
                return self.engine.contacts()
            case ask.StartSensor(sensor):
                sensor.restart(self._before, self.state, self.engine.contacts)
                self._sensors = (*self._sensors, sensor)
            case ask.StopSensor(sensor):
                self._sensors = tuple(s for s in self._sensors if s is not sensor)
            case ask.SpawnObject(item):
                self.surroundings.spawn(item)
            case ask.DeleteObject(name):
                self.surroundings.delete(name)
            case ask.PlaceObject(state):
                self.surroundings.place(state)
            case ask.Reset():
                self._reset(command.position, command.keep_time)
            case ask.EmergencyStop(engaged):
                self._emergency_stop(engaged)
        return None

    def drift(self) -> float:
        """Return how far uncommanded joints are from where they started, at most.

        [rad | m]; 0 if every joint was commanded.
        """
        position, initial = self.state.position, self._start
        index = self.hardware.index
        uncommanded = self.hardware.interfaces.keys() - self._commanded
        return max(
            (
                abs(position[i] - initial[i])
                for i in (index[name] for name in uncommanded)
            ),
            default=0.0,
        )

    def _running(self, name: str, kind: type[Any]) -> Any:
        controller = self.manager.running(name)
        if not isinstance(controller, kind):
            raise ControlError(
                f"controller '{name}' is a {type(controller).__name__}; "
                f"this needs a {kind.__name__}"
            )
        return controller

    def _drivable(self, name: str, kind: type[Any]) -> Any:
        """Return a controller that may move joints now."""
        if self.hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before moving the robot"
            )
        return self._running(name, kind)

    def _move_joints(self, command: ask.MoveJoints) -> tuple[Goal, ...]:
        """Start all motions at one instant, or none."""
        moves: Mapping[str, Mapping[str, float]]
        if command.controller is None:
            moves = joints_by_controller(self.manager, command.positions)
        else:
            moves = {command.controller: command.positions}
        planned = []
        for name, positions in moves.items():
            trajectory = self._drivable(name, JointTrajectoryController)
            plan = planned_motion(
                trajectory, positions, speed=command.speed, now=self.time
            )
            planned.append((trajectory, plan))
        for name, positions in moves.items():
            self._bind(name, positions)
        return tuple(
            self._watch(trajectory.follow_plan(plan, self.time))
            for trajectory, plan in planned
        )

    def _steer_joints(self, command: ask.SteerJoints) -> None:
        name = command.controller
        trajectory = self._drivable(name, JointTrajectoryController)
        plan = planned_motion(
            trajectory, command.positions, speed=command.speed, now=self.time
        )
        trajectory.command_plan(plan, self.time)
        self._bind(name, command.positions)
        self._note_commanded(name)

    def _bind(
        self,
        controller: str,
        joints: Collection[str] | None = None,
        bounds: Mapping[str, DriveBounds | None] | None = None,
    ) -> None:
        """Bound the drives that a goal moves as it says, and lift what others said.

        Args:
            controller: Which took the goal.
            joints: Those of its joints that the goal names; None for all.
            bounds: Joint → what bounds its drive.
        """
        for _, claimed in self.manager.status(controller).claimed:
            for joint in claimed:
                if joints is None or joint in joints:
                    self.hardware.bind(joint, (bounds or {}).get(joint))

    def _note_commanded(self, controller: str) -> None:
        for _, joints in self.manager.status(controller).claimed:
            self._commanded.update(joints)

    def _watch(self, goal: Goal) -> Goal:
        self._note_commanded(goal.controller)
        self.when_goal_starts(goal)
        return goal

    def _cancel(self, goal: Goal) -> None:
        if goal.status.is_terminal:
            return
        controller = self.manager.running(goal.controller)
        if isinstance(controller, JointTrajectoryController | GripperActionController):
            controller.cancel(goal, self.time)

    def _reset(self, position: Mapping[str, float], keep_time: bool) -> None:
        start = joint_positions(self._model, position, self._initial)
        self._start = start
        self.ticks = self.ticks if keep_time else 0
        self.engine.reset(start, self.time)
        self.state = self._before = self.engine.read()
        self._commanded.clear()
        if self.grasp_assist is not None:
            self.grasp_assist.forget()
        self.hardware.restart(self.state)
        self.manager.restart(self.state)
        for sensor in self._sensors:
            sensor.restart(self._before, self.state, self.engine.contacts)

    def _emergency_stop(self, engaged: bool) -> None:
        if engaged == self.hardware.is_stopped:
            return
        self.hardware.emergency_stop(engaged, self.state)
        self.manager.restart(self.state)


def _whole_multiple(period: float, dt: float) -> int:
    """Return how many steps of ``dt`` make ``period``, or raise ConfigError."""
    if 0.0 < period < math.inf:
        n_steps = round(period / dt)
        if n_steps and math.isclose(n_steps * dt, period, rel_tol=1e-9):
            return n_steps
    raise ConfigError(
        f"control period {period} s is no whole multiple of the engine's step {dt} s"
    )
