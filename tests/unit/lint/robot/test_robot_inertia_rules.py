from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from robot_xml import ARM, INERTIAL, check, joint, link, only, plugin, rules

DATA = Path(__file__).parents[3] / "data" / "checks" / "robot"
AXES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def inertial(mass: float | str, *moments: float) -> str:
    ixx, iyy, izz, ixy, ixz, iyz = (*moments, 0.0, 0.0, 0.0)[:6]
    values = zip(AXES, (ixx, ixy, ixz, iyy, iyz, izz), strict=True)
    tensor = " ".join(f'{axis}="{value}"' for axis, value in values)
    return f'<inertial><mass value="{mass}"/><inertia {tensor}/></inertial>'


def with_link(inside: str) -> list[str]:
    return rules(check(ARM, joint("wrist", "arm", "hand"), link("hand", inside)))


BOX = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'


@pytest.mark.parametrize(
    ("inside", "rule"),
    [
        ("", "no-inertia"),
        (inertial(0, 1, 1, 1), "bad-mass"),
        (inertial(-1, 1, 1, 1), "bad-mass"),
        (inertial(1, 0, 0, 0), "bad-inertia"),
        (inertial(1, -0.1, 0.1, 0.1), "bad-inertia"),
        (inertial(1, 0.01, 0.01, 0.01, 0.02), "bad-inertia"),  # product too large
        (inertial(1, 0.01, 0.01, 0.03), "bad-inertia"),  # triangle
        (inertial(1, 1e-9, 1e-9, 1e-9), "implausible-inertia"),
        (inertial(0.01, 2, 2, 2), "implausible-inertia"),  # 14 m around its centre
        (inertial(1, 1, 1, 1) + BOX, "implausible-inertia"),  # 1 m, and a box of 10 cm
        ("<inertial><mass value='1'/></inertial>", "incomplete-inertial"),
        (
            "<inertial><inertia ixx='1' iyy='1' izz='1'/></inertial>",
            "incomplete-inertial",
        ),
    ],
)
def test_a_link_that_no_body_could_be(inside: str, rule: str) -> None:
    assert with_link(inside) == [rule]


@pytest.mark.parametrize(
    "inside",
    [
        INERTIAL,
        inertial(1, 1 / 600, 1 / 600, 1 / 600) + BOX,
        inertial(1, 0.01, 0.01, 0.02),  # a disc: the triangle's edge
        inertial(1e-3, 1e-6, 1e-6, 1e-6),
    ],
)
def test_a_link_that_could_be(inside: str) -> None:
    assert with_link(inside) == []


def test_extreme_numbers_neither_overflow_nor_divide_by_zero() -> None:
    for values in ((1e300, 1, 1), (1, 1, 1, 1e-200), (1e-320, 1e-320, 1e-320)):
        check(ARM, joint("wrist", "arm", "hand"), link("hand", inertial(1, *values)))


def test_links_of_real_robots_are_no_false_alarm() -> None:
    rows = yaml.safe_load((DATA / "upstream_links.yaml").read_text("utf-8"))["links"]
    parts = []
    for row in rows:
        tensor = dict(zip(AXES, row["inertia"], strict=True))
        text = " ".join(f'{axis}="{value}"' for axis, value in tensor.items())
        inside = f'<inertial><mass value="{row["mass"]}"/><inertia {text}/></inertial>'
        if "cylinder" in row:
            radius, length = row["cylinder"]
            inside += (
                "<collision><geometry>"
                f'<cylinder radius="{radius}" length="{length}"/>'
                "</geometry></collision>"
            )
        parts += [
            joint(f"to_{row['name']}", "world", row["name"]),
            link(row["name"], inside),
        ]
    assert len(rows) > 100
    assert check(link("world", ""), *parts) == []


def test_a_base_without_inertia_is_dropped_by_gazebo() -> None:
    parts = (link("base", ""), joint("hinge", "base", "arm"), link("arm"))
    assert check(*parts) == []
    finding = only(check(*parts, plugin("libother.so")), "no-inertia")
    assert finding.severity == "error"
    assert "carries" in finding.message


def test_links_that_need_no_inertia_of_their_own() -> None:
    pad = joint("mount", "hand", "pad", "", "fixed") + link("pad")
    assert check(ARM, joint("wrist", "arm", "hand"), link("hand", ""), pad) == []
    assert check(link("a", ""), joint("j", "a", "b"), link("b", "")) == []  # drawn only
    fixed = joint("mount", "arm", "imu", "", "fixed")
    assert check(ARM, fixed, link("imu", inertial(0, 0, 0, 0))) == []
    assert check(ARM, fixed, link("imu", inertial(0.001, 1e-4, 1e-4, 1e-4) + BOX)) == []
    negative = check(ARM, fixed, link("imu", inertial(-1, 1, 1, 1)))
    assert only(negative, "bad-mass").severity == "error"


@pytest.mark.parametrize(
    ("inside", "more", "rule", "severity"),
    [
        (inertial(1, 0.01, 0.01, 0.03), "", "bad-inertia", "warning"),
        (inertial(1, -0.01, 0.01, 0.01), "", "bad-inertia", "error"),
        (inertial(0, 1, 1, 1), "", "bad-mass", "warning"),
        (inertial(0, 1, 1, 1), plugin("libother.so"), "bad-mass", "error"),
    ],
)
def test_what_gazebo_runs_all_the_same_is_a_warning(
    inside: str, more: str, rule: str, severity: str
) -> None:
    found = check(ARM, joint("wrist", "arm", "hand"), link("hand", inside), more)
    assert only(found, rule).severity == severity
