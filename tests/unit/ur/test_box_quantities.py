"""What a control box computes about its arm, compared while the arm moves."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from ur_box_rig import control_box

import tool0
from tool0.devices.rtde_packets import LENGTHS
from tool0.errors import ControlError
from tool0.protocol.arm_motion import ReturnArm, TakeArm
from tool0.ur.control_box import UrControlBox
from tool0.ur.moves import Moves
from tool0.ur.rtde.inputs import InputRecipe
from tool0.ur.rtde.outputs import OUTPUTS, OutputRecipe
from tool0.ur.rtde_control.commands import Commands
from tool0.ur.rtde_control.exchange import Exchange
from tool0.ur.tool_contact import ToolHistory


@pytest.fixture(scope="module")
def robot() -> Any:
    with tool0.bringup(arm="ur5e", realtime=True) as robot:
        yield robot


def values(box: UrControlBox, name: str) -> Any:
    return np.array(OUTPUTS[name].read(box))


async def while_moving(
    robot: tool0.Robot, take: Callable[[UrControlBox], Any]
) -> list[Any]:
    """Return what is taken at fifty updates in the middle of a motion.

    Its speed is steady there, as the physics computes positions from the speeds at the
    ends of its steps.
    """
    async with control_box(robot) as box:
        goals = {"elbow_joint": 2.2, "shoulder_lift_joint": -1.0}
        robot.move_joints(goals, speed=0.1)
        await box.until(
            lambda: (
                min(map(abs, box.qd[1:3])) > 0.2
                and max(map(abs, box.target_qdd)) < 0.01
            )
        )
        taken = []
        for _ in range(50):
            taken.append(take(box))
            await box.next_update()
        return taken


def test_speeds_are_the_derivatives_of_positions(robot: tool0.Robot) -> None:
    def take(box: UrControlBox) -> Any:
        return (
            box.time,
            np.array(box.tcp_pose()[:3]),
            np.array(box.tcp_speed()[:3]),
            values(box, "elbow_position"),
            values(box, "elbow_velocity"),
        )

    columns = zip(*asyncio.run(while_moving(robot, take)), strict=True)
    time, tcp, tcp_speed, elbow, elbow_speed = map(np.array, columns)
    elapsed = np.diff(time)
    near = elapsed < 0.005  # a busy process leaves out updates
    assert near.sum() > 10
    for position, speed in ((tcp, tcp_speed), (elbow, elbow_speed)):
        slope = (np.diff(position, axis=0) / elapsed[:, None])[near]
        middle = (0.5 * (speed[1:] + speed[:-1]))[near]
        assert np.abs(speed).max() > 0.05
        np.testing.assert_allclose(slope, middle, atol=5e-3)


def test_accelerations_are_the_derivatives_of_speeds(robot: tool0.Robot) -> None:
    async def taken() -> list[Any]:
        async with control_box(robot) as box:
            await box.call(TakeArm(arm=box.arm, by="test"))
            await Moves(box).speedj((0.0, 0.0, 0.6, 0.3, 0.0, 0.0), a=2.0, t=0.0)
            await box.until(lambda: 0.05 < box.target_qd[2] < 0.3)
            rows = []
            while max(map(abs, box.target_qdd)) > 0.5:
                names = ("target_TCP_speed", "target_TCP_acceleration")
                rows.append((box.time, *(values(box, name) for name in names)))
                await box.next_update()
            await box.call(ReturnArm(arm=box.arm))
            return rows

    time, speed, acceleration = map(np.array, zip(*asyncio.run(taken()), strict=True))
    elapsed = np.diff(time)
    assert len(elapsed) > 10
    slope = np.diff(speed, axis=0) / elapsed[:, None]
    middle = 0.5 * (acceleration[1:] + acceleration[:-1])
    assert np.abs(middle).max() > 0.3
    np.testing.assert_allclose(slope, middle, atol=0.05)


def test_every_output_can_be_packed(robot: tool0.Robot) -> None:
    async def packed() -> bytes:
        async with control_box(robot) as box:
            for name, field in OUTPUTS.items():
                length = LENGTHS[field.type]
                assert np.size(field.read(box)) == length, name
            return OutputRecipe(tuple(OUTPUTS)[:150], recipe_id=1).pack(box)

    assert asyncio.run(packed())[0] == 1


def test_inputs_are_written_to_registers_with_their_names(robot: tool0.Robot) -> None:
    async def written() -> tuple[Any, ...]:
        async with control_box(robot) as box:
            heard: list[Any] = []
            box.registers.when_written.add(heard.append)
            names = (
                "input_bit_registers32_to_63",
                "input_bit_register_64",
                "input_int_register_3",
                "input_double_register_47",
            )
            data = struct.pack(">I?id", 0b101, True, -5, 2.5)
            InputRecipe(names).execute(data + b"more", box)
            (first,) = heard
            assert set(first) == set(names)
            inputs = box.registers.inputs
            numbers = inputs.integers[3], inputs.doubles[47]
            return inputs.bits[32:35], inputs.bits[64], *numbers

    assert asyncio.run(written()) == ([True, False, True], True, -5, 2.5)


@pytest.mark.slow
def test_the_history_knows_where_the_arm_was_and_whether_it_rests(
    robot: tool0.Robot,
) -> None:
    async def watched() -> None:
        async with control_box(robot) as box:
            with ToolHistory(box) as history:
                await box.until(history.is_steady)
                robot.move_joints({"elbow_joint": 1.6})
                await box.until(lambda: max(map(abs, box.qd)) > 0.1)
                assert not history.is_steady()
                before = box.q
                updates: list[float] = []
                box.when_updated.add(lambda: updates.append(box.time))
                await box.until(lambda: len(updates) >= 5)
                steps = 0
                while history.positions(steps) != before:
                    steps += 1
                assert 1 <= steps <= len(updates), "a busy process leaves out updates"
                assert history.positions(0) == box.q
                assert history.contact([0.0, 0.0, -1.0]) == 0

    asyncio.run(watched())


def test_unknown_commands_are_refused(robot: tool0.Robot) -> None:
    async def refused() -> None:
        async with control_box(robot) as box:
            with ToolHistory(box) as history:
                exchange = Exchange(box.registers, 0)
                commands = Commands(box, exchange, history, (), lambda: None)
                for command in (5, 22, 72, 200, -1):
                    with pytest.raises(ControlError, match=f"command {command} is not"):
                        await commands.execute(command)

    asyncio.run(refused())


def test_matrices_need_both_ranges_of_registers(robot: tool0.Robot) -> None:
    async def answered() -> None:
        async with control_box(robot) as box:
            rows = box.dynamics.jacobian()
            Exchange(box.registers, 0).answer_matrix(rows)
            doubles = box.registers.outputs.doubles
            columns = [value for column in zip(*rows, strict=True) for value in column]
            assert [*doubles[:24], *doubles[36:]] == columns
            with pytest.raises(ControlError, match="lower range"):
                Exchange(box.registers, 24).answer_matrix(rows)

    asyncio.run(answered())
