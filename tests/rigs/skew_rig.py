"""A small robot with controllers, as core and as loop, for tests of the runtime."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakKeyDictionary

from skew_robot import build_model

from tool0.control.config import ControllerConfig
from tool0.control.manager import ControllerManager, Strictness
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Interface
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.bus import Bus
from tool0.protocol.goals import Goal
from tool0.protocol.trajectories import TrajectoryPoint
from tool0.simulation.core import Core
from tool0.simulation.executor import Executor
from tool0.simulation.loop import Loop

_EXECUTORS: WeakKeyDictionary[Core, Executor] = WeakKeyDictionary()
START = [0.3, -0.2, 0.05, -0.5 * -0.2 + 0.2]
YAML = """
arm:
  type: position_controllers/JointTrajectoryController
  joints: [lift, bend]
slider:
  type: position_controllers/JointPositionController
  joint: slide
group:
  type: position_controllers/JointGroupPositionController
  joints: [lift, bend]
states:
  type: joint_state_controller/JointStateController
  publish_rate: 100
"""


def build_core(
    control_period: float | None = None, started: tuple[str, ...] = ("arm",)
) -> Core:
    """Return a core whose controllers are loaded, and ``started`` running."""
    model = build_model(Interface.POSITION)
    engine = MujocoEngine(model, ground=None)
    hardware = RobotHardware(model, engine.joint_names, engine.dt)
    manager = ControllerManager(
        hardware, ControllerConfig.from_text(YAML), model.joint_by_name
    )
    core = Core(
        model=model,
        engine=engine,
        hardware=hardware,
        manager=manager,
        initial_position=START,
        control_period=control_period,
    )
    for name in ("arm", "slider", "group", "states"):
        core.manager.load(name)
    switch(core, start=started)
    return core


def switch(core: Core, start: Sequence[str] = (), stop: Sequence[str] = ()) -> None:
    """Stop and start controllers."""
    core.manager.switch(start, stop, Strictness.STRICT, core.state)


def executor(core: Core) -> Executor:
    """Return the one executor of a core."""
    return _EXECUTORS.setdefault(core, Executor(core))


def build_loop(core: Core, **options: object) -> tuple[Loop, Bus]:
    """Return a loop over ``core`` that runs only when asked, and its bus."""
    bus = Bus()
    return Loop(executor(core), bus, **options), bus  # type: ignore[arg-type]


def follow(core: Core, positions: Sequence[float], duration: float) -> Goal:
    """Send the arm to ``positions``, and return the goal."""
    point = TrajectoryPoint(positions, time_from_start=duration)
    return executor(core).follow("arm", TrajectoryGoal(points=[point]))
