import xml.etree.ElementTree as ET
from pathlib import Path

from tool0.description.catalogue import RobotDescription, assemble, load_robot
from tool0.engines.gazebo.colours import paint

BOX = "<visual><geometry><box size='1 1 1'/></geometry>{}</visual>"
ROBOT = f"""\
<robot name="r">
  <material name="red"><color rgba="1 0 0 0.5"/></material>
  <link name="a">
    {BOX.format("")}
    {BOX.format("<material name='red'/>")}
  </link>
</robot>
"""


def painted(description: RobotDescription) -> ET.Element:
    robot = ET.fromstring(description.urdf)
    paint(robot, description.model)
    return robot


def test_every_shape_keeps_its_place_and_gets_its_colour() -> None:
    description = assemble("ur5", "2f85")
    robot = painted(description)
    parents = {
        joint.find("child").get("link"): joint.find("parent").get("link")  # type: ignore[union-attr]
        for joint in robot.iterfind("joint[@type='fixed']")
    }
    links = {link.get("name"): link for link in robot.iterfind("link")}
    for link in description.model.links:
        for number, visual in enumerate(link.visuals):
            own = f"tool0_paint_{number}_{link.name}"
            assert parents[own] == link.name
            (shape,) = links[own]
            assert shape.tag == "visual"
            diffuse = robot.findtext(
                f"gazebo[@reference='{own}']/visual/material/diffuse", ""
            )
            assert tuple(map(float, diffuse.split())) == visual.rgba
        assert links[link.name].find("visual") is None


def test_what_has_no_colour_or_its_own_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(ROBOT)
    robot = painted(load_robot(file))
    (left,) = robot.findall("link[@name='a']/visual")
    assert left.find("material") is None
    extension = robot.find("gazebo[@reference='tool0_paint_1_a']/visual")
    assert extension is not None
    assert extension.findtext("transparency") == "0.5"


def test_collada_brings_its_own_colours(tmp_path: Path) -> None:
    (tmp_path / "shape.dae").touch()
    file = tmp_path / "robot.urdf"
    file.write_text(
        ROBOT.replace("<box size='1 1 1'/>", "<mesh filename='shape.dae'/>")
    )
    robot = painted(load_robot(file))
    assert len(robot.findall("link[@name='a']/visual")) == 2
    assert robot.findall("gazebo") == []
