"""``<ros2_control>`` tags: driven joints, limits, mimic joints, sensors; and faults."""

from __future__ import annotations

from pathlib import Path

import pytest

from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.model import Interface, Mimic, RobotModel
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.errors import DescriptionError, LimitsError, ModelError, Tool0Error

HARDWARE = "<hardware><plugin>maker/Driver</plugin></hardware>"
POSITION = '<command_interface name="position"/>'
ROBOT = """\
<robot name="arm">
  <link name="base"/>
  {joints}
  <joint name="wrist" type="fixed">
    <parent link="elbow_link"/><child link="tool0"/></joint><link name="tool0"/>
{rest}
</robot>
"""


def joint(name: str, parent: str, mimic: str = "") -> str:
    return (
        f'<link name="{name}_link"/><joint name="{name}" type="revolute">'
        f'<parent link="{parent}"/><child link="{name}_link"/>{mimic}'
        '<limit lower="-2" upper="3" effort="50" velocity="4"/></joint>'
    )


def read(*rest: str, mimic: str = "") -> RobotModel:
    """Return an arm of two joints with two fingers; ``rest`` starts in line 6."""
    joints = (
        joint("lift", "base"),
        joint("elbow", "lift_link"),
        joint("finger", "tool0"),
        joint("thumb", "tool0", mimic),
    )
    text = ROBOT.format(joints="".join(joints), rest="\n".join(rest))
    return read_model(parse_text(text, Path("arm.urdf")))


def control(*items: str, name: str = "arm", kind: str = "system") -> str:
    inside = "\n".join(items)
    return (
        f'<ros2_control name="{name}" type="{kind}">{HARDWARE}\n{inside}</ros2_control>'
    )


def driven(name: str, *parts: str) -> str:
    return f'<joint name="{name}">{"".join(parts)}</joint>'


def command(name: str, **params: object) -> str:
    return interface("command", name, **params)


def interface(kind: str, name: str, **params: object) -> str:
    inside = "".join(f'<param name="{k}">{v}</param>' for k, v in params.items())
    return f'<{kind}_interface name="{name}">{inside}</{kind}_interface>'


FOLLOWS = '<mimic joint="finger" multiplier="-1"/>'
WRENCH = "".join(
    interface("state", f"{kind}.{axis}")
    for kind in ("force", "torque")
    for axis in "xyz"
)


def test_a_joint_is_driven_through_its_command_interfaces() -> None:
    states = interface("state", "position") + interface("state", "effort")
    model = read(
        control(
            driven("elbow", command("velocity"), command("position"), states),
            driven("lift", command("effort")),
            driven("finger", states),
        )
    )
    assert {item.joint: item.interfaces for item in model.transmissions} == {
        "elbow": (Interface.VELOCITY, Interface.POSITION),
        "lift": (Interface.EFFORT,),
    }
    (component,) = model.hardware
    assert (component.name, component.type) == ("arm", "system")
    assert component.plugin == "maker/Driver"
    assert component.command_interfaces == (
        "elbow/velocity",
        "elbow/position",
        "lift/effort",
    )
    assert component.state_interfaces[:2] == ("elbow/position", "elbow/effort")


def test_without_tags_transmissions_say_what_is_driven() -> None:
    model = read(TRANSMISSION)
    assert model.transmission_by_joint["lift"].interfaces == (Interface.EFFORT,)
    assert not model.hardware


TRANSMISSION = """\
<transmission name="drive"><joint name="lift">
<hardwareInterface>EffortJointInterface</hardwareInterface></joint>
<actuator name="motor"><mechanicalReduction>100</mechanicalReduction>
<rotorInertia>2e-4</rotorInertia></actuator></transmission>"""


def test_a_transmission_of_a_driven_joint_is_only_data() -> None:
    model = read(TRANSMISSION, control(driven("lift", POSITION)))
    (drive,) = model.transmissions
    assert drive.interfaces == (Interface.POSITION,)
    assert drive.armature == pytest.approx(2.0)


def test_a_joint_states_its_motor() -> None:
    inside = (
        '<transmission name="t"><joint name="elbow" role="joint1">'
        "<mechanical_reduction>50</mechanical_reduction></joint></transmission>"
    )
    motor = (
        '<param name="mechanical_reduction">10</param>'
        '<param name="rotor_inertia">1e-3</param>'
        '<param name="gravity_compensation">true</param>'
    )
    elbow = driven("elbow", POSITION, '<param name="rotor_inertia">1e-3</param>')
    model = read(control(driven("lift", POSITION, motor), elbow, inside))
    drives = model.transmission_by_joint
    assert drives["lift"].armature == pytest.approx(0.1)
    assert drives["lift"].gravity_compensation
    assert drives["elbow"].armature == pytest.approx(2.5)


def test_limits_of_commands_are_those_of_the_drive() -> None:
    position = command("position", min=-1, max="1.5")
    velocity = command("velocity", min=-0.5, max=0.5)
    model = read(control(driven("lift", position, velocity), driven("elbow", POSITION)))
    limits = model.transmission_by_joint["lift"].command_limits
    assert (limits.lower, limits.upper, limits.velocity) == (-1.0, 1.5, 0.5)
    assert model.joint("lift").limits.upper == 3.0  # the joint itself goes further


def test_initial_values_are_the_start() -> None:
    states = interface("state", "position", initial_value="-1.57")
    rate = interface("state", "velocity", initial_value="0.3")
    model = read(control(driven("lift", POSITION, states, rate), driven("elbow", rate)))
    assert model.initial_positions == {"lift": -1.57}


@pytest.mark.parametrize(
    ("tag", "expected"),
    [
        ('<joint name="thumb"/>', -1.0),
        ('<joint name="thumb" mimic="true"/>', -1.0),
        ('<joint name="thumb" mimic="false"/>', None),
        ('<joint name="thumb"><param name="mimic">finger</param></joint>', -1.0),
        (
            '<joint name="thumb"><param name="mimic">finger</param>'
            '<param name="multiplier">2</param></joint>',
            2.0,
        ),
    ],
)
def test_the_tag_says_whether_a_joint_follows(tag: str, expected: float | None) -> None:
    model = read(control(driven("finger", POSITION), tag), mimic=FOLLOWS)
    mimic = model.joint("thumb").mimic
    assert (None if mimic is None else mimic.multiplier) == expected


def test_old_parameters_couple_a_joint_without_mimic() -> None:
    tag = driven(
        "thumb",
        '<param name="mimic">finger</param><param name="multiplier">0.5</param>',
    )
    commanded = tag.replace("</joint>", f"{POSITION}</joint>")  # as mock hardware wants
    for each in (tag, commanded):
        model = read(control(driven("finger", POSITION), each))
        assert model.joint("thumb").mimic == Mimic(joint="finger", multiplier=0.5)
        assert set(model.transmission_by_joint) == {"finger"}


def test_a_follower_that_is_released_can_be_driven() -> None:
    tag = f'<joint name="thumb" mimic="false">{POSITION}</joint>'
    model = read(control(driven("finger", POSITION), tag), mimic=FOLLOWS)
    assert set(model.transmission_by_joint) == {"finger", "thumb"}


def test_a_force_torque_sensor_measures_at_its_frame_or_flange() -> None:
    at_link = '<param name="frame_id">elbow_link</param>'
    model = read(
        control(
            f'<sensor name="tcp_fts_sensor">{WRENCH}</sensor>',
            f'<sensor name="other">{WRENCH}{at_link}</sensor>',
            f'<sensor name="tcp_pose">{interface("state", "position.x")}</sensor>',
        )
    )
    assert model.wrench_sensors == {"tcp_fts_sensor": "tool0", "other": "elbow_link"}


def test_every_joint_is_driven_if_asked_and_nothing_says_which(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    joints = joint("lift", "base") + joint("thumb", "lift_link", FOLLOWS)
    fingers = joint("finger", "lift_link")
    silent = ROBOT.format(joints=joints + fingers, rest="").replace("elbow_l", "lift_l")
    told = silent.replace("</robot>", f"{TRANSMISSION}</robot>")
    for text, driven_joints in ((silent, ["lift", "finger"]), (told, ["lift"])):
        file = tmp_path / "arm.urdf"
        file.write_text(text)
        config = DescriptionConfig(robot=file, ros2_control=True)
        description = load_description(config)
        drives = description.model.transmission_by_joint
        assert list(drives) == driven_joints
        assert ("<ros2_control" in description.urdf) == (text is silent)
    assert drives["lift"].interfaces == (Interface.EFFORT,)
    (record,) = caplog.records
    assert "arm.urdf:1: no <ros2_control> tag" in record.message
    assert not read().transmissions


def test_inputs_and_outputs_are_listed() -> None:
    io = '<gpio name="io"><command_interface name="out_0"/></gpio>'
    old = driven("speed_scaling", interface("state", "speed_scaling_factor"))
    extra = driven("finger", POSITION, command("set_gripper_max_velocity"))
    model = read(control(io, old, extra))
    (component,) = model.hardware
    assert component.command_interfaces == (
        "io/out_0",
        "finger/position",
        "finger/set_gripper_max_velocity",
    )
    assert set(model.transmission_by_joint) == {"finger"}


def test_the_driver_of_a_gripper_limits_speed_and_effort() -> None:
    cmd = '<command_interface name="reactivate_gripper_cmd"/>'
    gpio = f'<gpio name="reactivate_gripper">{cmd}</gpio>'
    model = read(control(driven("finger", POSITION), driven("thumb"), gpio))
    (component,) = model.hardware
    assert component.command_interfaces == (
        "finger/position",
        "finger/set_gripper_max_velocity",
        "finger/set_gripper_max_effort",
        "reactivate_gripper/reactivate_gripper_cmd",
    )


@pytest.mark.parametrize(
    ("text", "kind", "line", "words"),
    [
        (control(driven("elbwo", POSITION)), ModelError, 7, ["'elbwo'", "'elbow'"]),
        (
            control(driven("lift", command("postion"))),
            DescriptionError,
            7,
            ["command interface 'postion'", "'lift'", "mean 'position'"],
        ),
        (
            control(driven("lift", POSITION, interface("state", "velcity"))),
            DescriptionError,
            7,
            ["state interface 'velcity'", "'velocity'"],
        ),
        (control(driven("wrist", POSITION)), ModelError, 7, ["'wrist' is fixed"]),
        (control(kind="sytem"), DescriptionError, 6, ["'sytem'", "'system'"]),
        (
            '<ros2_control name="arm" type="system"/>',
            DescriptionError,
            6,
            ["<hardware>"],
        ),
        (
            '<ros2_control name="arm" type="system"><hardware/></ros2_control>',
            DescriptionError,
            6,
            ["<plugin>"],
        ),
        (control() + control(), ModelError, 7, ["second component 'arm'"]),
        (
            control(driven("lift", POSITION), driven("lift", POSITION)),
            ModelError,
            8,
            ["second joint 'lift'"],
        ),
        (
            control(driven("lift", POSITION, POSITION)),
            ModelError,
            7,
            ["second command interface 'position'"],
        ),
        (
            control(driven("lift", POSITION))
            + control(driven("lift", POSITION), name="other"),
            ModelError,
            8,
            ["'lift' is commanded by two components, 'arm'"],
        ),
        (
            control(driven("lift", command("position", min=1, max=-1))),
            LimitsError,
            7,
            ["min 1 above max -1"],
        ),
        (
            control(driven("lift", command("position", min=5, max=6))),
            LimitsError,
            7,
            ["'lift'", "[5, 6]", "[-2, 3]"],
        ),
        (
            control(driven("lift", interface("state", "position", initial_value=9))),
            LimitsError,
            7,
            ["'lift'", "initial_value 9", "[-2, 3]"],
        ),
        (
            control(driven("lift", interface("state", "position", initial_value="x"))),
            DescriptionError,
            7,
            ["initial_value 'x'"],
        ),
        (
            control(driven("lift", POSITION, '<param name="rotor_inertia">-1</param>')),
            ModelError,
            7,
            ["'lift'", "rotor_inertia -1"],
        ),
        (
            control('<joint name="lift" mimic="true"/>'),
            ModelError,
            7,
            ["'lift'", 'mimic="true"', "no <mimic>"],
        ),
        (
            control('<joint name="lift" mimic="yes"/>'),
            DescriptionError,
            7,
            ["boolean 'yes'"],
        ),
        (
            control(driven("lift", '<param name="mimic">fingr</param>')),
            ModelError,
            7,
            ["'fingr'", "'finger'"],
        ),
    ],
)
def test_faults_name_file_line_and_remedy(
    text: str, kind: type[Tool0Error], line: int, words: list[str]
) -> None:
    with pytest.raises(kind) as error:
        read(text)
    assert str(error.value.location) == f"arm.urdf:{line}"
    for word in words:
        assert word in error.value.message


def test_a_follower_takes_no_commands() -> None:
    with pytest.raises(ModelError, match=r"'thumb' follows 'finger'.*mimic=\"false\""):
        read(control(driven("thumb", POSITION)), mimic=FOLLOWS)
    other = driven("thumb", '<param name="mimic">lift</param>')
    with pytest.raises(ModelError, match=r"'lift' here, and 'finger' where"):
        read(control(other), mimic=FOLLOWS)
