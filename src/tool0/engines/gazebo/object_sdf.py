"""The scene's objects in SDF: a model of one link each."""

from __future__ import annotations

from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.engines.gazebo.inertia import check_mesh, unit_inertia

STIFFNESS, DAMPING = 1e5, 10.0
"""Of contact [N/m, N·s/m], as of the pads: calm at rest, and no visible depth."""
MIN_DEPTH, MAX_VEL = 1e-5, 0.1
"""Overlap that is not corrected [m], and the highest speed of correction [m/s].

The direct solver ignores the second; bridge/leash.cc limits it instead.
"""


def object_sdf(item: SceneObject) -> str:
    """Return the object as an SDF document, at its model's origin.

    Raises:
        ModelError: If it is a mesh that cannot be read, or that has a mass but no
            volume.
    """
    if isinstance(item.geometry, Mesh):
        check_mesh(item.geometry.path)
    geometry = _geometry(item.geometry)
    color = " ".join(map(repr, item.rgba))
    # Neither an object's name nor a URI has a character that XML would need escaped.
    return f"""\
<sdf version="1.6">
  <model name="{item.name}">
    <static>{"false" if item.mass else "true"}</static>
    <link name="link">
      {_inertial(item)}
      <collision name="collision">
        {geometry}
        <surface>
          <friction><ode>
            <mu>{item.friction!r}</mu><mu2>{item.friction!r}</mu2>
          </ode></friction>
          <contact><ode>
            <kp>{STIFFNESS!r}</kp><kd>{DAMPING!r}</kd>
            <min_depth>{MIN_DEPTH!r}</min_depth><max_vel>{MAX_VEL!r}</max_vel>
          </ode></contact>
        </surface>
      </collision>
      <visual name="visual">
        {geometry}
        <material><ambient>{color}</ambient><diffuse>{color}</diffuse></material>
        <transparency>{1.0 - item.rgba[3]!r}</transparency>
      </visual>
    </link>
  </model>
</sdf>
"""


def _geometry(geometry: Geometry) -> str:
    match geometry:
        case Box(size=(x, y, z)):
            shape = f"<box><size>{x!r} {y!r} {z!r}</size></box>"
        case Cylinder(radius=r, length=length):
            size = f"<radius>{r!r}</radius><length>{length!r}</length>"
            shape = f"<cylinder>{size}</cylinder>"
        case Sphere(radius=r):
            shape = f"<sphere><radius>{r!r}</radius></sphere>"
        case Mesh(path=path, scale=(x, y, z)):
            scale = f"<scale>{x!r} {y!r} {z!r}</scale>"
            shape = f"<mesh><uri>{path.as_uri()}</uri>{scale}</mesh>"
    return f"<geometry>{shape}</geometry>"


def _inertial(item: SceneObject) -> str:
    if item.mass is None:
        return ""
    unit = unit_inertia(item.geometry)
    x, y, z = unit.center.tolist()
    moments = "".join(
        f"<i{row}{column}>{float(item.mass * unit.tensor[i, j])!r}</i{row}{column}>"
        for i, row in enumerate("xyz")
        for j, column in enumerate("xyz")
        if i <= j
    )
    return (
        f"<inertial><pose>{x!r} {y!r} {z!r} 0 0 0</pose><mass>{item.mass!r}</mass>"
        f"<inertia>{moments}</inertia></inertial>"
    )
