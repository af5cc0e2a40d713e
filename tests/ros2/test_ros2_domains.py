"""Several bring-ups: in domains of their own, and in one, with namespaces."""

from __future__ import annotations

import pytest
from ros import Bringup
from ros2_client import Client
from ros2_domain import Domain
from ros2_manager import Manager
from ros2_rig import JTC, STATE, arrive, distance, follow, go, trajectory
from ur5_rig import HOME
from waits import until

NEAR = tuple(q + 0.2 for q in HOME)


def test_two_bringups_in_two_domains_do_not_see_each_other(
    domain: Domain, client: Client, bringup: Bringup, own_domain: Domain
) -> None:
    """The second one is told its domain by the option."""
    other_client = own_domain.client()
    domain.bring_up("--name", "second", "--domain", str(own_domain.id))
    topic = f"/{JTC}/controller_state"
    with (
        client.listening(topic, STATE) as states,
        other_client.listening(topic, STATE) as other_states,
    ):
        for one in (client, other_client):
            publishers = until(lambda one=one: one.publishers(topic), "a publisher")
            assert len(publishers) == 1
        go(client, states, HOME)
        go(other_client, other_states, HOME)
        assert follow(client, trajectory([(0.6, NEAR)])).outcome()[0] == "succeeded"
        arrive(states, NEAR)
        assert distance(other_states, HOME) < 0.01


def test_two_bringups_in_one_domain_need_namespaces(own_domain: Domain) -> None:
    client = own_domain.client()
    sides = ("left", "right")
    for side in sides:
        own_domain.bring_up("--name", side, "--ros2-ns", side, wait=False)
    for one in own_domain.bringups:
        one.wait()
    for side in sides:
        names = {f"/{side}/controller_manager", f"/{side}/{JTC}"}
        until(lambda names=names: names <= set(client.nodes()), f"the nodes of {side}")
        states = Manager(client, f"/{side}/controller_manager").states()
        assert states[JTC] == "active"
    left, right = (f"/{side}/{JTC}/controller_state" for side in sides)
    with client.listening(left, STATE) as moved, client.listening(right, STATE) as held:
        before = held.last.feedback.positions
        goal = follow(client, trajectory([(1.5, HOME)]), f"left/{JTC}")
        assert goal.outcome()[0] == "succeeded"
        arrive(moved, HOME)
        assert held.next()[0].feedback.positions == pytest.approx(before, abs=5e-3)


def test_two_bringups_of_the_same_names_are_warned_about(own_domain: Domain) -> None:
    first = own_domain.bring_up("--name", "first")
    own_domain.bring_up("--name", "second")
    first.wait_for("another bring-up publishes /robot_description in this domain")
