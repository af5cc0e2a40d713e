"""Registers and counts, with the frames of Robotiq's instruction manuals."""

from __future__ import annotations

import random

import pytest

from tool0.description.loading import assemble
from tool0.devices.robotiq_counts import Counts
from tool0.devices.robotiq_registers import (
    Activation,
    CommandRegisters,
    Fault,
    ObjectStatus,
    StatusRegisters,
)

GRIPPERS = {"2f85": (3, 230), "2f140": (3, 230), "hande": (0, 255)}
"""Counts fully open and closed."""


@pytest.fixture(scope="module", params=GRIPPERS)
def counts(request: pytest.FixtureRequest) -> Counts:
    model = assemble("ur5", gripper=request.param).model
    made = Counts(model.grippers[0])
    assert (made.open, made.closed) == GRIPPERS[request.param]
    return made


def test_commands_survive_their_registers() -> None:
    chance = random.Random(1)
    for _ in range(200):
        command = CommandRegisters(
            activate=chance.random() < 0.5,
            go_to=chance.random() < 0.5,
            release=chance.random() < 0.5,
            release_opening=chance.random() < 0.5,
            position=chance.randrange(256),
            speed=chance.randrange(256),
            force=chance.randrange(256),
        )
        assert CommandRegisters.decode(command.encode()) == command


def test_commands_are_those_of_the_manual() -> None:
    close = CommandRegisters(
        activate=True, go_to=True, position=255, speed=255, force=255
    )
    assert close.encode()[:6] == bytes.fromhex("0900 00FF FFFF")
    assert CommandRegisters(activate=True, release=True).encode()[0] == 0x11
    assert CommandRegisters(activate=True, release_opening=True).encode()[0] == 0x21


@pytest.mark.parametrize(
    ("status", "registers"),
    [
        ((False, Activation.IN_PROGRESS, 0, 0, 0), "1100 0000 0000"),
        ((False, Activation.COMPLETE, 0, 0, 0), "3100 0000 0000"),
        ((True, Activation.COMPLETE, 0, 255, 14), "3900 00FF 0E0A"),
        ((True, Activation.COMPLETE, 2, 255, 189), "B900 00FF BD00"),
        ((True, Activation.COMPLETE, 3, 0, 13), "F900 0000 0D00"),
    ],
)
def test_states_are_those_of_the_manual(
    status: tuple[bool, Activation, int, int, int], registers: str
) -> None:
    goes_to, activation, met, request, position = status
    expected = bytes.fromhex(registers)
    found = StatusRegisters(
        is_activated=True,
        goes_to=goes_to,
        activation=activation,
        object_status=ObjectStatus(met),
        fault=Fault.NONE,
        request=request,
        position=position,
        current=expected[5],
    )
    assert found.encode() == expected.ljust(16, b"\0")


def test_counts_and_openings_are_inverse(counts: Counts) -> None:
    geometry = counts.geometry
    for count in range(counts.open, counts.closed + 1):
        assert counts.count(geometry.position(counts.opening(count))) == count
    assert counts.opening(0) == pytest.approx(geometry.max_opening)
    assert counts.opening(255) == pytest.approx(0.0, abs=1e-9)


def test_speed_and_force_span_their_ranges(counts: Counts) -> None:
    geometry = counts.geometry
    assert (counts.speed(0), counts.speed(255)) == pytest.approx(geometry.speed)
    assert (counts.force(0), counts.force(255)) == pytest.approx(geometry.force)


def test_the_strongest_grip_takes_the_largest_current(counts: Counts) -> None:
    geometry = counts.geometry
    for opening in (0.01, 0.03, 0.045):
        position = geometry.position(opening)
        effort = geometry.force[1] * geometry.lever(position)
        assert counts.current(position, effort) == 100
        assert counts.current(position, -effort / 2.0) == 50
