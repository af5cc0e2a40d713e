"""No false alarm: what this project ships, and what no input may do."""

import random
from pathlib import Path

import pytest
from check_files import DATA
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tool0.checks import check as module
from tool0.checks.check import check
from tool0.checks.document import document_findings
from tool0.description.packages import BUNDLED

SEEDS = [
    *sorted((DATA / "controllers").glob("*.yaml")),
    *sorted((BUNDLED / "tool0_gazebo").rglob("*.launch")),
    *sorted((BUNDLED / "tool0_gazebo").rglob("*.xacro")),
    BUNDLED / "tool0_description" / "package.xml",
    Path(__file__).parents[3] / "README.md",
]


def test_the_packages_that_we_ship_are_clean() -> None:
    report = check([BUNDLED])
    assert report.findings == ()
    assert len(report.files) > 20


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let work be done here: a child for each example takes too long."""
    monkeypatch.setattr(module, "bounded", lambda work, *a, **k: work(*a, **k))


def mangled(text: str, seed: int) -> str:
    """Return ``text`` with some characters changed, swapped, doubled or lost."""
    chance = random.Random(seed)
    characters = list(text)
    for _ in range(chance.randint(1, 12)):
        place = chance.randrange(len(characters))
        match chance.randrange(4):
            case 0:
                del characters[place : place + chance.randint(1, 30)]
            case 1:
                characters[place] = chance.choice('<>/"$(){}[]:&*!-\n\t x0é\0')
            case 2:
                end = place + chance.randint(1, 80)
                characters[place:place] = characters[place:end]
            case 3:
                other = chance.randrange(len(characters))
                characters[place], characters[other] = (
                    characters[other],
                    characters[place],
                )
        if not characters:
            break
    return "".join(characters) or "x"


@pytest.mark.usefixtures("at_once")
@settings(
    max_examples=80,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(file=st.sampled_from(SEEDS), seed=st.integers(0, 2**32))
def test_nothing_that_was_mangled_raises(tmp_path: Path, file: Path, seed: int) -> None:
    path = tmp_path / file.name
    path.write_text(mangled(file.read_text(encoding="utf-8"), seed), encoding="utf-8")
    for finding in check([path]).findings:
        assert finding.message
        assert str(finding)


@settings(max_examples=60, deadline=None)
@given(text=st.text(st.sampled_from('<>a/"!-: \n{}[]&*.yaml路'), max_size=200))
def test_no_text_raises(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.mktemp("text") / "a.md"
    path.write_text(text, encoding="utf-8")
    list(document_findings(path))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("deep.urdf", "<robot>" * 3000),
        ("deep.yaml", "pid_gains: " + "[" * 3000),
        ("self.launch", '<launch><include file="$(dirname)/self.launch"/></launch>'),
        (
            "bomb.yaml",
            "a: &a [1,1,1,1]\n"
            + "".join(
                f"{chr(98 + n)}: &{chr(98 + n)} [{','.join([f'*{chr(97 + n)}'] * 9)}]\n"
                for n in range(9)
            )
            + "pid_gains: {x: *j}\n",
        ),
        ("entity.urdf", '<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"/>'),
        ("latin.yaml", "pid_gains: {ä: 1}\n"),
        ("empty.urdf", ""),
        ("empty.launch", ""),
    ],
)
def test_what_was_made_to_break_readers_is_told(
    tmp_path: Path, name: str, text: str
) -> None:
    path = tmp_path / name
    path.write_bytes(text.encode("latin-1"))
    assert check([path]).findings
