from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.errors import ConfigError
from tool0.programs.files import parse_program, program_text, read_program
from tool0.programs.step_descriptions import step_text
from tool0.protocol.program import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveJointStep,
    MoveLinearStep,
    PlaceObjectStep,
    Program,
    SetOutputStep,
    Step,
    ToolPose,
    UntilStep,
    WaitStep,
    path_text,
    walk,
)

TEXT = """\
name: pick
steps:
  - {kind: move_joint, named_pose: home}
  - kind: loop
    times: 2
    steps:
      - kind: move_linear
        pose: {xyz: [0.4, 1e-1, 0.2], rpy: [!degrees 180, 0, 0]}
        speed: 5e-2
      - {kind: gripper, opening: closed}
"""

numbers = st.floats(-10.0, 10.0).map(lambda x: round(x, 6))
places = st.tuples(numbers, numbers, numbers)
positive = st.floats(0.001, 10.0).map(lambda x: round(x, 6))
texts = st.text(
    st.characters(min_codepoint=32, exclude_categories=("C", "Z")), min_size=1
)
poses = st.builds(ToolPose, xyz=places, rpy=places, relative_to=st.none() | texts)
simple: st.SearchStrategy[Step] = st.one_of(
    st.builds(
        MoveJointStep,
        label=st.just("") | texts,
        joints=st.none() | st.dictionaries(texts, numbers),
        pose=st.none() | poses,
        speed=positive,
        blend=positive,
    ),
    st.builds(MoveLinearStep, named_pose=st.none() | texts, acceleration=positive),
    st.builds(GripperStep, opening=st.sampled_from(("open", "closed", 0.02))),
    st.builds(WaitStep, duration=st.none() | positive, input=st.integers(0, 17)),
    st.builds(UntilStep, direction=places, distance=positive, must_touch=st.booleans()),
    st.builds(PlaceObjectStep, name=texts, xyz=places),
    st.builds(SetOutputStep, output=st.integers(0, 17), level=st.booleans()),
    st.builds(CommentStep, text=texts),
)
steps = st.recursive(
    simple,
    lambda inner: st.builds(LoopStep, steps=st.lists(inner, max_size=3).map(tuple)),
    max_leaves=8,
)
programs = st.builds(Program, name=texts, tool=poses, steps=st.lists(steps).map(tuple))


@pytest.mark.slow
@given(program=programs)
def test_a_program_is_read_as_it_was_written(program: Program) -> None:
    found = parse_program(program_text(program))
    assert found.program == program
    assert set(found.lines) == {path for path, _ in walk(program.steps)}


def test_a_file_is_read_with_degrees_and_the_lines_of_its_steps(tmp_path: Path) -> None:
    file = tmp_path / "pick.yaml"
    file.write_text(TEXT)
    found = read_program(file)
    loop = found.program.steps[1]
    assert isinstance(loop, LoopStep)
    line = loop.steps[0]
    assert isinstance(line, MoveLinearStep)
    assert line.pose == ToolPose(xyz=(0.4, 0.1, 0.2), rpy=(math.pi, 0.0, 0.0))
    assert line.speed == 0.05
    assert found.lines == {(1,): 3, (2,): 4, (2, 1): 7, (2, 2): 10}


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("named_pose: home", "named_pse: home", 3, "did you mean 'named_pose'?"),
        ("kind: move_joint", "kind: movej", 3, "the kinds of steps are move_joint"),
        ("times: 2", "times: 0", 5, ">= 1"),
        ("speed: 5e-2", "speed: fast", 9, "float"),
        ("0.2]", "0.2, 0.3]", 8, "length 3"),
        ("{kind: gripper, opening: closed}", "[1]", 10, "`mapping`, got `list`"),
        ("0.2]", ".nan]", 8, "must be finite, got nan"),
        ("opening: closed", "opening: shut", 10, "shut"),
        ("opening: closed", "", 10, "missing required field `opening`"),
        ("name: pick", "names: pick", 1, "did you mean 'name'?"),
        ("name: pick", "name: pick\nname: place", 2, "occurs twice"),
        ("name: pick", "format: 2\nname: pick", 1, "2"),
        ("times: 2", "times: [", 7, "not YAML"),
    ],
)
def test_a_mistake_is_reported_with_its_line(
    old: str, new: str, line: int, message: str
) -> None:
    with pytest.raises(ConfigError) as error:
        parse_program(TEXT.replace(old, new))
    assert error.value.location is not None
    assert error.value.location.line == line
    assert message in str(error.value)


@pytest.mark.parametrize("text", ["", "- 1\n", "pick\n"])
def test_a_text_that_is_no_program_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match="a program needs 'name' and 'steps'"):
        parse_program(text)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"pick\.yaml: cannot read the file"):
        read_program(tmp_path / "pick.yaml")


def test_steps_are_numbered_within_loops() -> None:
    paths = [path_text(path) for path, _ in walk(parse_program(TEXT).program.steps)]
    assert paths == ["1", "2", "2.1", "2.2"]


def test_a_target_with_a_label_is_called_so() -> None:
    pose = ToolPose(xyz=(0.4, 0.1, 0.2))
    plain, named = MoveLinearStep(pose=pose), MoveLinearStep(label="above", pose=pose)
    assert step_text(plain) == "move on a line to (0.400, 0.100, 0.200)"
    assert step_text(named) == "move on a line to 'above'"
