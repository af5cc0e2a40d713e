import pytest

from tool0.ur.program_files import ProgramFile, ProgramFiles

TEXT = "def pick():\nend\n"


@pytest.fixture
def files(tmp_path):
    folder = tmp_path / "programs"
    (folder / "cell").mkdir(parents=True)
    (folder / "pick.script").write_text(TEXT)
    (folder / "cell" / "place.script").write_text(TEXT)
    (tmp_path / "secret.script").write_text(TEXT)
    (folder / "link.script").symlink_to(tmp_path / "secret.script")
    (folder / "notes.txt").write_text("private")
    (folder / "broken.script").write_bytes(b"\xff\xfe")
    return ProgramFiles(folder)


@pytest.mark.parametrize(
    "name",
    [
        "pick.script",
        "pick.urp",
        "pick",
        "/programs/pick.urp",
        "/ursim/programs/pick.urp",
        "cell/place.urp",
    ],
)
def test_programs_are_found_by_the_names_that_clients_use(files, name):
    assert files.read(name) == ProgramFile(name.split("/")[-1], TEXT)


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "..",
        "absent.urp",
        "../secret.script",
        "cell/../../secret.urp",
        "/programs/../secret.script",
        "/etc/passwd",
        "link.script",
        "notes.txt",
        "broken.script",
        "cell",
        "pick\0.script",
        "x" * 5000,
    ],
)
def test_nothing_else_is_read(files, name):
    assert files.read(name) is None


def test_without_a_folder_there_are_no_programs():
    assert ProgramFiles(None).read("pick.script") is None
