"""Damaged recordings: whatever is wrong with them, it is a RecordingError."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import pytest
from recording_session import Session

import tool0
from tool0.recording import reading
from tool0.recording.contents import BRINGUP, DESCRIPTION, ROBOT, SIMULATION
from tool0.recording.events import EVENTS
from tool0.recording.frames import (
    CONTACTS,
    GRIPPERS,
    JOINT_COMMANDS,
    JOINT_STATES,
    OBJECTS,
    STATE,
)
from tool0.recording.journal import REQUESTS
from tool0.recording.parsing import Parsed, parse
from tool0.recording.reading import RecordingFile

SEED = 7
DATA_END = 13
"""Size of the record that ends the data, with the checksum [bytes]."""

ATTACHMENTS: dict[str, Callable[[RecordingFile], object]] = {
    ROBOT: lambda file: file.urdf,
    DESCRIPTION: lambda file: file.description,
    SIMULATION: lambda file: file.simulation,
    BRINGUP: lambda file: file.bringup,
}
STREAMS: dict[str, Callable[[RecordingFile], object]] = {
    JOINT_STATES: lambda file: (file.position, file.tick),
    JOINT_COMMANDS: lambda file: file.desired_position,
    OBJECTS: lambda file: file.objects,
    GRIPPERS: lambda file: file.gripper_states,
    CONTACTS: lambda file: file.contacts,
    STATE: lambda file: file.snapshots()[-1],
    EVENTS: lambda file: file.events,
    REQUESTS: lambda file: file.requests,
}


def changed(data: bytes, rng: random.Random) -> bytes:
    """Return ``data`` with a flipped bit, cut off, or with something inserted."""
    at = rng.randrange(len(data))
    kind = rng.randrange(3)
    if kind == 0:
        return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]
    return data[:at] if kind == 1 else data[:at] + b"\xff{" + data[at:]


def damaged(data: bytes, at: int, bit: int = 0) -> bytes:
    return data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1 :]


def test_a_flipped_bit_anywhere_is_reported(session: Session, tmp_path: Path) -> None:
    """What follows the data is not read, so that a bit there changes nothing."""
    data = session.path.read_bytes()
    rng = random.Random(SEED)
    file = tmp_path / "damaged.mcap"
    end = len(data) - len(summary(data))
    places = [rng.randrange(end) for _ in range(120)]
    for at in (*places, *range(8), *range(end - DATA_END, end)):
        file.write_bytes(damaged(data, at, rng.randrange(8)))
        with pytest.raises(tool0.RecordingError, match=r"damaged\.mcap"):
            tool0.open_recording(file)


def summary(data: bytes) -> bytes:
    """Return what follows the data of a file."""
    start = int.from_bytes(data[-28:-20], "little")  # in the footer
    return data[start:]


@pytest.mark.parametrize("name", ["robot.urdf", "simulation.json", "meshes/0-"])
def test_a_damaged_attachment_is_named(
    session: Session, tmp_path: Path, name: str
) -> None:
    """Also in a file that was cut off, which has no checksum of the whole."""
    data = session.path.read_bytes()
    data = data[: len(data) - len(summary(data)) - 20]
    file = tmp_path / "damaged.mcap"
    file.write_bytes(damaged(data, data.index(name.encode()) + 300))
    with pytest.raises(
        tool0.RecordingError, match=rf"at byte \d+: attachment '{name}.*checksum"
    ):
        tool0.open_recording(file)


@pytest.mark.slow
@pytest.mark.parametrize("topic", STREAMS)
def test_wrong_messages_are_reported(
    session: Session, topic: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As another program could write them, with the right checksums."""
    rng = random.Random(SEED)
    for _ in range(15):
        parsed = parse(session.path, JOINT_STATES)
        stream = parsed.streams[topic]
        i = rng.randrange(len(stream.messages))
        stream.messages[i] = changed(stream.messages[i], rng)
        if rng.random() < 0.3:
            stream.frames[i] = rng.randrange(1 << 20)
        read(session.path, parsed, STREAMS[topic], monkeypatch)


@pytest.mark.parametrize("name", ATTACHMENTS)
def test_wrong_attachments_are_reported(
    session: Session, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = random.Random(SEED)
    for _ in range(15):
        parsed = parse(session.path, JOINT_STATES)
        parsed.attachments[name] = changed(parsed.attachments[name], rng)
        read(session.path, parsed, ATTACHMENTS[name], monkeypatch)


def read(
    path: Path,
    parsed: Parsed,
    part: Callable[[RecordingFile], object],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Read a part: it can be read, or is a RecordingError with the file."""
    monkeypatch.setattr(reading, "parse", lambda path, topic: parsed)
    try:
        part(tool0.open_recording(path))
    except tool0.RecordingError as error:
        assert str(path) in str(error)  # noqa: PT017  # most cannot be read
