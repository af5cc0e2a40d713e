"""The world around the robot: ours, or a person's own file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from tool0.errors import DescriptionError, SourceLocation

EMPTY_WORLD = """\
<?xml version="1.0"?>
<sdf version="1.6">
  <world name="tool0">
    <physics name="ode" type="ode">
      <real_time_update_rate>0</real_time_update_rate>
      <ode>
        <solver><type>world</type></solver>
        <constraints>
          <cfm>0.0</cfm>
          <erp>0.2</erp>
          <contact_max_correcting_vel>100.0</contact_max_correcting_vel>
          <contact_surface_layer>0.001</contact_surface_layer>
        </constraints>
      </ode>
    </physics>
    <scene>
      <ambient>0.4 0.4 0.4 1</ambient>
      <background>0.7 0.7 0.7 1</background>
      <shadows>true</shadows>
    </scene>
    <gui>
      <camera name="user_camera"><pose>1.5 -1.3 1.0 0 0.36 2.34</pose></camera>
    </gui>
    <light name="sun" type="directional">
      <cast_shadows>true</cast_shadows>
      <pose>0 0 10 0 0 0</pose>
      <diffuse>0.8 0.8 0.8 1</diffuse>
      <specular>0.2 0.2 0.2 1</specular>
      <direction>-0.5 0.1 -0.9</direction>
    </light>
    <model name="ground_plane">
      <static>true</static>
      <link name="link">
        <collision name="collision">
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
          <surface><friction><ode><mu>100</mu><mu2>50</mu2></ode></friction></surface>
        </collision>
        <visual name="visual">
          <cast_shadows>false</cast_shadows>
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
          <material>
            <ambient>0.8 0.8 0.8 1</ambient>
            <diffuse>0.8 0.8 0.8 1</diffuse>
          </material>
        </visual>
      </link>
    </model>
  </world>
</sdf>
"""
"""A world with a sun, and the ground at z = 0.

The figures of the solver are Gazebo's own defaults; its type is not: see ADR 6.
"""


def check_world(file: Path) -> None:
    """Raise DescriptionError unless ``file`` is an SDF with a world in it."""
    root = _root(file, "world")
    if root.tag != "sdf" or root.find("world") is None:
        raise DescriptionError(
            f"<{root.tag}> is no world; a world is <sdf><world>…</world></sdf>",
            SourceLocation(file, 1),
        )


def check_model(file: Path) -> None:
    """Raise DescriptionError unless ``file`` is a URDF or an SDF with a model."""
    root = _root(file, "model")
    if root.tag != "robot" and (root.tag != "sdf" or root.find("model") is None):
        raise DescriptionError(
            f"<{root.tag}> is no model; a model is <sdf><model>…</model></sdf>, "
            "or a URDF's <robot>",
            SourceLocation(file, 1),
        )


def _root(file: Path, what: str) -> ET.Element:
    try:
        return ET.parse(file).getroot()
    except OSError as error:
        raise DescriptionError(
            f"cannot read the {what} {file}: {error.strerror}"
        ) from None
    except ET.ParseError as error:
        line = error.position[0]
        raise DescriptionError(f"no XML: {error}", SourceLocation(file, line)) from None
