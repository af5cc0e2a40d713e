"""Engine, drives and controllers as one machine: the tick, and the operations on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from operator import sub
from typing import final

from tool0.control.controller import (
    CommandTaker,
    Controller,
    GripperDriver,
    SpeedScalable,
    TrajectoryFollower,
)
from tool0.control.manager import ControllerManager
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.drive_limits import DriveLimits
from tool0.description.forward_kinematics import joint_positions
from tool0.description.model import RobotModel
from tool0.description.payload import Payload
from tool0.description.scene import Scene
from tool0.errors import ConfigError, ControlError
from tool0.hardware.engine import Engine, JointState, joint_selector
from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.kernel import Kernel
from tool0.kernel.program import Ended, TickProgram
from tool0.protocol.controllers import KIND_OF, Role
from tool0.protocol.goals import Goal, GripperResult, Result
from tool0.protocol.state import ArmSample, Contact, contacts_text
from tool0.sensing.force_torque import ForceTorqueSensor
from tool0.sensing.grasp import GraspAssist
from tool0.sensing.grip_contacts import GripContacts
from tool0.sensing.stalls import StallMonitor, external_contacts
from tool0.simulation.arm_modes import ArmModes
from tool0.simulation.arm_motions import ArmMotions
from tool0.simulation.arm_samples import ArmSamples
from tool0.simulation.arm_supervision import ArmSupervision
from tool0.simulation.control_boxes import ControlBoxes
from tool0.simulation.controller_paths import (
    joints_by_controller,
    motion_plan,
    planned_path,
    timed_path,
    trajectory_points,
)
from tool0.simulation.protective_stops import ProtectiveStops, wanted_positions
from tool0.simulation.pull_springs import PullSprings
from tool0.simulation.scene_objects import SceneObjects


@final
class Core:
    """The machine that the loop ticks.  Only the thread of the tick may use it."""

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

        ``initial_position`` [rad | m] has shape (n_joints,), in the engine's order;
        ``scene`` is what the engine was made with.  ``control_period`` [s] is a whole
        multiple of the engine's step, and that step if left out.
        """
        self._model = model
        self.engine = engine
        self.hardware = hardware
        self.manager = manager
        self.scene = SceneObjects(model, engine, scene or Scene())
        self.pulls = PullSprings(model, engine.joint_names, self.scene.wrenches)
        self.control_boxes = ControlBoxes(model, hardware)
        self.arm_modes = ArmModes(model, self.control_boxes, hardware, manager)
        self.arm_motions = ArmMotions(
            model, hardware, manager, self.control_boxes, self.arm_modes
        )
        self.protective_stops = ProtectiveStops(model, hardware, manager, engine.world)
        self.arm_supervision = ArmSupervision(
            model, hardware, manager, self.arm_motions, engine.world
        )
        self.ticks = 0
        self.control_period = engine.dt if control_period is None else control_period
        self._steps_per_tick = _whole_multiple(self.control_period, engine.dt)
        hardware.set_steps_per_command(self._steps_per_tick)
        self._kernel = Kernel(engine, hardware, manager, self.control_period)
        self._program: TickProgram | None = None
        """What executes the ticks, while it has the state of controllers and drives."""
        self._brakes: Mapping[int, float] = {}
        """Those that the engine has."""
        self._initial = list(initial_position)
        self._start = self._initial
        self._commanded: set[str] = set()
        self._watch_drift()
        self.when_goal_starts: Callable[[Goal], None] = lambda goal: None
        self._sensors: tuple[ForceTorqueSensor, ...] = ()
        self._samples = ArmSamples(
            model, engine, hardware, self.control_boxes, self.arm_motions
        )
        self.grasp_assist = GraspAssist(model, engine) if grasp_assist else None
        self.stall_monitor = StallMonitor(model, hardware)
        self.grip_contacts = GripContacts(model, engine.joint_names)
        engine.reset(self._initial)
        self.state: JointState = engine.read()
        self._before = self.state
        """The state at the start of the last physics step."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.ticks * self.control_period

    @property
    def command(self) -> tuple[float, ...]:
        """The last command of each joint, in the unit of its interface."""
        return tuple(self._newest_command())

    def _newest_command(self) -> list[float]:
        program = self._program
        return self.hardware.command if program is None else program.command

    def _wanted(self) -> Mapping[str, float]:
        """Return the setpoint of each joint that is moved by position [rad | m]."""
        command = self._newest_command()
        return wanted_positions(self.hardware, self.manager, command)

    def tick(self) -> None:
        """Update the controllers once and advance by one control period."""
        self.sync_from_kernel()
        self._set_brakes()
        state = self.state
        if not self.pulls.is_idle:
            self.pulls.tick(state)
        self.scene.wrenches.tick(self.time)
        if not self.control_boxes.is_steady:
            self.control_boxes.tick(self.control_period)
        if not self.arm_motions.is_idle:
            self.arm_motions.tick(state)
        self.manager.update(state, self.control_period)
        self._finish_tick(state, self._steps_per_tick)

    def _set_brakes(self) -> None:
        """Let the engine have the brakes that are engaged now."""
        brakes = self.hardware.brakes
        if brakes is not self._brakes:
            self._brakes = brakes
            self.engine.set_brakes(brakes)

    def _finish_tick(self, state: JointState, n_steps: int) -> None:
        """Execute the last steps of a tick, from ``state`` on."""
        engine, hardware, before = self.engine, self.hardware, self._before
        for _ in range(n_steps):
            before = state
            engine.write(hardware.efforts(state))
            engine.step()
            state = engine.read()
        self.state, self._before = state, before
        self.ticks += 1
        for sensor in self._sensors:
            sensor.tick(before, state, self._forces)

    def advance(self, most: int) -> int:
        """Tick at least once and up to ``most`` times; return how many times.

        The kernel executes what it can; after a tick in Python, this returns.
        """
        program = None if self.engine.stepper is None else self.program()
        stepper = self.engine.stepper  # another one, if brakes changed
        if program is None or stepper is None:
            self.tick()
            return 1
        for sensor in self._sensors:
            most = min(most, sensor.ticks_left)
        return self.apply_kernel_result(*program.run(most, stepper))

    def program(self) -> TickProgram | None:
        """Let the kernel execute the coming ticks; None if only Python can."""
        if (
            self._program is None
            and self.scene.wrenches.is_idle
            and self.pulls.is_idle
            and self.control_boxes.is_steady
            and self.arm_motions.is_idle
        ):
            self._set_brakes()
            self._program = self._kernel.load(self.state)
        return self._program

    def apply_kernel_result(self, result: Ended, done: int) -> int:
        """Follow a run of the program by ``done`` ticks; return how many they are now.

        After an event, Python executes one tick more.
        """
        program, stepper = self._program, self.engine.stepper
        if program is None or stepper is None:
            raise RuntimeError("the kernel has not run")
        self.ticks += done
        state, left = self.state, program.steps_left
        has_stepped = program.note_steps(stepper)
        if has_stepped or left:
            self.state = program.tick_start()
            self.manager.observe(self.state)
        if has_stepped:
            state = self.engine.read()
        if result is Ended.DONE:
            self.state = state
            for sensor in self._sensors:
                sensor.tick(program.step_start(), state, self._forces, done)
            return done
        for sensor in self._sensors:
            sensor.skip(done)
        self.sync_from_kernel()
        if result is Ended.EVENT and not left:
            self.state = state
            self.tick()
        else:
            self._finish_tick(state, left)
        return done + 1

    def sync_from_kernel(self) -> None:
        """Give controllers and drives their state back, if the kernel has it.

        Whatever reads or changes them between two ticks needs this first.
        """
        program, self._program = self._program, None
        if program is not None:
            self._before = program.step_start()
            program.store()

    def check_contacts(self) -> None:
        """Find joints that push without moving, and grips, between two ticks."""
        contacts = self.engine.world.contacts
        self.stall_monitor.look(self.state, contacts, self._wanted)
        self.grip_contacts.look(self.state, contacts)

    def check_safety_limits(self) -> None:
        """Stop arms whose safety limits are exceeded, between two ticks."""
        boxes, command = self.control_boxes.states, self._newest_command()
        found = self.protective_stops.look(boxes, self.state, command)
        for arm, reason in found:
            self.sync_from_kernel()
            self.arm_modes.stop_protectively(arm, reason, self.state)

    def check_motions(self) -> None:
        """End the motions of taken arms that fail, between two ticks."""
        command = self._newest_command()
        for arm, reason in self.arm_supervision.look(self.state, command):
            self.sync_from_kernel()
            self.arm_motions.fail(arm, reason, self.state)

    # ---- controllers ----------------------------------------------------------------

    def follow(
        self,
        controller: str,
        goal: TrajectoryGoal,
        bounds: Mapping[str, DriveLimits] | None = None,
    ) -> Goal:
        """Start a trajectory goal; ``bounds`` hold until a joint's next goal."""
        trajectory = self._follower(controller)
        accepted = trajectory.follow(goal, self.time)
        self._note_command(controller, goal.joint_names, bounds)
        return self._started(accepted)

    def command_trajectory(
        self,
        controller: str,
        goal: TrajectoryGoal,
        bounds: Mapping[str, DriveLimits] | None = None,
    ) -> None:
        """Follow a trajectory without a goal, as ROS's topic does.

        ``bounds`` are as for ``follow``.
        """
        trajectory = self._follower(controller)
        trajectory.command(goal, self.time)
        self._note_command(controller, goal.joint_names, bounds)

    def scale_trajectory(self, controller: str, factor: float) -> None:
        """Scale the speed of a controller's trajectories by ``factor``."""
        running = self.manager.running(controller)
        if not isinstance(running, SpeedScalable):
            raise ControlError(
                f"the speed of '{controller}' cannot be scaled: only trajectory "
                "controllers of ROS 2 scale theirs"
            )
        running.scale_speed(factor)

    def move_joints(
        self, positions: Mapping[str, float], speed: float, controller: str | None
    ) -> tuple[Goal, ...]:
        """Start smooth motions of every controller concerned at one instant, or none.

        Without a ``controller``, the joints are moved by those that claim them.
        """
        moves: Mapping[str, Mapping[str, float]]
        if controller is None:
            moves = joints_by_controller(self.manager, positions)
        else:
            moves = {controller: positions}
        planned = []
        for name, targets in moves.items():
            trajectory = self._follower(name)
            path = planned_path(trajectory, targets, speed=speed, now=self.time)
            planned.append((trajectory, motion_plan(path)))
        for name, targets in moves.items():
            self._note_command(name, targets)
        return tuple(
            self._started(trajectory.follow(plan, self.time))
            for trajectory, plan in planned
        )

    def move_joints_within(
        self, positions: Mapping[str, float], duration: float, controller: str | None
    ) -> Goal:
        """Start a motion of one controller that takes ``duration`` simulated seconds.

        It is a cubic that ends at rest; the controller's other joints keep their
        setpoints.
        """
        name = controller
        if name is None:
            moves = joints_by_controller(self.manager, positions)
            if len(moves) != 1:
                raise ControlError(
                    f"no single controller claims {', '.join(positions)}; "
                    "move them one after another"
                )
            name = next(iter(moves))
        path = timed_path(
            self._follower(name),
            positions,
            duration=max(duration, self.control_period),
            now=self.time,
        )
        goal = TrajectoryGoal(
            points=trajectory_points(path), joint_names=path.joint_names
        )
        return self.follow(name, goal)

    def steer(
        self, controller: str, positions: Mapping[str, float], speed: float
    ) -> None:
        """Replace a controller's motion by a smooth one, without a goal."""
        trajectory = self._follower(controller)
        path = planned_path(trajectory, positions, speed=speed, now=self.time)
        trajectory.command(motion_plan(path), self.time)
        self._note_command(controller, positions)

    def command_gripper(
        self,
        controller: str,
        position: float,
        max_effort: float | None = None,
        bounds: DriveLimits | None = None,
        *,
        max_velocity: float | None = None,
    ) -> Goal:
        """Start a gripper goal in joint units: [rad | m] and [N·m | N].

        Without ``bounds``, they are the controller's for ``max_effort`` and
        ``max_velocity``.
        """
        gripper = self._drivable(controller)
        if not isinstance(gripper, GripperDriver):
            raise _wrong_role(controller, gripper, Role.GRIPPER)
        bounds = bounds or gripper.limits(max_effort, max_velocity)
        goal = gripper.drive(position, max_effort, self.time, bounds)
        joint = gripper.joint.name
        self._note_command(controller, (joint,), {joint: bounds})
        return self._started(goal)

    def command_joints(self, controller: str, values: tuple[float, ...]) -> None:
        """Set the setpoints of a forwarding controller, in its joints' order."""
        forward = self._drivable(controller)
        if not isinstance(forward, CommandTaker):
            raise _wrong_role(controller, forward, Role.COMMAND)
        forward.command_joints(values)
        self._note_command(controller)
        self.manager.release_brakes(controller, self.state)

    def take_arm(self, arm: str | None, by: str, *, protected: bool = False) -> None:
        """Let a program move an arm in place of its controllers."""
        name = self.arm_motions.take(arm, by, self.state, protected=protected)
        self._note_command(name)

    def cancel(self, goal: Goal) -> None:
        """Stop the motion of an active goal; one that has ended is left alone."""
        if goal.status.is_terminal:
            return
        controller = self.manager.running(goal.controller)
        if isinstance(controller, TrajectoryFollower | GripperDriver):
            controller.cancel(goal, self.time)
        if isinstance(controller, GripperDriver):
            bounds = controller.limits(None, None)
            if bounds is not None:
                self.hardware.set_drive_limits(controller.joint.name, bounds)

    def stop_trajectories(self) -> None:
        """Stop the trajectory controllers that move a joint."""
        for status in self.manager.list():
            if not status.is_running:
                continue
            controller = self.manager.running(status.name)
            if not isinstance(controller, TrajectoryFollower):
                continue
            now = controller.query_state(self.time)
            is_there = tuple(now.positions) == controller.setpoint().target()
            if any(now.velocities) or not is_there:
                controller.command(TrajectoryGoal(points=()), self.time)

    def trajectory_controller(self, name: str) -> TrajectoryFollower:
        """Return a running trajectory controller, or raise ControlError."""
        controller = self.manager.running(name)
        if not isinstance(controller, TrajectoryFollower):
            raise _wrong_role(name, controller, Role.TRAJECTORY)
        return controller

    # ---- sensors, time, safety ------------------------------------------------------

    def start_sensor(self, sensor: ForceTorqueSensor) -> None:
        """Sample once now, and then in the tick."""
        sensor.subtract(self.hardware.payloads)
        sensor.restart(self._before, self.state, self._forces)
        self._sensors = (*self._sensors, sensor)

    def stop_sensor(self, sensor: ForceTorqueSensor) -> None:
        """Stop sampling; a sensor that is not running is left alone."""
        self._sensors = tuple(s for s in self._sensors if s is not sensor)

    def arm_samples(self) -> Mapping[str, ArmSample]:
        """Return what moves each arm, and the wrench on its tool, between two ticks."""
        program = self._program
        before = self._before if program is None else program.step_start()
        return self._samples.read(self.time, before, self.state, self._forces())

    def zero_wrench(self, arm: str | None) -> None:
        """Tare the wrench on an arm's tool in samples from now on."""
        self.arm_samples()
        self._samples.zero(arm)

    def reset(self, position: Mapping[str, float], keep_time: bool) -> None:
        """Return to the initial pose changed by ``position``, objects to their start.

        ``keep_time`` lets simulated time continue, as after ROS's reset_world.
        """
        self._start = start = joint_positions(self._model, position, self._initial)
        self.ticks = self.ticks if keep_time else 0
        self.engine.reset(start, self.time)
        self.scene.wrenches.forget()
        self.pulls.release()
        self.state = self._before = self.engine.read()
        self._commanded.clear()
        self._watch_drift()
        if self.grasp_assist is not None:
            self.grasp_assist.forget()
        self.stall_monitor.forget()
        self.grip_contacts.forget()
        self.protective_stops.forget()
        self.hardware.restart(self.state)
        self.manager.restart(self.state)
        self.arm_motions.note_restart(self.state)
        for sensor in self._sensors:
            sensor.restart(self._before, self.state, self._forces)

    def set_payload(self, arm: str | None, payload: Payload | None) -> None:
        """Let drives and sensors expect this at an arm's flange.

        None is what the description has there.
        """
        self.control_boxes.set_payload(arm, payload)
        for sensor in self._sensors:
            sensor.subtract(self.hardware.payloads)
        self._samples.note_payloads()

    def set_stopped(self, engaged: bool) -> None:
        """Brake every joint, or release the brakes; controllers then hold still."""
        if engaged == self.hardware.is_stopped:
            return
        self.hardware.set_stopped(engaged, self.state)
        self.manager.restart(self.state)
        stopped = "the emergency stop was engaged" if engaged else ""
        self.arm_motions.note_restart(self.state, stopped)
        self.arm_modes.note_emergency_stop()

    def drift(self, at_least: float = 0.0) -> float:
        """Return the largest drift of an uncommanded joint from its start [rad | m].

        ``at_least`` if that is larger, as for joints that were all commanded.
        """
        position, start = self._uncommanded(self.state.position), self._their_start
        if math.dist(position, start) <= at_least:  # no joint is further than all are
            return at_least
        largest: float = max(map(abs, map(sub, position, start)))
        return max(at_least, largest)

    def _watch_drift(self) -> None:
        """Note which joints were not commanded, and where they started."""
        names = self.hardware.interfaces.keys() - self._commanded
        indices = sorted(self.hardware.index[name] for name in names)
        self._uncommanded = joint_selector(indices)
        self._their_start = self._uncommanded(self._start)

    def _forces(self) -> tuple[Contact, ...]:
        """Return the external forces on the robot: contacts, and applied wrenches."""
        return self.engine.world.contacts() + self.scene.wrenches.contacts()

    def _drivable(self, name: str) -> Controller:
        """Return a controller that may move joints now."""
        if self.hardware.is_stopped:
            raise ControlError(
                "the emergency stop is engaged; release it before moving the robot"
            )
        return self.manager.running(name)

    def _follower(self, name: str) -> TrajectoryFollower:
        """Return a trajectory controller that may move joints now."""
        self._drivable(name)
        return self.trajectory_controller(name)

    def _note_command(
        self,
        controller: str,
        joints: Collection[str] | None = None,
        bounds: Mapping[str, DriveLimits | None] | None = None,
    ) -> None:
        """Record a command; limit the drives it moves, and lift the limits of others.

        ``joints`` are those that the goal names; None for all of the controller.
        """
        for _, claimed in self.manager.status(controller).claimed:
            if not self._commanded.issuperset(claimed):
                self._commanded.update(claimed)
                self._watch_drift()
            for joint in claimed:
                if joints is None or joint in joints:
                    self.hardware.set_drive_limits(joint, (bounds or {}).get(joint))

    def _started(self, goal: Goal) -> Goal:
        goal.explain = lambda result: self._explained(goal, result)
        self.when_goal_starts(goal)
        return goal

    def _explained(self, goal: Goal, result: Result) -> Result:
        """Return an outcome with the reason why the joints stopped, if it is known."""
        if isinstance(result, GripperResult):
            return self._with_grip(goal, result) if result.stalled else result
        if not result.is_violation:
            return result
        joints = self.manager.spec(goal.controller).joints
        touching = self._touching(self._model.joint(name).child for name in joints)
        if not touching:
            return result
        return replace(result, error_string=f"{result.error_string}; {touching}")

    def _with_grip(self, goal: Goal, result: GripperResult) -> GripperResult:
        """Return the outcome of a stalled gripper, with what stopped it."""
        (joint,) = self.manager.spec(goal.controller).joints
        holds = any(
            gripper.joint == joint and gripper.name in self.grip_contacts.gripping
            for gripper in self._model.grippers
        )
        why = self.gripper_obstacle(joint)
        text = f"stopped by what it holds ({why})" if holds else f"blocked ({why})"
        return replace(result, holds=holds, error_string=text)

    def gripper_obstacle(self, joint: str) -> str:
        """Return what stops the gripper that ``joint`` drives."""
        touching = self._touching((self._model.joint(joint).parent,))
        return touching or "no contact: its stop, or the load"

    def _touching(self, roots: Iterable[str]) -> str:
        """Return what the links from ``roots`` on touch; empty for nothing."""
        links = {link for root in roots for link in self._model.links_from(root)}
        contacts = self.engine.world.contacts()
        return contacts_text(external_contacts(frozenset(links), contacts))


def _whole_multiple(period: float, dt: float) -> int:
    """Return how many steps of ``dt`` make ``period``, or raise ConfigError."""
    if 0.0 < period < math.inf:
        n_steps = round(period / dt)
        if n_steps and math.isclose(n_steps * dt, period, rel_tol=1e-9):
            return n_steps
    raise ConfigError(
        f"control period {period} s is not a multiple of the engine's step {dt} s"
    )


def _wrong_role(name: str, controller: Controller, wanted: Role) -> ControlError:
    return ControlError(
        f"controller '{name}' is a {type(controller).__name__}; "
        f"this needs a {KIND_OF[wanted]}"
    )
