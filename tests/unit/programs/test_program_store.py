from __future__ import annotations

from pathlib import Path

import pytest

from tool0.errors import ConfigError, ControlError
from tool0.programs.store import ProgramStore
from tool0.protocol.program import CommentStep, LoopStep, Program, WaitStep

PICK = Program(
    name="pick & place/2",
    steps=(LoopStep(times=2, steps=(WaitStep(duration=0.1), CommentStep(text="ä"))),),
)


@pytest.fixture
def store(data_home: Path) -> ProgramStore:
    return ProgramStore("ur5/2f85")


def test_a_program_is_saved_listed_renamed_and_deleted(store: ProgramStore) -> None:
    assert store.all() == ()
    store.save(PICK, overwrite=False)
    assert store.read(PICK.name) == PICK
    assert [(item.name, item.n_steps) for item in store.all()] == [(PICK.name, 3)]
    store.rename(PICK.name, "b")
    assert store.read("b").name == "b"
    assert store.read("b").steps == PICK.steps
    assert [item.name for item in store.all()] == ["b"]
    store.delete("b")
    assert store.all() == ()


def test_programs_of_another_robot_are_not_shown(store: ProgramStore) -> None:
    store.save(PICK, overwrite=False)
    assert ProgramStore("ur5").all() == ()


def test_a_saved_program_is_replaced_only_if_that_is_meant(store: ProgramStore) -> None:
    store.save(PICK, overwrite=False)
    with pytest.raises(ControlError, match="is saved already"):
        store.save(PICK, overwrite=False)
    store.save(Program(name=PICK.name), overwrite=True)
    assert store.read(PICK.name).steps == ()
    store.save(Program(name="other"), overwrite=False)
    with pytest.raises(ControlError, match="a program 'other' is saved already"):
        store.rename(PICK.name, "other")


def test_an_unknown_program_suggests_a_name(store: ProgramStore) -> None:
    store.save(Program(name="pick"), overwrite=False)
    with pytest.raises(ControlError, match=r"'pik' is saved; did you mean 'pick'\?"):
        store.read("pik")


@pytest.mark.parametrize("name", ["程" * 60, "../..", "100 %", "a/b\\c:d", ".", "è?"])
def test_any_printable_name_can_be_saved(store: ProgramStore, name: str) -> None:
    store.save(Program(name=name), overwrite=False)
    assert [item.name for item in store.all()] == [name]
    assert store.read(name).name == name
    (file,) = store.folder.rglob("*")
    assert file.parent == store.folder
    store.delete(name)


@pytest.mark.parametrize("name", ["🤖" * 60, "x" * 300, "\ud800"])
def test_a_name_that_no_file_can_have_is_refused(
    store: ProgramStore, name: str
) -> None:
    for act in (store.read, store.delete, lambda name: store.rename(name, "b")):
        with pytest.raises(ControlError):
            act(name)


@pytest.mark.parametrize("name", [" a", "a\n", "x" * 61])
def test_a_name_must_fit_on_a_line(store: ProgramStore, name: str) -> None:
    with pytest.raises(ControlError, match="1 to 60 printable"):
        store.save(Program(name=name), overwrite=True)


def test_a_damaged_file_is_listed_with_the_reason(store: ProgramStore) -> None:
    store.save(Program(name="good"), overwrite=False)
    (store.folder / "bad.yaml").write_text("name: [")
    bad, good = store.all()
    assert (good.name, good.error) == ("good", "")
    assert bad.name == "bad"
    assert "not YAML" in bad.error
    with pytest.raises(ConfigError, match=r"bad\.yaml:2"):
        store.read("bad")


def test_a_folder_that_cannot_be_written_is_named(
    store: ProgramStore, data_home: Path
) -> None:
    data_home.mkdir(exist_ok=True)
    (data_home / "tool0").write_text("a file in its place")
    with pytest.raises(ConfigError, match="cannot write the saved programs"):
        store.save(PICK, overwrite=True)
