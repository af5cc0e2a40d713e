"""Images of a robot and its scene from MuJoCo's renderer, for every engine.

The renderer has a separate model with the visual meshes, and computes only kinematics.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, final

import mujoco
import numpy as np
from numpy.typing import NDArray

from tool0.description.camera import Camera
from tool0.description.look import LIT, Look
from tool0.description.model import Link, RobotModel, Visual
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Mesh, kind_of
from tool0.description.transform import Transform, from_arrays
from tool0.engines.mujoco.detail import Detail, add_coarse
from tool0.engines.mujoco.gl import make_context
from tool0.engines.mujoco.ground import add_ground, put_ground_below
from tool0.engines.mujoco.model import MESH_SUFFIXES, build_spec
from tool0.engines.mujoco.objects import (
    change_body,
    compile_with_scene,
    free_joint_name,
)

logger = logging.getLogger(__name__)

MAX_GEOMS = 10000
"""Largest number of shapes in an image; MuJoCo omits further shapes."""
SHADOW_DETAIL = 5
"""Ratio of the side of the shadow map to the longer side of the image."""
SHADOW_SIZES = (512, 2048)
"""Smallest and largest side of the shadow map [pixels]."""
SMALL, ROUND = 128, (20, 8)
"""Largest image side [pixels] for which cylinders and spheres are coarse, and their
numbers of slices and stacks.  In larger images, the numbers are MuJoCo's defaults, 28
and 16."""
HORIZON, ZENITH = np.array([237.0, 242.0, 247.0]), np.array([180.0, 203.0, 230.0])
"""Colors of the sky at the horizon and at the zenith (red, green, blue; 0 … 255)."""
HAZE = (3.0, 9.0)
"""Depth at which objects begin to fade into the sky, and depth beyond which only sky is
visible [m]."""
DIFFUSE, HEAD_DIFFUSE, HEAD_AMBIENT = 0.5, 0.32, 0.38
"""Intensities of the lamp, and of the diffuse and ambient light from the camera."""
ROBOT, GROUND, NOTHING = -1, -2, -3
"""Values of the pixels that show the robot, the ground or nothing."""
STAND_IN_RGBA = (0.6, 0.62, 0.65, 1.0)
"""Color of the collision shapes that replace a mesh."""

Picture = tuple[NDArray[np.uint8], NDArray[np.float32], Transform]


@final
class Renderer:
    """Renderer of one robot.

    The thread that creates the renderer must also use and close it.
    """

    def __init__(
        self, model: RobotModel, ground: float | None, width: int, height: int
    ) -> None:
        """Prepare OpenGL for images up to ``width`` and ``height`` [pixels].

        ``ground`` is the height of the ground in the robot's root [m]; None means no
        ground.

        Raises:
            RenderError: If OpenGL is not available.
        """
        self._robot = model = with_readable_visuals(model)
        self.size = width, height
        """Width and height of the largest image [pixels]."""
        self._robot_spec = build_spec(model, dt=0.001, visuals=True, ground=None)
        if ground is not None:
            add_ground(self._robot_spec, ground)
        add_coarse(self._robot_spec)
        _furnish(self._robot_spec, width, height)
        self._mesh_files: Mapping[str, bytes] = {}
        self._objects: tuple[SceneObject, ...] | None = None
        self._context = make_context(width, height)
        self._drawing: Any = None  # MuJoCo's MjrContext

    def holds(self, width: int, height: int) -> bool:
        """Return whether an image of this size [pixels] can be rendered."""
        return width <= self.size[0] and height <= self.size[1]

    def render(
        self,
        camera: Camera,
        position: Mapping[str, float],
        objects: tuple[SceneObject, ...],
        states: Sequence[ObjectState],
        look: Look = Look(),
    ) -> Picture:
        """Return colors, depth, and the camera's optical frame in the robot's root.

        ``CameraImage`` describes the colors and the depth.  ``position`` [rad | m]
        contains every movable joint.  ``states`` contains the states of ``objects`` in
        the same order.

        Raises:
            ModelError: If MuJoCo does not support an object.
        """
        self._prepare(position, objects, states)
        self._light(look)
        frame = self._frame(camera)
        self._aim(camera, frame)
        rgb, depth = self._draw(camera)
        _paint_sky(rgb, depth, camera, frame)
        return rgb, depth, frame

    def segment(
        self,
        camera: Camera,
        position: Mapping[str, float],
        objects: tuple[SceneObject, ...],
        states: Sequence[ObjectState],
    ) -> NDArray[np.int32]:
        """Return the item that each pixel shows, shape (height, width).

        The value of a pixel is ``ROBOT``, ``GROUND``, ``NOTHING``, or the number of an
        object, starting at 0.
        """
        self._prepare(position, objects, states)
        self._aim(camera, self._frame(camera))
        flags = self._visible.flags
        segments = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)
        for flag in segments:
            flags[flag.value] = 1
        viewport = mujoco.MjrRect(0, 0, camera.width, camera.height)
        rgb = np.empty((camera.height, camera.width, 3), np.uint8)
        mujoco.mjr_render(viewport, self._visible, self._drawing)
        mujoco.mjr_readPixels(rgb, None, viewport, self._drawing)
        for flag in segments:
            flags[flag.value] = 0
        number = rgb[::-1].astype(np.int32) @ np.array([1, 1 << 8, 1 << 16], np.int32)
        # The number 0 denotes the background, and k + 1 denotes the visible shape k.
        of_shape = [NOTHING, *(self._kind(g) for g in self._shapes())]
        return np.array(of_shape, np.int32)[np.minimum(number, len(of_shape) - 1)]

    def _shapes(self) -> list[Any]:
        """Return the visible shapes, indexed by their number in a segmented image."""
        shapes = self._visible.geoms[: self._visible.ngeom]
        found: dict[int, Any] = {shape.segid: shape for shape in shapes}
        return [found.get(number) for number in range(max(found, default=-1) + 1)]

    def _kind(self, shape: Any) -> int:
        """Return the value for pixels that show a visible shape."""
        if shape is None or shape.objtype != mujoco.mjtObj.mjOBJ_GEOM.value:
            return NOTHING
        body = int(self._model.geom_bodyid[shape.objid])
        if body in self._numbers:
            return self._numbers[body]
        return GROUND if body == 0 else ROBOT

    def close(self) -> None:
        """Free the OpenGL context."""
        self._context.make_current()
        self._free_drawing()
        self._context.free()

    def _prepare(
        self,
        position: Mapping[str, float],
        objects: tuple[SceneObject, ...],
        states: Sequence[ObjectState],
    ) -> None:
        """Set the objects, the joint positions and the states of the objects."""
        self._context.make_current()
        if objects is not self._objects:
            if self._objects is None or not _have_same_kinds(objects, self._objects):
                self._compile(objects)
            self._resize(objects)
            self._colour(objects)
        self._pose(position, states)

    def _resize(self, objects: tuple[SceneObject, ...]) -> None:
        """Update the sizes of objects; this is faster than a compilation."""
        for item, old in zip(objects, self._objects or (), strict=True):
            if item.geometry != old.geometry:
                change_body(self._model, item, Scene(objects), self._mesh_files)

    def _colour(self, objects: tuple[SceneObject, ...]) -> None:
        for item in objects:
            body = self._model.body(item.name)
            first = int(body.geomadr[0])
            self._model.geom_rgba[first : first + int(body.geomnum[0])] = item.rgba
        self._objects = objects

    def _light(self, look: Look) -> None:
        model, bright = self._model, look.brightness
        model.light_pos[0] = look.lamp
        model.light_dir[0] = np.subtract(LIT, look.lamp)
        model.light_dir[0] /= np.linalg.norm(model.light_dir[0])
        model.light_diffuse[0], model.light_specular[0] = bright * DIFFUSE, bright * 0.2
        model.vis.headlight.ambient = [bright * HEAD_AMBIENT] * 3
        model.vis.headlight.diffuse = [bright * HEAD_DIFFUSE] * 3
        mujoco.mj_camlight(model, self._data)

    def _compile(self, objects: tuple[SceneObject, ...]) -> None:
        """Compile and use a scene; nothing is changed if MuJoCo rejects the scene."""
        model, files = compile_with_scene(
            self._robot_spec.copy(), self._robot, Scene(objects), self._mesh_files
        )
        self._free_drawing()
        self._model, self._data = model, mujoco.MjData(model)
        self._mesh_files = files
        self._drawing = mujoco.MjrContext(
            model, mujoco.mjtFontScale.mjFONTSCALE_100.value
        )
        # The depth is 1 at the near plane and 0 at the far plane.  Since floats have
        # the highest resolution near 0, large depths are exact.
        self._drawing.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR.value
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._drawing)
        self._visible = mujoco.MjvScene(model, maxgeom=MAX_GEOMS)
        self._visible.flags[mujoco.mjtRndFlag.mjRND_SKYBOX.value] = 0
        self._options = mujoco.MjvOption()
        self._options.geomgroup[:] = [1, 1, 1, 0, 0, 0]  # collision shapes are hidden
        self._options.sitegroup[:] = 0
        self._detail = Detail(model)
        self._numbers = {
            int(model.body(item.name).id): k for k, item in enumerate(objects)
        }
        self._objects = objects

    def _free_drawing(self) -> None:
        if self._drawing is not None:
            self._drawing.free()
            self._drawing = self._objects = None

    def _pose(
        self, position: Mapping[str, float], states: Sequence[ObjectState]
    ) -> None:
        for name, value in position.items():
            self._data.joint(name).qpos[0] = value
        for item, state in zip(self._objects or (), states, strict=True):
            if item.mass is None:
                body = self._model.body(item.name)
                body.pos[:], body.quat[:] = state.position, state.quat_wxyz
            else:
                joint = self._data.joint(free_joint_name(item.name))
                joint.qpos[:] = (*state.position, *state.quat_wxyz)
        mujoco.mj_kinematics(self._model, self._data)

    def _frame(self, camera: Camera) -> Transform:
        """Return the optical frame in the robot's root."""
        if camera.link is None:
            return camera.T_link_camera
        site = self._data.site(camera.link)
        T_root_link = from_arrays(site.xpos, site.xmat.reshape(3, 3))
        return T_root_link @ camera.T_link_camera

    def _aim(self, camera: Camera, frame: Transform) -> None:
        """Set the view with a computed frustum; the model does not need cameras."""
        _, down, forward = zip(*frame.rotation, strict=True)
        half = camera.near * math.tan(camera.field_of_view / 2.0)
        # There are two cameras for stereo images; MuJoCo uses their mean.
        for eye in self._visible.camera:
            eye.pos, eye.forward = frame.position, forward
            eye.up = [-part for part in down]
            eye.frustum_center, eye.orthographic = 0.0, 0
            eye.frustum_bottom, eye.frustum_top = -half, half
            eye.frustum_width = half * camera.width / camera.height
            eye.frustum_near, eye.frustum_far = camera.near, camera.far
        put_ground_below(self._model, self._data, frame.position)
        self._detail.choose(self._data, camera, frame)
        view = mujoco.MjvCamera()
        view.type = mujoco.mjtCamera.mjCAMERA_USER.value  # MuJoCo keeps this view
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._options,
            None,
            view,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._visible,
        )

    def _draw(self, camera: Camera) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        viewport = mujoco.MjrRect(0, 0, camera.width, camera.height)
        rgb = np.empty((camera.height, camera.width, 3), np.uint8)
        depth = np.empty((camera.height, camera.width), np.float32)
        mujoco.mjr_render(viewport, self._visible, self._drawing)
        mujoco.mjr_readPixels(rgb, depth, viewport, self._drawing)
        near, far = camera.near, camera.far
        # The value is 1 at the near plane, 0 at the far plane, and linear in 1 / z
        # between the two planes.
        with np.errstate(divide="ignore"):
            z = near * far / (near + depth.astype(np.float64) * (far - near))
        z[depth <= 0.0] = np.inf  # REP-117: no surface within range.
        # OpenGL's rows start at the bottom.
        return rgb[::-1].copy(), z[::-1].astype(np.float32)


def _paint_sky(
    rgb: NDArray[np.uint8],
    depth: NDArray[np.float32],
    camera: Camera,
    T_root_camera: Transform,
) -> None:
    """Draw the sky, and blend distant objects with the color of the sky.

    MuJoCo's sky is not used, since it is a box at a finite distance that would be
    visible in the depth image.
    """
    rows, columns = np.nonzero(depth > HAZE[0])
    focal, (cx, cy) = camera.focal_length, camera.intrinsics[:2, 2]
    x, y = (columns - cx) / focal, (rows - cy) / focal
    # The upward direction in the camera's axes.
    right, down, forward = T_root_camera.rotation[2]
    height = (right * x + down * y + forward) / np.sqrt(x * x + y * y + 1.0)
    sky = HORIZON + (ZENITH - HORIZON) * np.maximum(height, 0.0)[:, np.newaxis]
    share = np.minimum((depth[rows, columns] - HAZE[0]) / (HAZE[1] - HAZE[0]), 1.0)
    share = share[:, np.newaxis]
    rgb[rows, columns] = share * sky + (1.0 - share) * rgb[rows, columns]


def _furnish(spec: Any, width: int, height: int) -> None:
    """Add lights, and set the sizes of images and of the shadow map."""
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.quality.shadowsize = shadow_size(width, height)
    if max(width, height) <= SMALL:
        spec.visual.quality.numslices, spec.visual.quality.numstacks = ROUND
    # With several samples per pixel, the depth would be that of an off-center sample,
    # with errors of millimeters on steep faces.  Rendering would also take twice as
    # long.
    spec.visual.quality.offsamples = 0
    # This fraction of the lamp's cone has a radius of 1.8 m on the ground.
    spec.visual.map.shadowscale = 0.3
    spec.visual.headlight.specular = [0.1, 0.1, 0.1]
    # The other properties of the lamp are set by ``Renderer._light``.
    spec.worldbody.add_light(cutoff=80.0, exponent=1.0)


def _have_same_kinds(
    some: tuple[SceneObject, ...], others: tuple[SceneObject, ...]
) -> bool:
    """Return whether two scenes differ at most in sizes and colors.

    Masses and friction coefficients are ignored, since they are not visible.  Poses are
    ignored, since they are part of the state.
    """
    return len(some) == len(others) and all(
        one.name == other.name
        and kind_of(one.geometry) == kind_of(other.geometry)
        and (one.mass is None) == (other.mass is None)
        for one, other in zip(some, others, strict=True)
    )


def shadow_size(width: int, height: int) -> int:
    """Return the side of the shadow map for an image of this size [pixels].

    Without a graphics card, rendering a large shadow map would take longer than
    rendering a small image.
    """
    wanted = int(SHADOW_DETAIL * max(width, height))
    return min(max(1 << (wanted - 1).bit_length(), SHADOW_SIZES[0]), SHADOW_SIZES[1])


def with_readable_visuals(model: RobotModel) -> RobotModel:
    """Return the robot with collision shapes in place of unreadable meshes.

    Unreadable meshes are visual meshes in a format that MuJoCo does not support.
    """
    unreadable = {
        visual.geometry.path.name
        for link in model.links
        for visual in link.visuals
        if isinstance(visual.geometry, Mesh) and not _is_readable(visual)
    }
    if not unreadable:
        return model
    logger.warning(
        "cameras show collision shapes instead of %s, which MuJoCo cannot read; "
        "convert them to STL or OBJ",
        ", ".join(sorted(unreadable)),
    )
    return replace(model, links=tuple(map(_with_readable_visuals, model.links)))


def _with_readable_visuals(link: Link) -> Link:
    kept = tuple(visual for visual in link.visuals if _is_readable(visual))
    if not kept and link.visuals:
        kept = tuple(
            Visual(geometry=item.geometry, origin=item.origin, rgba=STAND_IN_RGBA)
            for item in link.collisions
        )
    return replace(link, visuals=kept)


def _is_readable(visual: Visual) -> bool:
    shape = visual.geometry
    return not isinstance(shape, Mesh) or shape.path.suffix.lower() in MESH_SUFFIXES
