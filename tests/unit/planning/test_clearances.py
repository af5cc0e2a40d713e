"""Distances are MuJoCo's own, and no motion that is called free comes nearer."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from tool0.description.loading import assemble
from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box, Cylinder, Sphere
from tool0.description.surroundings import Plane, Surroundings
from tool0.description.transform import Pose, to_transform
from tool0.errors import CollisionError, PlanningError
from tool0.kernel.clearance import FREE, Cancelled
from tool0.kinematics.chain import Array, find_chains
from tool0.planning.planner import FreeMotion, SearchOptions, plan_free_motion
from tool0.planning.world import SLACK, CollisionWorld, PlanningGroup, Rules

MODEL = assemble("ur5", gripper="2f85").model
(CHAIN,) = find_chains(MODEL).values()
REST = {joint.name: 0.0 for joint in MODEL.movable_joints}
HOME = np.array([-1.57, -1.57, 1.57, -1.57, -1.57, 0.0])
OBSTACLES = (
    SceneObject(
        name="wall", geometry=Box(size=(0.5, 0.03, 0.6)), pose=Pose(xyz=(0.6, 0.0, 0.3))
    ),
    SceneObject(
        name="can",
        geometry=Cylinder(radius=0.05, length=0.3),
        pose=Pose(xyz=(-0.5, 0.2, 0.2), rpy=(0.3, 0.2, 0.1)),
    ),
    SceneObject(name="ball", geometry=Sphere(radius=0.1), pose=Pose(xyz=(0, 0.6, 0.7))),
)
CLEARANCE = 0.005


def looks_at(
    *objects: SceneObject, planes: tuple[Plane, ...] = (), **rules: float
) -> PlanningGroup:
    """Return what looks at the arm's motions among obstacles."""
    usual = REST | dict(zip(CHAIN.joint_names, HOME, strict=True))
    states = []
    for item in objects:
        T = to_transform(item.pose)
        states.append((item, ObjectState(item.name, T.position, T.quat_wxyz)))
    around = Surroundings(positions=REST, objects=tuple(states), planes=planes)
    return CollisionWorld(MODEL, -0.6, usual).group(
        CHAIN.joint_names, around, Rules(**{"clearance": CLEARANCE} | rules)
    )


@pytest.fixture(scope="module")
def group() -> PlanningGroup:
    return looks_at(*OBSTACLES)


def free_postures(group: PlanningGroup, rng: np.random.Generator) -> Iterator[Array]:
    while True:
        q = rng.uniform(-np.pi, np.pi, 6)
        if group.clearances.at(q) == FREE:
            yield q


def direct(group: PlanningGroup, q: Array, most: float) -> dict[frozenset[str], float]:
    """Return the distance of every two bodies by MuJoCo alone, up to ``most``."""
    owner = group.owner
    data = mujoco.MjData(owner.model)
    data.qpos[:] = owner.data.qpos
    data.qpos[owner.addresses(CHAIN.joint_names)] = q
    mujoco.mj_kinematics(owner.model, data)
    found: dict[frozenset[str], float] = {}
    for one, two in itertools.combinations(owner.shapes, 2):
        names = frozenset((one.owner, two.owner))
        if names in map(frozenset, group.names):
            away = mujoco.mj_geomDistance(
                owner.model, data, one.geom, two.geom, most, None
            )
            found[names] = min(found.get(names, most), away)
    return found


def nearest(group: PlanningGroup, distances: Array) -> dict[frozenset[str], float]:
    found: dict[frozenset[str], float] = {}
    for names, away in zip(map(frozenset, group.names), distances, strict=True):
        found[names] = min(found.get(names, np.inf), float(away))
    return found


def test_distances_are_those_of_mujoco(group: PlanningGroup) -> None:
    rng = np.random.default_rng(1)
    for q in rng.uniform(-np.pi, np.pi, (2, 6)):
        ours = nearest(group, group.clearances.distances(q, 0.2))
        theirs = direct(group, q, 0.2)
        assert ours.keys() == theirs.keys()
        for names, away in theirs.items():
            # MuJoCo's own result depends a little on the order of a pair
            assert ours[names] == pytest.approx(away, abs=1e-4), names
    assert min(theirs.values()) < 0.2


def test_the_links_stay_apart_from_all_obstacles(group: PlanningGroup) -> None:
    watched = set(map(frozenset, group.names))
    for item in (*(thing.name for thing in OBSTACLES), "ground"):
        for link in ("forearm_link", "wrist_3_link", "left_inner_finger"):
            assert frozenset((item, link)) in watched
    # what touches by construction is left out, and so is what cannot move
    for pair in (("upper_arm_link", "forearm_link"), ("pedestal", "ground")):
        assert frozenset(pair) not in watched


def test_a_way_that_is_called_free_is_free_between_too(group: PlanningGroup) -> None:
    rng = np.random.default_rng(2)
    postures = free_postures(group, rng)
    n_free = n_not = 0
    for _ in range(60):
        start = next(postures)
        end = start + rng.normal(scale=0.5, size=6)
        group.begin(start)
        allowed = group.shared - SLACK
        found = group.clearances.along(np.array([start, end]))
        steps = int(np.ceil(np.abs(end - start).max() / 0.01))
        poses = start + np.linspace(0.0, 1.0, steps + 1)[:, None] * (end - start)
        most = float(allowed.max() + 1e-6)
        if found is None:
            n_free += 1
            for q in poses:
                away = group.clearances.distances(q, most)
                assert (away >= allowed - 1e-7).all()
        else:
            n_not += 1
            q = start + found.part * (end - start)
            away = group.clearances.distances(q, most + 0.01)[found.pair]
            assert away < group.shared[found.pair]
    assert n_free > 10
    assert n_not > 10


def test_the_place_of_a_collision_is_the_first(group: PlanningGroup) -> None:
    rng = np.random.default_rng(3)
    postures = free_postures(group, rng)
    n_found = 0
    while n_found < 10:
        start, end = next(postures), next(postures)
        found = group.clearances.along(np.array([start, end]))
        if found is None:
            continue
        n_found += 1
        for part in np.linspace(0.0, found.part, 100)[:-1]:
            q = start + part * (end - start)
            away = group.clearances.distances(q, 0.01)
            assert (away >= group.least - SLACK - 1e-7).all()


def among(group: PlanningGroup, *, seed: int = 0, timeout: float = 60.0) -> FreeMotion:
    """Plan from one side of the wall to the other."""
    start = np.array([-1.0, -0.9, 1.6, -2.2, -1.57, 0.0])
    goal = start.copy()
    goal[0] = 0.7
    return plan_free_motion(
        group,
        CHAIN.joints,
        start,
        goal[None],
        options=SearchOptions(seed=seed, timeout=timeout),
        cancelled=Cancelled(),
    )


def test_the_same_seed_finds_the_same_motion(group: PlanningGroup) -> None:
    first, again, other = (among(group, seed=seed) for seed in (4, 4, 5))
    assert not first.is_direct
    np.testing.assert_array_equal(first.path.positions, again.path.positions)
    np.testing.assert_array_equal(first.path.times, again.path.times)
    assert first.samples == again.samples
    assert first.waypoints.tolist() != other.waypoints.tolist()


@pytest.mark.parametrize("clearance", [0.0, 0.005])
def test_the_clearance_is_kept_on_the_whole_motion(clearance: float) -> None:
    group = looks_at(*OBSTACLES, clearance=clearance)
    for seed in range(2):
        path = among(group, seed=seed).path
        times = np.arange(0.0, path.duration, 0.01)
        q = path.at(times).positions
        assert min(group.clearances.distances(each, 0.006).min() for each in q) >= (
            clearance - 1e-7
        )


def test_a_plane_bounds_the_space() -> None:
    low = np.array([-0.5, -0.9, 1.6, -2.2, -1.57, 0.0])
    tool = float(CHAIN.forward(low[None]).T_base_tip[0, 2, 3])
    shelf = Plane("shelf", (0.0, 0.0, tool + 0.05), (0.0, 0.0, 1.0))
    assert "'shelf'" in looks_at(planes=(shelf,)).why_not(low)
    floor = Plane("floor", (0.0, 0.0, tool - 0.4), (0.0, 0.0, 1.0))
    assert not looks_at(planes=(floor,)).why_not(low)


def test_a_start_in_collision_is_named(group: PlanningGroup) -> None:
    into = np.array([0.0, -0.9, 1.6, -2.2, -1.57, 0.0])
    with pytest.raises(CollisionError, match=r"the start is in collision: '.*wall'"):
        group.begin(into)


def test_a_search_ends_in_time(group: PlanningGroup) -> None:
    with pytest.raises(PlanningError, match=r"no way found in 0\.\d s, with \d+ samp"):
        among(group, timeout=0.0)
