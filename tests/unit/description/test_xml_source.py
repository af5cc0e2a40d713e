from pathlib import Path

import pytest

from tool0.description.xml_source import children, locate, parse_text, to_text
from tool0.errors import DescriptionError

FILE = Path("robot.urdf")


def test_each_element_knows_its_line() -> None:
    root = parse_text("<a>\n  <b/>\n\n  <c><d\n x='1'/></c></a>", FILE).documentElement
    assert root is not None
    lines = {tag: locate(root.getElementsByTagName(tag)[0]) for tag in "bcd"}
    assert {tag: str(found) for tag, found in lines.items()} == {
        "b": "robot.urdf:2",
        "c": "robot.urdf:4",
        "d": "robot.urdf:4",
    }


def test_a_clone_keeps_its_line_and_shares_nothing() -> None:
    document = parse_text("<a>\n<b k='1'>text<c/></b></a>", FILE)
    original = document.getElementsByTagName("b")[0]
    clone = original.cloneNode(True)
    clone.setAttribute("k", "2")
    assert str(locate(clone)) == "robot.urdf:2"
    assert original.getAttribute("k") == "1"
    assert [child.tagName for child in children(clone)] == ["c"]
    assert clone.firstChild is not None
    assert clone.firstChild.nodeValue == "text"


def test_writing_and_parsing_again_is_a_fixed_point() -> None:
    text = """<robot name="a &amp; &quot;b&quot; &lt;">
      <!-- gone -->
      <plugin>1 &lt; 2 &amp; 3</plugin>
      <link name="x"><visual/></link>
    </robot>"""
    once = to_text(parse_text(text))
    assert to_text(parse_text(once)) == once
    root = parse_text(once).documentElement
    assert root is not None
    assert root.getAttribute("name") == 'a & "b" <'
    plugin = root.getElementsByTagName("plugin")[0].firstChild
    assert plugin is not None
    assert plugin.nodeValue == "1 < 2 & 3"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("<a>\n<b>\n</a>", 3),
        ("", 1),
        ("<a>\n <x:b/></a>", 2),
        ('<!DOCTYPE a [\n<!ENTITY e "ha">]>\n<a>&e;</a>', 1),
    ],
)
def test_refuses_what_is_not_plain_xml(text: str, line: int) -> None:
    with pytest.raises(DescriptionError) as caught:
        parse_text(text, FILE)
    assert str(caught.value.location) == f"robot.urdf:{line}"
