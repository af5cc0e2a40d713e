"""The core of a simulation: engine, drives, controllers, arms and sensors."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from operator import sub
from typing import final

from tool0.control.manager import ControllerManager, SavedController
from tool0.description.forward_kinematics import joint_positions
from tool0.description.model import Interface, RobotModel
from tool0.description.payload import Payload
from tool0.description.scene import Scene
from tool0.description.scene_state import Contact
from tool0.errors import ConfigError, ControlError
from tool0.hardware.engine import Engine, JointState, joint_selector
from tool0.hardware.own_drives import OwnDrives
from tool0.hardware.robot_hardware import RobotHardware, SavedDrives
from tool0.kernel.kernel import Kernel
from tool0.kernel.program import Ended, TickProgram
from tool0.protocol.state import ArmSample
from tool0.sensing.force_torque import ForceTorqueSensor
from tool0.sensing.grasp import GraspAssist
from tool0.sensing.grip_contacts import GripContacts
from tool0.sensing.stalls import StallMonitor
from tool0.simulation.arms.arms import Arms
from tool0.simulation.pull_springs import PullSprings
from tool0.simulation.scene_objects import SceneObjects
from tool0.simulation.wanted import WantedMotions


@final
@dataclass(frozen=True, slots=True)
class SavedCore:
    """State of a core at one point in time, excluding the state of its engine."""

    controllers: Mapping[str, SavedController]
    drives: SavedDrives
    ticks: int
    state: JointState
    before: JointState
    start: list[float]
    commanded: frozenset[str]


@final
class Core:
    """The core of a simulation; the loop executes its ticks.

    An Executor moves the robot of the core.

    Only the thread that executes the tick may use ``Core``.
    """

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
        """Set the robot to its initial pose.

        ``initial_position`` [rad | m] has shape (n_joints,), in the order of the
        engine.  ``scene`` is the scene for which the engine was created.
        ``control_period`` [s] must be a multiple of the engine's step; the default is
        the engine's step.
        """
        self.model = model
        self.engine = engine
        self.hardware = hardware
        self.manager = manager
        self.scene = SceneObjects(model, engine, scene or Scene())
        self.pulls = PullSprings(model, engine.joint_names, self.scene.wrenches)
        self.arms = Arms(model, engine, hardware, manager)
        self.own_drives = engine if isinstance(engine, OwnDrives) else None
        """Drives of a real robot; None for a simulated robot."""
        self._wanted = WantedMotions(model, hardware, manager, self.arms)
        self.ticks = 0
        self.control_period = engine.dt if control_period is None else control_period
        self._steps_per_tick = _whole_multiple(self.control_period, engine.dt)
        hardware.set_steps_per_command(self._steps_per_tick)
        self._kernel = Kernel(engine, hardware, manager, self.control_period)
        self._program: TickProgram | None = None
        """Program that executes the ticks; None unless the program holds the state of
        the controllers and drives."""
        self._brakes: Mapping[int, float] = {}
        self._rotors: Mapping[int, float] = {}
        """Brakes and rotor inertias that are currently set in the engine, by joint."""
        self.initial_position = list(initial_position)
        """Initial positions of the joints [rad | m], shape (n_joints,)."""
        self._start = self.initial_position
        self._commanded: set[str] = set()
        self._watch_drift()
        self._sensors: tuple[ForceTorqueSensor, ...] = ()
        self.grasp_assist = GraspAssist(model, engine) if grasp_assist else None
        self.stall_monitor = StallMonitor(model, hardware)
        self.grip_contacts = GripContacts(model, engine.joint_names)
        engine.reset(self.initial_position)
        self.state: JointState = engine.read()
        self._before = self.state
        """The state at the start of the last physics step."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.ticks * self.control_period

    def newest_command(self) -> list[float]:
        """Return the last command of each joint, in the unit of its interface.

        The list must not be modified, and is valid until the next tick.
        """
        program = self._program
        return self.hardware.command if program is None else program.command

    def wanted_positions(self) -> Mapping[str, float]:
        """Return the setpoint of each joint under position control [rad | m]."""
        command, hardware = self.newest_command(), self.hardware
        wanted = {
            name: command[hardware.index[name]]
            for name, interface in hardware.claimed.items()
            if interface is Interface.POSITION
        }
        for name, setpoint in self.manager.setpoints().items():
            if self.manager.is_overruled(name):
                continue
            models, splines = setpoint.joint_models, setpoint.splines
            for joint, spline in zip(models, splines, strict=True):
                wanted[joint.name] = spline.sample(setpoint.time).position
        return wanted

    def tick(self) -> None:
        """Update the controllers once and advance by one control period."""
        self.sync_from_kernel()
        state = self.state
        if not self.pulls.is_idle:
            self.pulls.tick(state)
        self.scene.wrenches.tick(self.time)
        self.arms.tick(state, self.control_period)
        self._set_mechanics()
        self.manager.update(state, self.control_period)
        self._finish_tick(state, self._steps_per_tick)

    def _set_mechanics(self) -> None:
        """Update the engine's brakes and rotors."""
        brakes = self.hardware.brakes
        if brakes is not self._brakes:
            self._brakes = brakes
            self.engine.set_brakes(brakes)
        rotors = self.hardware.rotors
        if rotors is not self._rotors:
            self._rotors = rotors
            self.engine.set_rotors(rotors)

    def _finish_tick(self, state: JointState, n_steps: int) -> None:
        """Execute the last ``n_steps`` steps of a tick, starting from ``state``."""
        engine, hardware, before = self.engine, self.hardware, self._before
        if self.own_drives is not None:
            self.own_drives.follow(self._wanted.look(state))
            self._before = state
            engine.step()
            self.state = engine.read()
            self.ticks += 1
            self.arms.follow(self.own_drives.report, self.state)
            return
        for _ in range(n_steps):
            before = state
            engine.write(hardware.efforts(state))
            engine.step()
            state = engine.read()
        self.state, self._before = state, before
        self.ticks += 1
        for sensor in self._sensors:
            sensor.tick(before, state, self._forces_on)

    def advance(self, most: int) -> int:
        """Tick one to ``most`` times, and return the number of ticks.

        The kernel executes as many ticks as possible.  ``advance`` returns after a tick
        in Python.
        """
        most = self.scene.wrenches.quiet_ticks(self.time, self.control_period, most)
        program = None if self.engine.stepper is None or not most else self.program()
        stepper = self.engine.stepper  # replaced if brakes changed
        if program is None or stepper is None:
            self.tick()
            return 1
        for sensor in self._sensors:
            most = min(most, sensor.ticks_left)
        return self.apply_kernel_result(*program.run(most, stepper))

    def program(self) -> TickProgram | None:
        """Load the next ticks into the kernel, and return the program.

        The result is None if only Python can execute the ticks.
        """
        if self._program is None and self.pulls.is_idle and self.arms.is_idle:
            self._set_mechanics()
            self._program = self._kernel.load(self.state)
        return self._program

    def apply_kernel_result(self, result: Ended, done: int) -> int:
        """Process ``done`` kernel ticks, and return the total number of ticks.

        After an event, Python executes one additional tick.
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
                sensor.tick(program.step_start(), state, self._forces_on, done)
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
        """Restore the state of controllers and drives if the kernel holds it.

        Call ``sync_from_kernel`` before controllers or drives are read or changed
        between two ticks.
        """
        program, self._program = self._program, None
        if program is not None:
            if program.has_stepped:
                self._before = program.step_start()
            program.store()

    @property
    def last_step(self) -> tuple[JointState, JointState]:
        """States at the start and at the end of the last physics step."""
        program = self._program
        if program is not None and program.has_stepped:
            return program.step_start(), self.state
        return self._before, self.state

    def check_contacts(self) -> None:
        """Detect grips, and joints that push without moving.

        ``check_contacts`` is called between two ticks.
        """
        if self.own_drives is not None:
            self.grip_contacts.note(self.own_drives.gripping)
            return
        contacts = self.engine.world.contacts
        self.stall_monitor.look(self.state, contacts, self.wanted_positions)
        self.grip_contacts.look(self.state, contacts)

    # ---- sensors, time, safety ------------------------------------------------------

    def start_sensor(self, sensor: ForceTorqueSensor) -> None:
        """Sample a sensor immediately, and then in each tick."""
        sensor.subtract(self.hardware.payloads)
        sensor.restart(self._before, self.state, self._forces_on)
        self._sensors = (*self._sensors, sensor)

    def stop_sensor(self, sensor: ForceTorqueSensor) -> None:
        """Stop sampling a sensor; do nothing if the sensor is not running."""
        self._sensors = tuple(s for s in self._sensors if s is not sensor)

    def arm_samples(self) -> Mapping[str, ArmSample]:
        """Return the motion and the tool wrench of each arm between two ticks."""
        return self.arms.samples(self.time, *self.last_step, self._forces())

    def zero_wrench(self, arm: str | None) -> None:
        """Tare the tool wrench of an arm for all later samples."""
        self.arm_samples()
        self.arms.find(arm).zero_wrench()

    def reset(self, position: Mapping[str, float], keep_time: bool) -> None:
        """Reset the robot and the objects to their initial poses.

        ``position`` replaces the initial positions of some joints.  If ``keep_time`` is
        True, simulated time continues, as it does after reset_world in ROS.
        """
        self._start = start = joint_positions(
            self.model, position, self.initial_position
        )
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
        self.hardware.restart(self.state)
        self.manager.restart(self.state)
        for arm in self.arms:
            arm.note_restart(self.state)
        for sensor in self._sensors:
            sensor.restart(self._before, self.state, self._forces_on)

    def saved(self) -> SavedCore:
        """Return the state of controllers, drives and clock, without the engine.

        Raises:
            ControlError: If a controller or an arm is in a state that cannot be saved.
        """
        self.sync_from_kernel()
        is_idle = self.scene.wrenches.is_idle and self.pulls.is_idle
        if not (is_idle and self.arms.is_idle):
            raise ControlError(
                "the state cannot be saved while wrenches, pulls or modes of an arm act"
            )
        return SavedCore(
            self.manager.saved(),
            self.hardware.saved(),
            self.ticks,
            self.state,
            self._before,
            self._start,
            frozenset(self._commanded),
        )

    def resume(self, saved: SavedCore) -> None:
        """Continue with a saved state of the same controllers.

        The state of the engine must be restored separately.
        """
        self.sync_from_kernel()
        self.manager.resume(saved.controllers)
        self.hardware.resume(saved.drives)
        self.ticks, self.state, self._before = saved.ticks, saved.state, saved.before
        self._start, self._commanded = saved.start, set(saved.commanded)
        self._watch_drift()
        self.stall_monitor.forget()
        self.grip_contacts.forget()

    def set_payload(self, arm: str | None, payload: Payload | None) -> None:
        """Set the payload that drives and sensors assume at an arm's flange.

        If ``payload`` is None, the payload of the description is used.
        """
        self.arms.find(arm).set_payload(payload)
        for sensor in self._sensors:
            sensor.subtract(self.hardware.payloads)

    def set_stopped(self, engaged: bool) -> None:
        """Engage or release the brakes of every joint.

        After the change, the controllers hold their joints.
        """
        if engaged == self.hardware.is_stopped:
            return
        self.hardware.set_stopped(engaged, self.state)
        self.manager.restart(self.state)
        stopped = "the emergency stop was engaged" if engaged else ""
        for arm in self.arms:
            arm.note_restart(self.state, stopped)

    def note_commanded(self, joints: Collection[str]) -> None:
        """Exclude ``joints`` from the computation of the drift."""
        if not self._commanded.issuperset(joints):
            self._commanded.update(joints)
            self._watch_drift()

    def drift(self, at_least: float = 0.0) -> float:
        """Return the largest drift of an uncommanded joint from its start position.

        The result [rad | m] is ``at_least`` if it is larger than the drift, for example
        because all joints were commanded.
        """
        position, start = self._uncommanded(self.state.position), self._their_start
        if math.dist(position, start) <= at_least:  # bounds each joint
            return at_least
        largest: float = max(map(abs, map(sub, position, start)))
        return max(at_least, largest)

    def _watch_drift(self) -> None:
        """Store the uncommanded joints and their start positions."""
        names = self.hardware.interfaces.keys() - self._commanded
        indices = sorted(self.hardware.index[name] for name in names)
        self._uncommanded = joint_selector(indices)
        self._their_start = self._uncommanded(self._start)

    def _forces(self) -> tuple[Contact, ...]:
        """Return the external forces on the robot: contacts and applied wrenches."""
        return self.engine.world.contacts() + self.scene.wrenches.contacts()

    def _forces_on(self, links: frozenset[str]) -> tuple[Contact, ...]:
        """Return the external forces, without contacts if no body touches ``links``."""
        if self.engine.world.is_touched(links):
            return self._forces()
        return self.scene.wrenches.contacts()


def _whole_multiple(period: float, dt: float) -> int:
    """Return the number of steps ``dt`` in ``period``, or raise ConfigError."""
    if 0.0 < period < math.inf:
        n_steps = round(period / dt)
        if n_steps and math.isclose(n_steps * dt, period, rel_tol=1e-9):
            return n_steps
    raise ConfigError(
        f"control period {period} s is not a multiple of the engine's step {dt} s"
    )
