"""Damaged recordings, by every operation that reads one: a result, or a RecordingError.

Half of the files are changed anywhere, as by a disk.  The other half have right
checksums, and wrong messages, attachments and metadata, as another program writes them.
"""

from __future__ import annotations

import contextlib
import io
import random
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from fuzzing import SCALE, Trial, changed
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from recording_session import record_session

import tool0
from tool0.cli import FAILED, main
from tool0.recording.episodes import INDEX
from tool0.recording.mcap_file import McapFile

N = 100 * SCALE
SEED = 31


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record_session(tmp_path_factory.mktemp("recorded") / "session.mcap").path


class Contents(NamedTuple):
    """What a recording has, in its order."""

    records: list[Any]
    channels: dict[int, tuple[str, str]]
    """Number → topic and type."""


def contents(path: Path) -> Contents:
    schemas: dict[int, str] = {}
    channels: dict[int, tuple[str, str]] = {}
    records = []
    with path.open("rb") as stream:
        for record in StreamReader(stream).records:
            match record:
                case Schema():
                    schemas[record.id] = record.name
                case Channel():
                    channels[record.id] = (record.topic, schemas[record.schema_id])
                case Message() | Attachment() | Metadata():
                    records.append(record)
    return Contents(records, channels)


def rewrite(source: Contents, path: Path, rng: random.Random) -> None:
    """Write the same recording, with some of its contents changed."""
    rare = rng.choice((0.0005, 0.01, 0.2))
    file = McapFile(path, overwrite=True)
    for record in source.records:
        is_changed = rng.random() < rare or (
            not isinstance(record, Message) and rng.random() < 0.1
        )
        match record:
            case Message():
                topic, kind = source.channels[record.channel_id]
                data, time = record.data, record.log_time
                if is_changed and rng.random() < 0.8:
                    data = changed(data, rng)
                elif is_changed:
                    time = rng.choice((0, time + 10**9, 2**63, max(time - 10**7, 0)))
                if is_changed and rng.random() < 0.1:
                    continue
                file.write(topic, kind, time, data, record.sequence)
            case Attachment():
                if is_changed and rng.random() < 0.2:
                    continue
                data = changed(record.data, rng) if is_changed else record.data
                file.attach(record.name, record.media_type, data, record.log_time)
            case Metadata():
                values = dict(record.metadata)
                if is_changed and values:
                    key = rng.choice(sorted(values))
                    text = changed(values[key].encode(), rng)
                    values[key] = text.decode("utf-8", "replace")
                file.note(record.name, values)
    file.finish()


def command(*words: str) -> Callable[[Path], object]:
    """Return what calls a command, with the file in place of ``{}``."""

    def call(file: Path) -> object:
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            status = main([word.replace("{}", str(file)) for word in words])
        assert "Traceback" not in said.getvalue()
        if status == FAILED:
            raise tool0.RecordingError(said.getvalue())
        return status

    return call


def everything(file: Path) -> None:
    recording = tool0.open_recording(file)
    for name in sorted(dir(type(recording))):
        if name[0] != "_" and name not in ("snapshots", "table", "to_pandas"):
            getattr(recording, name)
    recording.table()
    for index in {0, len(recording) // 2, len(recording) - 1}:
        if len(recording):
            recording.snapshots()[index]


def as_demonstration(file: Path) -> object:
    folder = file.parent / "episodes"
    shutil.rmtree(file.parent / "set", ignore_errors=True)
    folder.mkdir(exist_ok=True)
    shutil.copy(file, folder / "episode_000000.mcap")
    (folder / INDEX).write_text(
        '{"episode":0,"file":"episode_000000.mcap","outcome":"success","task":"t",'
        '"duration":1.0,"wall_start":1.0}\n'
    )
    words = ["export", "{}", "--format", "lerobot", "--rate", "20", "--output"]
    return command(*words, str(file.parent / "set"))(folder)


OPERATIONS: dict[str, Callable[[Path], object]] = {
    "everything": everything,
    "log": command("log", "{}"),
    "log as JSON": command("log", "{}", "--json"),
    "csv": command("export", "{}", "--overwrite"),
    "parquet": command("export", "{}", "--overwrite", "--format", "parquet"),
    "simulate": command("replay", "{}", "--simulate"),
    "lerobot": as_demonstration,
}


@pytest.mark.timeout(900 * SCALE)
def test_recordings(original: Path, tmp_path: Path) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    pytest.importorskip("pyarrow", reason="the extra 'collect' is not installed")
    data, source = original.read_bytes(), contents(original)
    trial = Trial("recordings")
    file = tmp_path / "damaged.mcap"
    names = list(OPERATIONS)
    for number in range(N):
        rng = random.Random(f"{SEED}.{number}")
        if number % 2:
            rewrite(source, file, rng)
        else:
            file.write_bytes(changed(data, rng))
        name = names[number // 2 % len(names)]
        trial.carry_out(partial(OPERATIONS[name], file), f"case {number}: {name}")
    trial.check()


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_succeeds_on_what_is_only_copied(
    name: str, original: Path, tmp_path: Path
) -> None:
    pytest.importorskip("gymnasium", reason="the extra 'collect' is not installed")
    pytest.importorskip("pyarrow", reason="the extra 'collect' is not installed")
    source = contents(original)
    file = McapFile(tmp_path / "copy.mcap")
    for record in source.records:
        match record:
            case Message():
                topic, kind = source.channels[record.channel_id]
                file.write(topic, kind, record.log_time, record.data, record.sequence)
            case Attachment():
                file.attach(
                    record.name, record.media_type, record.data, record.log_time
                )
            case Metadata():
                file.note(record.name, dict(record.metadata))
    file.finish()
    OPERATIONS[name](tmp_path / "copy.mcap")
