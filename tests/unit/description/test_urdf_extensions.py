from pathlib import Path

import pytest

from tool0.description.model import Interface, RobotModel, Surface
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.errors import DescriptionError, LimitsError, ModelError

ROBOT = """<robot name="r"><link name="pad"/><link name="finger"/>
<joint name="elbow_joint" type="continuous"><parent link="pad"/><child link="finger"/>
</joint>
{}
</robot>"""
EFFORT = "hardware_interface/EffortJointInterface"
GRIPPER = (
    '<parallel_gripper name="g" joint="elbow_joint" pad_offset="0.005" pad_cos="0.04" '
    'pad_sin="-0.04" max_opening="0.08" min_speed="0.02" max_speed="0.15" '
    'min_force="20" max_force="235"/>'
)


def read(body: str) -> RobotModel:
    return read_model(parse_text(ROBOT.format(body), Path("r.urdf")))


def transmission(
    joint: str = "elbow_joint", in_joint: str = "", in_actuator: str = ""
) -> str:
    return (
        f'<transmission name="t"><joint name="{joint}">{in_joint}</joint>'
        f'<actuator name="m">{in_actuator}</actuator></transmission>'
    )


def interface(text: str) -> str:
    return f"<hardwareInterface>{text}</hardwareInterface>"


@pytest.mark.parametrize("expected", list(Interface))
@pytest.mark.parametrize("prefix", ["", "hardware_interface/"])
def test_reads_the_interface_with_and_without_its_package(
    expected: Interface, prefix: str
) -> None:
    text = interface(prefix + expected.value.partition("/")[2])
    (found,) = read(transmission(in_joint=text)).transmissions
    assert found.interface is expected
    assert found.armature == 0


def test_the_joints_interface_goes_before_the_actuators() -> None:
    position = interface("PositionJointInterface")
    (both,) = read(
        transmission("elbow_joint", interface(EFFORT), position)
    ).transmissions
    (one,) = read(transmission(in_actuator=position)).transmissions
    assert both.interface is Interface.EFFORT
    assert one.interface is Interface.POSITION


def test_reads_the_motor() -> None:
    motor = (
        "<mechanicalReduction>26</mechanicalReduction><rotorInertia>2e-5</rotorInertia>"
    )
    (found,) = read(
        transmission(in_joint=interface(EFFORT), in_actuator=motor)
    ).transmissions
    assert found.mechanical_reduction == 26
    assert found.armature == pytest.approx(2e-5 * 26**2)


@pytest.mark.parametrize(
    ("body", "named"),
    [
        (transmission(in_joint=interface("hardware/interface/EffortJointInterface")),
         "'hardware_interface/EffortJointInterface'"),
        (transmission(in_joint=interface("hardware_interface/EfortJointInterface")),
         "'hardware_interface/EffortJointInterface'"),
        (transmission(), "<hardwareInterface>"),
        (transmission("elbow", interface(EFFORT)),
         "'elbow_joint'"),
        (transmission(in_joint=interface(EFFORT)) * 2, "'elbow_joint'"),
        ("<transmission name='t'/>", "<joint>"),
        (transmission(in_joint=interface(EFFORT),
                      in_actuator="<mechanicalReduction>0</mechanicalReduction>"),
         "reduction 0"),
        (transmission(in_joint=interface(EFFORT),
                      in_actuator="<rotorInertia>-1</rotorInertia>"), "inertia -1"),
        (transmission(in_joint=interface(EFFORT),
                      in_actuator="<rotorInertia>x</rotorInertia>"),
         "'x'"),
        ('<gazebo reference="pad"><mu1>-1</mu1></gazebo>', "<mu1>"),
        ('<gazebo reference="pad"><kp>stiff</kp></gazebo>', "'stiff'"),
        ('<gazebo reference="pad"><selfCollide>maybe</selfCollide></gazebo>',
         "'maybe'"),
        (GRIPPER.replace("elbow_joint", "knee"), "'knee'"),
        (GRIPPER.replace("235", "nan"), "'nan'"),
        (GRIPPER.replace('"0.08"', '"0.2"'), "0.2"),
    ],
)  # fmt: skip
def test_refuses_what_cannot_be_driven_or_touched(body: str, named: str) -> None:
    with pytest.raises((ModelError, DescriptionError)) as caught:
        read(body)
    assert named in str(caught.value)
    assert str(caught.value.location) == "r.urdf:4"


def test_a_reference_to_what_is_not_there_is_told(
    caplog: pytest.LogCaptureFixture,
) -> None:
    read('<gazebo reference="pads"><mu1>1</mu1></gazebo>')
    for named in ("r.urdf:4", "'pads'", "'pad'"):
        assert named in caplog.text


def test_refuses_speeds_the_wrong_way_round() -> None:
    with pytest.raises(LimitsError):
        read(GRIPPER.replace('min_speed="0.02"', 'min_speed="0.2"'))


def test_all_gazebo_elements_of_a_link_count_together() -> None:
    model = read(
        '<gazebo reference="pad"><mu1>1.5</mu1><kp>100000.0</kp></gazebo>'
        '<gazebo reference="pad"><minDepth>0.001</minDepth><maxVel>0.1</maxVel>'
        "<selfCollide>true</selfCollide></gazebo>"
        '<gazebo reference="elbow_joint"><implicitSpringDamper>1</implicitSpringDamper>'
        "</gazebo><gazebo><plugin/></gazebo>"
    )
    pad = model.link("pad")
    assert pad.surface == Surface(mu1=1.5)
    finger = model.link("finger")
    assert finger.surface is None


def test_reads_a_parallel_gripper() -> None:
    (gripper,) = read(GRIPPER).grippers
    assert gripper.position(gripper.opening(0.3)) == pytest.approx(0.3)
    assert (gripper.speed, gripper.force) == ((0.02, 0.15), (20, 235))
