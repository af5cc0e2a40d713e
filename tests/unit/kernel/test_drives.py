"""The compiled drives against those of Python, bit by bit."""

from __future__ import annotations

import ctypes
import math
import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pytest
from promised import require_kernel
from skew_robot import build_model

from tool0.description.bodies import STANDARD_GRAVITY
from tool0.description.config import DescriptionConfig
from tool0.description.drive_limits import DriveLimits
from tool0.description.loading import assemble, load_description
from tool0.description.model import Interface, RobotModel, SafetyController
from tool0.hardware.engine import JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.drives import NativeDrives

Efforts = Callable[[NativeDrives, list[float], JointState], list[float] | None]
Change = Callable[[RobotHardware, JointState], None]


@pytest.fixture(scope="module")
def efforts() -> Efforts:
    """Return the compiled function; it returns None where Python must step."""
    function = require_kernel().drives_efforts

    def run(
        drives: NativeDrives, command: list[float], state: JointState
    ) -> list[float] | None:
        def array(values: list[float]) -> Any:
            return (ctypes.c_double * len(values))(*values)

        effort = array(state.effort)
        is_event = function(
            ctypes.byref(drives.struct),
            array(command),
            array(state.position),
            array(state.velocity),
            effort,
        )
        return None if is_event else effort[:]

    return run


def hexes(values: list[float]) -> list[str]:
    return [float(value).hex() for value in values]


def driven_by(model: RobotModel, *interfaces: Interface) -> RobotModel:
    """Return the model with these interfaces in turn."""
    transmissions = tuple(
        replace(transmission, interfaces=(interfaces[i % len(interfaces)],))
        for i, transmission in enumerate(model.transmissions)
    )
    return replace(model, transmissions=transmissions)


def offering_all(model: RobotModel) -> RobotModel:
    """Return the model with drives that each offer every interface."""
    transmissions = tuple(
        replace(transmission, interfaces=tuple(Interface))
        for transmission in model.transmissions
    )
    return replace(model, transmissions=transmissions)


def claim_again(
    hardware: RobotHardware, chosen: Mapping[str, Interface], state: JointState
) -> None:
    """Give joints to controllers, which may have had them before."""
    hardware.release(list(chosen), state)
    for name, interface in chosen.items():
        hardware.claim([name], interface, state)


def claim_all(hardware: RobotHardware, state: JointState) -> None:
    first = {name: offered[0] for name, offered in hardware.interfaces.items()}
    claim_again(hardware, first, state)


def softened(model: RobotModel) -> RobotModel:
    """Return the model with soft limits, every other one without k_velocity."""
    joints = tuple(
        replace(
            joint,
            safety=SafetyController(
                soft_lower_limit=joint.limits.lower + 0.15,
                soft_upper_limit=joint.limits.upper - 0.15,
                k_position=20.0,
                k_velocity=15.0 * (i % 2),
            ),
        )
        for i, joint in enumerate(model.joints)
    )
    return replace(model, joints=joints)


def compensated(model: RobotModel) -> RobotModel:
    """Return the model with drives that all compensate gravity."""
    transmissions = tuple(
        replace(transmission, gravity_compensation=True)
        for transmission in model.transmissions
    )
    return replace(model, transmissions=transmissions)


def cell() -> RobotModel:
    robots = ["left=ur5+2f85@0,0.6,0", "right=ur10e+hande@0,-0.6,0,0,0,1.2"]
    return load_description(DescriptionConfig(robots=robots)).model


MODELS: dict[str, Callable[[], RobotModel]] = {
    "ur5+2f85": lambda: assemble("ur5", "2f85").model,
    "cell": cell,
    "linkage": lambda: assemble("ur5", "2f85", gripper_model="linkage").model,
    "skew": lambda: build_model(Interface.EFFORT),
    "position": lambda: driven_by(assemble().model, Interface.POSITION),
    "velocity": lambda: driven_by(assemble("ur5", "hande").model, Interface.VELOCITY),
    "mixed": lambda: driven_by(compensated(cell()), *Interface),
    "soft": lambda: softened(assemble().model),
    "soft-servos": lambda: driven_by(
        softened(assemble("ur5", "hande").model), Interface.POSITION, Interface.VELOCITY
    ),
    "compensated": lambda: compensated(assemble().model),
    "several": lambda: offering_all(compensated(assemble().model)),
}
STEPS_PER_COMMAND = {"several": 8, "soft-servos": 2}
GRAVITY = {"skew": (1.0, -2.0, -9.0), "soft": (0.0, 0.0, 9.81)}


class Script:
    """Random states, commands and requests: the same for all that take part."""

    def __init__(self, model: RobotModel, hardware: RobotHardware, seed: str) -> None:
        self.random = random.Random(seed)
        self.model, self.hardware = model, hardware
        self.limits = [model.joint(name).limits for name in hardware.joint_names]
        n = len(self.limits)
        self.state = JointState(0.0, [0.1] * n, [0.0] * n, [0.0] * n)
        self.command = [0.0] * n

    def advance(self, applied: list[float]) -> None:
        """Move somewhere: mostly smoothly, at rest, or beyond any limit."""
        draw, position, velocity = self.random, [], []
        for q, qd, limits in zip(*self.state[1:3], self.limits, strict=True):
            top = min(limits.velocity, 10.0)
            qd = draw.choice([qd, qd, qd, 0.0, draw.gauss(0.0, 0.01), -qd])  # noqa: PLW2901
            if draw.random() < 0.05:
                qd = draw.choice([-1, 1]) * top * draw.uniform(0.0, 1.3)  # noqa: PLW2901
            q = q + 1e-3 * qd  # noqa: PLW2901
            if draw.random() < 0.01:
                low, high = max(limits.lower, -7.0), min(limits.upper, 7.0)
                q = draw.choice([low, high, draw.uniform(low, high), -0.0])  # noqa: PLW2901
                q += draw.gauss(0.0, 1e-3)  # noqa: PLW2901
            position.append(q)
            velocity.append(qd)
        time = self.state.time + 1e-3
        self.state = JointState(time, position, velocity, applied)
        if draw.random() < 0.3:
            for name, i in self.hardware.index.items():
                if name in self.hardware.interfaces:
                    self.command[i] = self._some_command(name, i)

    def _some_command(self, name: str, i: int) -> float:
        draw, limits = self.random, self.limits[i]
        interface = self.hardware.claimed.get(name, self.hardware.interfaces[name][0])
        if interface is Interface.POSITION:
            return self.state.position[i] + draw.gauss(0.0, 0.02)
        if interface is Interface.VELOCITY:
            return draw.gauss(0.0, 0.5 * min(limits.velocity, 10.0))
        return draw.gauss(0.0, 0.7 * min(limits.effort, 200.0))

    def change(self) -> Change:
        """Return what somebody requests between two steps."""
        draw, driven = self.random, list(self.hardware.interfaces)
        some = draw.sample(driven, draw.randint(1, len(driven)))
        chosen = {name: draw.choice(self.hardware.interfaces[name]) for name in driven}
        few = {name: chosen[name] for name in some}
        engaged = draw.random() < 0.2
        return draw.choice(
            [
                lambda hardware, state: claim_again(hardware, few, state),
                lambda hardware, state: claim_again(hardware, chosen, state),
                lambda hardware, state: claim_again(hardware, chosen, state),
                lambda hardware, state: hardware.release(some, state),
                lambda hardware, state: hardware.set_stopped(engaged, state),
                lambda hardware, state: hardware.restart(state),
            ]
        )

    def goal(self) -> tuple[str, DriveLimits | None]:
        """Return a joint, mostly a gripper's, and limits for its drive."""
        draw, grippers = self.random, self.model.grippers
        joints, chosen = list(self.hardware.interfaces), DriveLimits
        if not grippers:
            return draw.choice(joints), None
        gripper = draw.choice(grippers)
        joint = gripper.joint if draw.random() < 0.8 else draw.choice(joints)
        limits: DriveLimits | None = draw.choice(
            [
                None,
                chosen(gripper=gripper, effort=draw.uniform(0.1, 10.0)),
                chosen(
                    gripper=gripper,
                    speed=draw.choice([None, draw.uniform(*gripper.speed)]),
                    force=draw.choice([None, draw.uniform(*gripper.force)]),
                ),
            ]
        )
        return joint, limits


def pair(name: str) -> tuple[RobotModel, RobotHardware, RobotHardware]:
    """Return a model, and its drives twice."""
    model = MODELS[name]()
    names = [joint.name for joint in model.movable_joints]
    random.Random(name).shuffle(names)  # an engine may have its own order
    gravity = GRAVITY.get(name, STANDARD_GRAVITY)
    first, second = (
        RobotHardware(model, names, 1e-3, gravity=gravity) for _ in range(2)
    )
    for hardware in (first, second):
        hardware.set_steps_per_command(STEPS_PER_COMMAND.get(name, 1))
    return model, first, second


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_efforts_are_those_of_python_bit_by_bit(name: str, efforts: Efforts) -> None:
    model, reference, hardware = pair(name)
    script = Script(model, reference, name)
    drives, draw = NativeDrives(hardware), random.Random(f"{name} steps")
    n_native, n_steps = 0, 1500
    for step in range(n_steps):
        state = script.state
        if step == 5 or draw.random() < 0.006:  # what somebody requests
            change = script.change()
            drives.store()
            for each in (reference, hardware):
                change(each, state)
            script.command = reference.command.copy()
            drives.load()
        if draw.random() < 0.01:  # in a batch, the hardware knows nothing of it
            joint, limits = script.goal()
            reference.set_drive_limits(joint, limits)
            drives.set_drive_limits(hardware.index[joint], limits)
        if draw.random() < 0.01:  # meanwhile the hardware continues with another copy
            drives.store()
            other = NativeDrives(hardware)
            hardware.set_drive_limits(*script.goal())
            for _ in range(draw.randint(1, 70)):
                hardware.efforts(state._replace(velocity=[0.0] * len(state.velocity)))
            drives = other
        reference.command[:] = script.command
        expected = reference.efforts(state)
        actual = efforts(drives, script.command, state)
        n_native += actual is not None
        if actual is None:
            drives.store()
            hardware.command[:] = script.command
            actual = hardware.efforts(state)
            drives.load()
        assert hexes(actual) == hexes(expected), f"step {step}"
        script.advance(actual)
    drives.store()
    assert (hardware.setup, hardware.state) == (reference.setup, reference.state)
    assert hardware.drive_limits == reference.drive_limits
    assert n_native > 0.7 * n_steps


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", ["ur5+2f85", "position"])
def test_what_is_not_finite_is_left_to_python(
    name: str, value: float, efforts: Efforts
) -> None:
    model, hardware, _ = pair(name)
    claim_all(hardware, Script(model, hardware, name).state)
    state = Script(model, hardware, name).state
    hardware.efforts(state)
    drives, last = NativeDrives(hardware), len(hardware.command) - 1
    before = hardware.state
    for k in range(4):
        rows = [hardware.command.copy(), *(row.copy() for row in state[1:])]
        rows[k][last] = value
        command, position, velocity, effort = rows
        bad = JointState(0.0, position, velocity, effort)
        assert efforts(drives, command, bad) is None
    drives.store()
    assert hardware.state == before
    assert efforts(drives, hardware.command, state) is not None


def test_copies_are_independent(efforts: Efforts) -> None:
    model, hardware, _ = pair("mixed")
    script = Script(model, hardware, "copies")
    claim_all(hardware, script.state)
    hardware.efforts(script.state)
    start, copy, other = (NativeDrives(hardware) for _ in range(3))
    (gripper, *_) = model.grippers
    joint, command = hardware.index[gripper.joint], [5.0] * len(hardware.command)

    def run(drives: NativeDrives) -> list[list[str]]:
        state = script.state
        found = []
        for k in range(40):
            velocity = [0.01 * k] * len(state.velocity)
            effort = efforts(drives, command, state._replace(velocity=velocity))
            assert effort is not None
            found.append(hexes(effort))
        return found

    first = run(copy)
    assert run(other) == first
    copy = NativeDrives(hardware)
    limits = DriveLimits(gripper=gripper, effort=0.1, speed=gripper.speed[0])
    copy.set_drive_limits(joint, limits)
    assert run(copy) != first
    assert run(start) == first
    copy.store()
    assert hardware.drive_limits == {gripper.joint: limits}
    start.store()
    assert hardware.drive_limits == {}
