"""The suggestion in an error about an unknown name."""

import pytest

from tool0.errors import NoSuchPartError, did_you_mean, nearest_name

ARMS = ("ur10", "ur10e", "ur12e", "ur15", "ur16e", "ur3", "ur3e", "ur5", "ur5e")


@pytest.mark.parametrize(
    ("name", "nearest"),
    [("UR5", "ur5"), ("ur6", "ur5"), ("Ur10E", "ur10e"), ("ur16", "ur16e")],
)
def test_the_name_with_the_fewest_differences_is_suggested(
    name: str, nearest: str
) -> None:
    assert nearest_name(name, ARMS) == nearest


def test_a_valid_name_is_its_own_nearest_in_its_case() -> None:
    assert nearest_name("Pose", ("POSE", "Pose", "pose")) == "Pose"


def test_a_name_that_differs_by_its_prefix_comes_first() -> None:
    names = ("left_tool0", "tool1")
    assert nearest_name("tool0", names) == "left_tool0"


def test_without_a_similar_name_all_are_listed() -> None:
    assert did_you_mean("panda", ("ur5", "ur3")) == "; valid: ur3, ur5"


def test_a_missing_part_is_a_key_error_with_a_plain_text() -> None:
    error = NoSuchPartError("no arm 'left'; valid: arm")
    assert isinstance(error, KeyError)
    assert str(error) == "no arm 'left'; valid: arm"
