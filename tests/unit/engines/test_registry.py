"""Engines by name: their options, and a third engine that is registered here."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import pytest

import tool0
from tool0.description.loading import assemble
from tool0.description.robot import RobotDescription
from tool0.description.scene import SceneObject
from tool0.description.scene_state import Contact, ObjectState
from tool0.description.transform import Vector3
from tool0.engines import registry
from tool0.engines.registry import (
    EngineDefinition,
    EngineSettings,
    engine_definition,
    engine_names,
    make_engine,
    register_engine,
)
from tool0.errors import ConfigError, EngineError, EngineUnavailableError
from tool0.hardware.engine import Engine, JointState, Wrench


@final
class ToyWorld:
    """Nothing falls, and there are no objects."""

    gravity: Vector3 = (0.0, 0.0, 0.0)
    ground = None

    def object_states(self) -> tuple[ObjectState, ...]:
        return ()

    def contacts(self) -> tuple[Contact, ...]:
        return ()

    def is_touched(self, links: frozenset[str]) -> bool:
        return False

    def spawn(self, item: SceneObject) -> None:
        raise EngineError(f"no object '{item.name}' can be here")

    def delete(self, name: str) -> None:
        raise EngineError(f"there is no object '{name}'")

    def place(self, state: ObjectState) -> None:
        self.delete(state.name)

    def center_of_mass(self, name: str) -> Vector3:
        raise EngineError(f"'{name}' has no mass")

    def hold_wrenches(self, wrenches: Mapping[str, Wrench]) -> None:
        """Have none."""

    def attach(self, name: str, link: str) -> None:
        self.delete(name)

    def detach(self, name: str) -> None:
        """Leave alone what is not there."""


@final
class ToyEngine:
    """Every joint is one mass on a damper, whatever carries it."""

    name = "toy"
    stepper = None
    has_rotors = False

    def __init__(self, joint_names: tuple[str, ...], dt: float, mass: float) -> None:
        self.joint_names = joint_names
        self.dt = dt
        self.world = ToyWorld()
        self.mass = mass
        self._braked: frozenset[int] = frozenset()
        self.reset([0.0] * len(joint_names))

    def reset(self, position: Sequence[float], time: float = 0.0) -> None:
        self._start, self._steps = time, 0
        self._position = list(position)
        self._velocity = self._effort = [0.0] * len(self._position)

    def read(self) -> JointState:
        time = self._start + self._steps * self.dt
        return JointState(time, self._position, self._velocity, self._effort)

    def set_brakes(self, torques: Mapping[int, float]) -> None:
        self._braked = frozenset(torques)

    def set_rotors(self, inertias: Mapping[int, float]) -> None:
        """Have none."""

    def write(self, effort: Sequence[float]) -> None:
        self._effort = list(effort)

    def step(self) -> None:
        dt, mass = self.dt, self.mass
        state = list(zip(self._position, self._velocity, self._effort, strict=True))
        self._velocity = [
            0.0 if i in self._braked else (mass * v + u * dt) / (mass + 20.0 * dt)
            for i, (_, v, u) in enumerate(state)
        ]
        self._position = [
            q + v * dt for (q, _, _), v in zip(state, self._velocity, strict=True)
        ]
        self._steps += 1

    def close(self) -> None:
        """Nothing to end."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ToyOptions:
    mass: float = 1.0
    is_red: bool = False


def create(
    description: RobotDescription, settings: EngineSettings, options: ToyOptions
) -> Engine:
    names = tuple(joint.name for joint in description.model.movable_joints)
    return ToyEngine(names, settings.dt, options.mass)


TOY = EngineDefinition(options=ToyOptions, create=create)


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(registry, "_ENGINES", dict(registry._ENGINES))
    register_engine("toy", TOY)
    return "toy"


def test_a_robot_is_brought_up_on_a_registered_engine(toy: str) -> None:
    simulation = tool0.SimulationConfig(engine=toy, dt=0.002)
    with tool0.bringup(simulation=simulation, realtime=False, gripper=None) as robot:
        assert isinstance(robot.engine, ToyEngine)
        assert toy in engine_names()
        target = robot.joint_state.position["elbow_joint"] + 0.1
        robot.move_joints({"elbow_joint": target})
        robot.run(2.0)
        assert robot.joint_state.position["elbow_joint"] == pytest.approx(
            target, abs=0.05
        )
        assert robot.time == pytest.approx(2.0)


def test_torques_need_an_engine_with_rotors(toy: str) -> None:
    simulation = tool0.SimulationConfig(engine=toy)
    with tool0.bringup(simulation=simulation, realtime=False, gripper=None) as robot:
        motion = robot.arm.motion
        motion.take()
        with pytest.raises(tool0.ControlError, match="'toy' has no torque control"):
            motion.drive_torques([0.0] * 6)
        assert motion.state.mode == "hold"


def test_options_reach_the_engine_or_keep_their_defaults(toy: str) -> None:
    assert engine_definition(toy).options is ToyOptions
    for options, mass in (({}, 1.0), ({"mass": 3.0}, 3.0)):
        engine = make_engine(toy, assemble("ur5", None), options=options)
        assert isinstance(engine, ToyEngine)
        assert engine.mass == mass
        assert engine.dt == 0.001


@pytest.mark.parametrize(
    ("name", "own"),
    [("toy", ["mass", "is_red"]), ("gazebo", ["world", "gui"]), ("mujoco", [])],
)
def test_an_option_that_an_engine_does_not_have_is_refused(
    toy: str, name: str, own: list[str]
) -> None:
    with pytest.raises(ConfigError) as error:
        make_engine(name, assemble("ur5", None), options={"colour": "red"})
    for word in ("colour", name, *own):
        assert word in str(error.value)


def test_an_unknown_engine_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(EngineUnavailableError) as error:
        make_engine("mojuco", assemble("ur5", None))
    assert "'mujoco'" in str(error.value)


def test_gazebo_refuses_loops() -> None:
    description = assemble("ur5", "2f85", gripper_model="linkage")
    with pytest.raises(ConfigError) as error:
        make_engine("gazebo", description)
    assert description.model.loops[0].name in str(error.value)


def test_listing_options_imports_no_simulator() -> None:
    program = """
import sys
from tool0.engines.registry import engine_definition, engine_names
assert [engine_definition(name).options.__name__ for name in engine_names()]
assert not sys.modules.keys() & {"mujoco", "tool0.engines.gazebo.engine"}
"""
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60.0)
