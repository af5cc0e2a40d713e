"""What no engine does, whatever its physics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import pytest

from tool0.description.scene import SceneObject
from tool0.description.shapes import Sphere
from tool0.engines.checks import (
    check_attachable,
    check_dt,
    check_new_name,
    check_placement,
    find_object,
)
from tool0.errors import ConfigError, EngineError
from tool0.hardware.engine import ObjectState

OBJECTS = {
    name: SceneObject(name=name, geometry=Sphere(radius=0.1), mass=mass)
    for name, mass in (("ball", 1.0), ("post", None))
}


def place(
    objects: Mapping[str, SceneObject], name: str, speed: float = 1.0
) -> SceneObject | None:
    at = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    return check_placement(objects, ObjectState(name, *at, angular=(0.0, 0.0, speed)))


@pytest.mark.parametrize(
    ("check", "allowed", "refused"),
    [
        (check_new_name, "cube", ["ball"]),
        (find_object, "post", ["bal"]),
        (check_attachable, "ball", ["bal", "post"]),
        (place, "ball", ["bal", "post"]),
    ],
)
def test_what_cannot_be_is_refused_by_name(
    check: Callable[[Mapping[str, SceneObject], str], object],
    allowed: str,
    refused: list[str],
) -> None:
    check(OBJECTS, allowed)
    for name in refused:
        with pytest.raises(EngineError) as error:
            check(OBJECTS, name)
        assert f"'{name}'" in str(error.value)
        if name == "bal":
            assert "'ball'" in str(error.value)


def test_a_static_object_can_be_placed_at_rest() -> None:
    place(OBJECTS, "post", speed=0.0)


@pytest.mark.parametrize("dt", [0.0, -0.001, math.nan, math.inf])
def test_a_step_without_a_positive_length_is_refused(dt: float) -> None:
    with pytest.raises(ConfigError):
        check_dt(dt)
