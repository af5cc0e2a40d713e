"""Pairs of links that a planner need not look at, each for the reason that it gives."""

import itertools
from pathlib import Path

import pytest

from tool0.description.loading import assemble, load_robot, named_poses
from tool0.description.model import RobotModel
from tool0.description.robot import RobotDescription
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.engines.mujoco.link_collisions import (
    LinkPair,
    LinkShapes,
    adjacent_links,
    disabled_collisions,
)

pytestmark = pytest.mark.slow

CELL = Path(__file__).parents[2] / "data/description/two_robots.urdf.xacro"
OTHER_SEED = 7
N_OTHER = 2000

Robot = tuple[RobotDescription, dict[LinkPair, str]]

SHAPE = '<collision>{origin}<geometry><box size="0.1 0.1 {h}"/></geometry></collision>'
CHAIN = """
<robot name="chain">
  <link name="world"/>
  <link name="base">{base}</link>
  <link name="middle">{middle}</link>
  <link name="tip">{tip}</link>
  <joint name="fixed" type="fixed"><parent link="world"/><child link="base"/></joint>
  <joint name="first" type="revolute">
    <parent link="base"/><child link="middle"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="second" type="prismatic">
    <parent link="middle"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>
  </joint>
</robot>
"""


def box(z: float = 0.0, height: float = 0.1) -> str:
    return SHAPE.format(origin=f'<origin xyz="0 0 {z}"/>', h=height)


def chain(
    *,
    base: str | None = None,
    middle: str | None = None,
    tip: str | None = None,
    lower: float = 0.0,
    upper: float = 1.0,
) -> RobotModel:
    """Return base, middle and tip, which slides along z away from the base."""
    shapes = {
        "base": box() if base is None else base,
        "middle": box(height=0.01) if middle is None else middle,
        "tip": box() if tip is None else tip,
    }
    text = CHAIN.format(**shapes, lower=lower, upper=upper)
    return read_model(parse_text(text))


def enabled(model: RobotModel, disabled: dict[LinkPair, str]) -> set[LinkPair]:
    links = sorted(link.name for link in model.links if link.collisions)
    return {pair for pair in itertools.combinations(links, 2) if pair not in disabled}


ENDS = ("base", "tip")


def test_links_that_meet_sometimes_stay_enabled() -> None:
    model = chain()
    assert ENDS in enabled(model, disabled_collisions(model, {"second": 1.0}))


def test_links_that_are_apart_never_collide() -> None:
    model = chain(lower=0.11)
    assert disabled_collisions(model, {"second": 0.2})[ENDS] == "Never"


def test_links_that_nearly_touch_stay_enabled() -> None:
    """A millimetre apart: a sample away from a collision."""
    model = chain(lower=0.101)
    assert ENDS in enabled(model, disabled_collisions(model, {"second": 0.2}))


def test_links_that_overlap_in_all_samples_always_collide() -> None:
    model = chain(upper=0.05)
    # a default outside the limits, where they are apart
    assert disabled_collisions(model, {"second": 0.2})[ENDS] == "Always"


def test_links_that_collide_in_the_default_pose_are_disabled() -> None:
    assert disabled_collisions(chain(), {"second": 0.0})[ENDS] == "Default"


@pytest.mark.slow
def test_links_of_one_mechanism_may_touch() -> None:
    description = assemble()
    disabled = disabled_collisions(description.model, named_poses(description)["home"])
    (pads,) = [pair for pair, reason in disabled.items() if reason == "User"]
    closed = named_poses(description)["closed"]
    assert all("pad" in link for link in pads)
    assert pads in LinkShapes(description.model).colliding_at(
        {**closed, "finger_joint": 0.8133}
    )


def test_links_without_a_shape_connect_their_neighbours() -> None:
    assert set(adjacent_links(chain())) == {("base", "middle"), ("middle", "tip")}
    assert set(adjacent_links(chain(middle=""))) == {ENDS}
    assert set(adjacent_links(chain(base=""))) == {("middle", "tip")}


def test_a_shapeless_root_connects_nothing() -> None:
    """Else the bases of all robots in a world would be adjacent."""
    model = load_robot(CELL).model
    roots = {joint.child for joint in model.child_joints[model.root]}
    assert len(roots) > 1
    branches = [set(model.links_from(link)) for link in roots]
    for pair in adjacent_links(model):
        assert any(set(pair) <= branch for branch in branches)


def test_the_same_seed_gives_the_same_pairs() -> None:
    model = assemble().model
    first, second = (LinkShapes(model).sample(300, seed=3) for _ in range(2))
    assert first == second
    assert LinkShapes(model).sample(300, seed=4) != first


@pytest.fixture(scope="module", params=[("ur5", "2f85"), ("ur3e", "2f140")])
def robot(request: pytest.FixtureRequest) -> Robot:
    description = assemble(*request.param)
    home = named_poses(description)["home"]
    return description, disabled_collisions(description.model, home)


@pytest.mark.slow
def test_each_reason_holds_in_other_poses(robot: Robot) -> None:
    description, disabled = robot
    model = description.model
    sampled = LinkShapes(model).sample(N_OTHER, OTHER_SEED)
    for pair, reason in disabled.items():
        collided = sampled.collided.get(pair, 0)
        if reason == "Never":
            assert not collided, pair
        elif reason == "Always":
            assert collided > 0.9 * N_OTHER, pair
    # none is missing: what is enabled collides
    many = LinkShapes(model).sample(5 * N_OTHER, OTHER_SEED)
    assert enabled(model, disabled) <= many.collided.keys()


def test_adjacent_links_are_adjacent_in_the_urdf(robot: Robot) -> None:
    description, disabled = robot
    model = description.model

    def path(link: str) -> list[str]:
        """Return the links up to the root."""
        found = [link]
        while found[-1] in model.parent_joint:
            found.append(model.parent_joint[found[-1]].parent)
        return found

    has_shape = {link.name for link in model.links if link.collisions}
    expected = set()
    for pair in itertools.combinations(sorted(has_shape), 2):
        first, second = map(path, pair)
        top = next(link for link in first if link in second)
        between = {*first[: first.index(top)], *second[: second.index(top)], top}
        if not (between - set(pair)) & has_shape and top != model.root:
            expected.add(pair)
    assert {p for p, reason in disabled.items() if reason == "Adjacent"} == expected


def test_no_named_pose_collides(robot: Robot) -> None:
    """Or a planner could neither start nor end there."""
    description, disabled = robot
    shapes = LinkShapes(description.model)
    for name, pose in named_poses(description).items():
        assert shapes.colliding_at(pose) <= disabled.keys(), name


@pytest.mark.slow
@pytest.mark.parametrize(("distance", "is_checked"), [(1.0, True), (5.0, False)])
def test_robots_in_reach_of_each_other_are_checked(
    distance: float, is_checked: bool
) -> None:
    model = load_robot(CELL, {"distance": distance}).model
    pairs = enabled(model, disabled_collisions(model, {}, n_samples=2000))
    robots = [joint.child for joint in model.child_joints[model.root]]
    branch = {link: root for root in robots for link in model.links_from(root)}
    between = {(a, b) for a, b in pairs if branch[a] != branch[b]}
    assert (("left_forearm_link", "right_forearm_link") in between) is is_checked
    assert bool(between) is is_checked
    if is_checked:  # but not what cannot move, or not as far
        assert ("left_base_link_inertia", "right_base_link_inertia") not in between
