from pathlib import Path

import pytest

from tool0.lint.launch.parameters import parameter_values
from tool0.lint.launch.reader import read_launch


def values(folder: Path, content: str) -> dict[str, tuple[object, int | None]]:
    file = folder / "main.launch"
    file.write_text(f"<launch>\n{content}\n</launch>")
    found, findings = parameter_values(read_launch(file))
    assert findings == ()
    return {name: (value.value, value.location.line) for name, value in found.items()}


def test_the_last_counts_and_knows_its_line(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("x: {y: 1}\nz: [1, 2]\n")
    found = values(
        tmp_path,
        '<rosparam file="$(dirname)/a.yaml" ns="n"/>\n<param name="n/x/y" value="2"/>\n'
        '<rosparam param="text">\n\n  hello</rosparam>\n'
        '<param name="c" command="echo 1"/>',
    )
    assert found == {
        "/n/x/y": (2, 3),
        "/n/z": ([1, 2], 2),
        "/text": ("hello", 4),
        "/c": (None, 7),
    }


@pytest.mark.parametrize(
    ("content", "line"),
    [("<rosparam>\na: 1\nb: [\n</rosparam>", 5), ("<rosparam>just text</rosparam>", 2)],
)
def test_what_is_no_yaml_is_a_finding(tmp_path: Path, content: str, line: int) -> None:
    file = tmp_path / "main.launch"
    file.write_text(f"<launch>\n{content}\n</launch>")
    found, (finding,) = parameter_values(read_launch(file))
    assert found == {}
    assert (finding.rule, finding.location.line) == ("not-yaml", line)


def test_the_text_of_a_long_tag_knows_its_line(tmp_path: Path) -> None:
    found = values(
        tmp_path, '<rosparam\n  ns="a>b"\n  command="load">\nx: 1\n</rosparam>'
    )
    assert list(found.values()) == [(1, 5)]
