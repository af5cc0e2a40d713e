"""What the launch reader says, and what roslaunch itself makes of the same file."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from promised import require_ros

from tool0.description.yaml_tree import Tree
from tool0.installation.ros1.library import DEBIAN
from tool0.lint.launch import grammar
from tool0.lint.launch.model import LaunchFile, Parameter, Rosparam
from tool0.lint.launch.reader import read_launch
from tool0.lint.packages import PackageIndex

SOURCES = Path(__file__).parents[1] / "data" / "launch" / "src"
ASK = """
import json, sys
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

def shown(node):
    remaps = sorted(map(list, node.remap_args))
    return [node.package, node.type, node.args.split(), remaps]

def answer(file, arguments):
    config, loader = ROSLaunchConfig(), XmlLoader()
    loader.ignore_unset_args = False
    try:
        loader.load(file, config, argv=arguments, verbose=False)
    except Exception as error:
        return {"refused": str(error)}
    nodes = {node.namespace + node.name: shown(node) for node in config.nodes}
    params = {param.key: param.value for param in config.params.values()}
    return {"nodes": nodes, "params": params, "said": config.config_errors}

requests = json.load(sys.stdin)
print(json.dumps([answer(file, arguments) for file, *arguments in requests]))
"""


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Let both find our packages, and a xacro that repeats what it is given."""
    require_ros()
    folder = tmp_path_factory.mktemp("packages")
    for name in ("xacro", "robot_state_publisher", "roslaunch"):  # ROS is here
        (folder / name).mkdir()
        manifest = f"<package><name>{name}</name></package>"
        (folder / name / "package.xml").write_text(manifest)
    xacro = folder / "xacro" / "xacro"
    xacro.write_text("#!/bin/sh\necho robot\n")
    xacro.chmod(0o755)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_PACKAGE_PATH", f"{SOURCES}{os.pathsep}{folder}")
        yield folder


def theirs(requests: list[tuple[str, ...]]) -> Any:
    """Return what roslaunch makes of each file with its arguments."""
    found = [str(DEBIAN)] if (DEBIAN / "roslaunch").is_dir() else []
    path = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", ASK],
        input=json.dumps(requests),
        env={**os.environ, "PYTHONPATH": os.pathsep.join([*path, *found])},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def parameter(param: Parameter) -> dict[str, object]:
    """Return name and value of a <param>; None is known at run time alone."""
    if param.full_name is None:  # private, for the nodes that follow
        return {}
    text = param.content.resolved
    value: object = None
    if param.source == "value" and text is not None:
        kinds = {"auto": grammar.converted, "int": int, "double": float}
        kinds |= {"bool": grammar.as_boolean, "yaml": yaml.safe_load}
        value = kinds.get(param.type, str)(text.strip())
    return {param.full_name: value}


def yaml_of(rosparam: Rosparam) -> dict[str, object]:
    """Return the parameters that a <rosparam> loads, by full name."""
    if rosparam.yaml is None:
        return {}
    tree = Tree()
    text = textwrap.indent(rosparam.yaml.resolved or "", " ")
    tree.load(f"value:\n{text}", rosparam.yaml.location)
    found = {}
    for leaf in tree.root.leaves():
        name = f"{rosparam.namespace}/{leaf.key.removeprefix('value')}"
        if not leaf.is_null:
            found[grammar.canonical(name)] = leaf.plain()
    return found


def ours(launch: LaunchFile) -> Any:
    """Return the same of what our reader says."""
    nodes = {}
    for node in launch.nodes():
        args = "" if node.args is None else node.args.resolved or ""
        remaps = sorted([t.resolved for _, t in r.texts] for r in node.remaps)
        program = [node.package.resolved, node.type.resolved]
        nodes[node.full_name] = [*program, args.split(), remaps]
    params: dict[str, object] = {}
    for setting in launch.settings():  # the last that sets a parameter counts
        params.update(
            parameter(setting) if isinstance(setting, Parameter) else yaml_of(setting)
        )
    return json.loads(json.dumps({"nodes": nodes, "params": params, "said": []}))


def read(file: Path, **arguments: str) -> LaunchFile:
    return read_launch(file, arguments, PackageIndex())


def test_what_is_read_is_what_roslaunch_reads(packages: Path) -> None:
    quirks = SOURCES / "quirks" / "launch" / "quirks.launch"
    bring_up = SOURCES / "arm_gazebo" / "launch" / "arm_bringup.launch"
    cases: list[tuple[Path, dict[str, str]]] = [
        (quirks, {}),
        (quirks, {"count": "2", "name": "bob"}),
        (bring_up, {"rate": "50"}),
    ]
    requests = [
        (str(file), *(f"{name}:={value}" for name, value in arguments.items()))
        for file, arguments in cases
    ]
    for (file, arguments), answer in zip(cases, theirs(requests), strict=True):
        launch = read(file, **arguments)
        if file == bring_up:
            answer["params"]["/robot_description"] = None  # known at run time alone
        assert ours(launch) == answer
        assert [f for f in launch.findings if f.severity == "error"] == []


REFUSED = {
    "two values": '<arg name="a" value="1" default="2"/>',
    "declared twice": '<arg name="a" default="1"/><arg name="a" default="1"/>',
    "not declared": '<param name="p" value="$(arg a)"/>',
    "declared too late": '<env name="p" value="$(arg a)"/><arg name="a" default=""/>',
    "no package": '<param name="p" value="$(find absent_package)/x"/>',
    "no variable": '<param name="p" value="$(env NOT_SET_IN_TESTS)"/>',
    "no command": '<param name="p" value="$(seek x)"/>',
    "not closed": '<param name="p" value="$(arg $(dirname))"/>',
    "double underscore": '<param name="p" value="$(eval a.__class__)"/>',
    "no name in eval": '<param name="p" value="$(eval nothing)"/>',
    "eval in the middle": '<param name="p" value="x$(eval 1)"/>',
    "no boolean": '<param name="p" value="1" if="yes"/>',
    "if and unless": '<param name="p" value="1" if="1" unless="0"/>',
    "no value": '<param name="p"/>',
    "two sources": '<param name="p" value="1" command="echo 1"/>',
    "no number": '<param name="p" value="x" type="int"/>',
    "no type": '<param name="p" value="x" type="float"/>',
    "no file": '<rosparam file="/nowhere.yaml"/>',
    "delete from a file": '<rosparam command="delete" file="/x" param="p"/>',
    "no verb": '<rosparam command="save" param="p"/>',
    "no name": '<node pkg="p" type="t"/>',
    "a name with a slash": '<node name="a/b" pkg="p" type="t"/>',
    "two nodes": '<node name="a" pkg="p" type="t"/><node name="a" pkg="q" type="u"/>',
    "an empty namespace": '<group ns=""/>',
    "respawn and required": (
        '<node name="a" pkg="p" type="t" respawn="true" required="true"/>'
    ),
    "no output": '<node name="a" pkg="p" type="t" output="file"/>',
    "no such truth": '<node name="a" pkg="p" type="t" respawn="1"/>',
    "no launch file": '<include file="/nowhere.launch"/>',
    "an argument more": '<include file="{part}"><arg name="more" value="1"/></include>',
    "an argument less": '<include file="{part}"/>',
    "an argument without value": (
        '<include file="{part}"><arg name="required"/></include>'
    ),
    "an argument that is fixed": (
        '<include file="{part}"><arg name="required" value="1"/>'
        '<arg name="fixed" value="1"/></include>'
    ),
    "no remap": '<remap from="a"/>',
    "an old machine": '<machine name="m" address="a" ros-root="/opt"/>',
}


def test_what_roslaunch_refuses_is_an_error(packages: Path, tmp_path: Path) -> None:
    part = SOURCES / "quirks" / "launch" / "part.launch"
    files = [tmp_path / f"{number}.launch" for number in range(len(REFUSED))]
    for file, content in zip(files, REFUSED.values(), strict=True):
        file.write_text(f"<launch>{content.replace('{part}', str(part))}</launch>")
    answers = theirs([(str(file),) for file in files])
    for case, file, answer in zip(REFUSED, files, answers, strict=True):
        errors = [f for f in read(file).findings if f.severity == "error"]
        assert "refused" in answer, (case, answer)
        assert errors, (case, answer)
