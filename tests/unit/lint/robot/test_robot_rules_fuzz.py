"""Whatever is done to a robot, its rules neither raise nor hang."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from robot_xml import DRIVEN, joint, link, root_of

from tool0.description.expansion import expand
from tool0.description.loading import assemble
from tool0.description.xml_source import LocatedElement, parse_file, parse_text
from tool0.lint.robot.elements import Tag
from tool0.lint.robot_file import robot_findings, xacro_findings

pytestmark = pytest.mark.slow

URDF = assemble().urdf
DATA = Path(__file__).parents[3] / "data" / "checks" / "robot"
FAULTY = DATA / "arm_with_gripper.urdf.xacro"
TEXTS = st.one_of(
    st.sampled_from(
        ["", "0", "-1", "1e308", "-1e-320", "nan", "inf", "0 0 0", "1_0", "package://"]
    ),
    st.sampled_from(
        ["world", "tool0", "finger_joint", "fixed", "gearbox", "~x/y.stl", "${a}"]
    ),
    st.text(max_size=20),
)
CHANGES = st.lists(
    st.tuples(
        st.sampled_from(["remove", "repeat", "rename", "write", "text", "drop"]),
        st.integers(0, 10_000),
        TEXTS,
    ),
    min_size=1,
    max_size=8,
)


def changed(
    root: LocatedElement, changes: list[tuple[str, int, str]]
) -> LocatedElement:
    """Return ``root`` after a few changes somewhere in it."""
    for what, where, text in changes:
        elements = [tag.element for tag in Tag(root).descendants() if tag.element]
        element = elements[where % len(elements)]
        keys = sorted(element.attributes.keys())
        parent = element.parentNode
        if what == "remove" and element is not root and parent:
            parent.removeChild(element)
        elif what == "repeat" and element is not root and parent:
            parent.appendChild(element.cloneNode(True))
        elif what == "rename":
            other = elements[(where * 7) % len(elements)]
            element.tagName = other.tagName
        elif what == "write" and keys:
            element.setAttribute(keys[where % len(keys)], text)
        elif what == "drop" and keys:
            element.removeAttribute(keys[where % len(keys)])
        elif what == "text":
            for node in list(element.childNodes):
                if node.nodeType == node.TEXT_NODE:
                    element.removeChild(node)
            document = element.ownerDocument
            assert document is not None
            element.appendChild(document.createTextNode(text))
    return root


def judge(root: LocatedElement) -> None:
    for finding in (
        *robot_findings(root),
        *robot_findings(root, spawned=True),
        *xacro_findings(root),
    ):
        assert finding.message
        str(finding)


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(changes=CHANGES, source=st.sampled_from(["expanded", "xacro", "ours"]))
def test_a_damaged_robot_is_judged(
    changes: list[tuple[str, int, str]], source: str
) -> None:
    readers = {"expanded": lambda file: expand(file).document, "xacro": parse_file}
    document = readers[source](FAULTY) if source in readers else parse_text(URDF)
    root = document.documentElement
    assert isinstance(root, LocatedElement)
    judge(changed(root, changes))


def test_large_and_wrong_robots_take_no_longer_than_they_must() -> None:
    count = 1500
    no_inertia = "<inertial/>"
    chain = [joint(f"j{i}", f"l{i}", f"l{i + 1}", "") for i in range(count)]
    circle = [
        joint(f"m{i}", "l0", f"k{i}", f'<mimic joint="m{(i + 1) % count}"/>')
        for i in range(count)
    ]
    lost = [joint(f"x{i}", f"nowhere{i}", f"far{i}", "") for i in range(count)]
    fixed = [joint(f"f{i}", f"l{i + 1}", f"l{i}", "", "fixed") for i in range(count)]
    links = [link(f"l{i}", no_inertia) for i in range(count + 1)]
    for parts in (chain, circle, lost, fixed):
        begun = time.process_time()
        judge(root_of(DRIVEN, *links, *parts))
        assert time.process_time() - begun < 10
