from __future__ import annotations

from pathlib import Path

import pytest

from tool0.errors import ConfigError, ControlError
from tool0.programs.book import ProgramBook
from tool0.protocol.program import CommentStep, LoopStep, Program, WaitStep

PICK = Program(
    name="pick & place/2",
    steps=(LoopStep(times=2, steps=(WaitStep(duration=0.1), CommentStep(text="ä"))),),
)


@pytest.fixture
def book(data_home: Path) -> ProgramBook:
    return ProgramBook("ur5/2f85")


def test_a_program_is_saved_listed_renamed_and_deleted(book: ProgramBook) -> None:
    assert book.all() == ()
    book.save(PICK, overwrite=False)
    assert book.read(PICK.name) == PICK
    assert [(item.name, item.n_steps) for item in book.all()] == [(PICK.name, 3)]
    book.rename(PICK.name, "b")
    assert book.read("b").name == "b"
    assert book.read("b").steps == PICK.steps
    assert [item.name for item in book.all()] == ["b"]
    book.delete("b")
    assert book.all() == ()


def test_programs_of_another_robot_are_not_shown(book: ProgramBook) -> None:
    book.save(PICK, overwrite=False)
    assert ProgramBook("ur5").all() == ()


def test_a_saved_program_is_replaced_only_if_that_is_meant(book: ProgramBook) -> None:
    book.save(PICK, overwrite=False)
    with pytest.raises(ControlError, match="is saved already"):
        book.save(PICK, overwrite=False)
    book.save(Program(name=PICK.name), overwrite=True)
    assert book.read(PICK.name).steps == ()
    book.save(Program(name="other"), overwrite=False)
    with pytest.raises(ControlError, match="a program 'other' is saved already"):
        book.rename(PICK.name, "other")


def test_an_unknown_program_suggests_a_name(book: ProgramBook) -> None:
    book.save(Program(name="pick"), overwrite=False)
    with pytest.raises(ControlError, match=r"'pik' is saved; did you mean 'pick'\?"):
        book.read("pik")


@pytest.mark.parametrize("name", ["程" * 60, "../..", "100 %", "a/b\\c:d", ".", "è?"])
def test_any_printable_name_can_be_saved(book: ProgramBook, name: str) -> None:
    book.save(Program(name=name), overwrite=False)
    assert [item.name for item in book.all()] == [name]
    assert book.read(name).name == name
    (file,) = book.folder.rglob("*")
    assert file.parent == book.folder
    book.delete(name)


@pytest.mark.parametrize("name", ["🤖" * 60, "x" * 300, "\ud800"])
def test_a_name_that_no_file_can_have_is_refused(book: ProgramBook, name: str) -> None:
    for act in (book.read, book.delete, lambda name: book.rename(name, "b")):
        with pytest.raises(ControlError):
            act(name)


@pytest.mark.parametrize("name", [" a", "a\n", "x" * 61])
def test_a_name_must_fit_on_a_line(book: ProgramBook, name: str) -> None:
    with pytest.raises(ControlError, match="1 to 60 printable"):
        book.save(Program(name=name), overwrite=True)


def test_a_damaged_file_is_listed_with_the_reason(book: ProgramBook) -> None:
    book.save(Program(name="good"), overwrite=False)
    (book.folder / "bad.yaml").write_text("name: [")
    bad, good = book.all()
    assert (good.name, good.error) == ("good", "")
    assert bad.name == "bad"
    assert "not YAML" in bad.error
    with pytest.raises(ConfigError, match=r"bad\.yaml:2"):
        book.read("bad")


def test_a_folder_that_cannot_be_written_is_named(
    book: ProgramBook, data_home: Path
) -> None:
    data_home.mkdir(exist_ok=True)
    (data_home / "tool0").write_text("a file in its place")
    with pytest.raises(ConfigError, match="cannot write the saved programs"):
        book.save(PICK, overwrite=True)
