"""``tool0.Batch``: many copies of a robot and its scene, advanced together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from types import TracebackType
from typing import NoReturn, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tool0.batch.arguments import Arguments, Which
from tool0.batch.backend import CPU, DeviceArrays, checked_device, needs_cpu
from tool0.batch.commands import Commands
from tool0.batch.contacts import Bodies, Contacts, checked_bodies, contacts_of
from tool0.batch.force_torque import BatchForceTorque, BatchForceTorques
from tool0.batch.images import Images
from tool0.batch.initial_positions import initial_positions
from tool0.batch.kinematics import Kinematics
from tool0.batch.making import (
    checked_cameras,
    checked_count,
    checked_threads,
    core_scenes,
    make_backend,
    make_cores,
)
from tool0.batch.objects import Objects
from tool0.batch.saved import BatchState, checked_sources
from tool0.batch.state import State, frozen
from tool0.description.config import DescriptionConfig, File
from tool0.description.grasp_frames import pad_links
from tool0.description.loading import load_description
from tool0.description.look import LAMP
from tool0.description.model import ParallelGripper
from tool0.description.scene import Scene
from tool0.errors import ControlError
from tool0.kinematics.chain import Array
from tool0.protocol.sensors import CameraImage
from tool0.simulation.config import ControlConfig


@final
class Batch:
    """n copies of a robot and its scene, advanced together with MuJoCo.

    Each copy behaves, bit for bit, like a single ``bringup`` with ``realtime=False``
    that gets the same commands at the same ticks.  Every array has one row per copy,
    shape (n, …), and is in SI units.  An argument without the axis of the copies
    applies to all copies.  ``which`` selects copies by a mask of shape (n,) or by
    number (default: all copies); in arguments, the rows of other copies are ignored.
    Returned arrays are read-only and do not change as time advances.
    """

    def __init__(
        self,
        n: int,
        *,
        description: DescriptionConfig = DescriptionConfig(),
        control: ControlConfig = ControlConfig(),
        scene: Scene | File | Sequence[Scene] | None = None,
        dt: float = 0.001,
        threads: int | None = None,
        device: str = "cpu",
    ) -> None:
        """Make ``n`` copies, each at its initial pose.

        Args:
            n: Number of copies.
            description: The robot.
            control: The robot's controllers and initial pose.
            scene: The objects around the robot: one scene for all copies, or one per
                copy.  Scenes of copies may differ only in the mass, friction, pose and
                color of objects, and in the size of boxes, cylinders and spheres.
            dt: Length of a physics step [s].
            threads: Number of threads that step the copies (default: the number of
                processors, but at most ``n``).  The number of threads cannot be given
                for a GPU.
            device: Device that computes: "cpu", a GPU such as "cuda" or "cuda:1", or
                "warp:cpu".  A GPU computes in single precision.  "warp:cpu" runs the
                GPU's code slowly on the CPU.

        Raises:
            ConfigError: If ``n`` or ``threads`` is out of range, the scenes differ in
                other properties, or the device does not support an argument.
            EngineUnavailableError: If there is no such device, or MuJoCo Warp is not
                installed.
            Tool0Error: If an option or a file is wrong.
        """
        self._n = checked_count(n)
        self._device = checked_device(device, threads)
        self._threads = checked_threads(threads, self._n if device == CPU else 1)
        self._dt = dt
        robot = load_description(description)
        self._model = robot.model
        scenes = core_scenes(robot, scene, self._n, device)
        cameras = checked_cameras(self._model, scenes[0])
        self._cores = make_cores(robot, control, scenes, dt)
        self._copies = make_backend(
            self._cores, self._model, self._n, device=device, threads=self._threads
        )
        # On a GPU, one core represents all copies.
        cores = self._cores if device == CPU else self._cores * self._n
        self._state = State(self._copies, cores)
        self._alone, self._changing = self._state.alone, self._state.changing
        self._images = Images(
            self._model,
            cameras,
            self._cores[0].engine.world.ground,
            self._state.snapshot,
            n=self._n,
            threads=self._threads,
        )
        self._commands = Commands(self._model, self._copies, self._cores[0])
        self._kinematics = Kinematics(self._model, self._state)
        self._objects = Objects(self._copies, cores, self._state)
        self._sensors = BatchForceTorques(robot, self._cores, self._copies, self._state)

    # ---- properties -----------------------------------------------------------------

    @property
    def n(self) -> int:
        """Number of copies."""
        return self._n

    @property
    def threads(self) -> int:
        """Number of threads that step the copies."""
        return self._threads

    @property
    def device(self) -> str:
        """The device that computes: "cpu", a GPU, or "warp:cpu"."""
        return self._device

    @property
    def dt(self) -> float:
        """Length of a physics step [s]."""
        return self._dt

    @property
    def control_period(self) -> float:
        """Simulated time between two updates of the controllers (one tick) [s]."""
        return self._cores[0].control_period

    @property
    def joint_names(self) -> tuple[str, ...]:
        """All movable joints, in the order of the arrays of joint states."""
        return self._state.joint_names

    @property
    def arm_joints(self) -> tuple[str, ...]:
        """The joints that ``command`` and ``follow`` move by default.

        The default joints are the joints of all running trajectory controllers that do
        not drive a gripper.
        """
        return self._commands.arm_joints

    @property
    def object_names(self) -> tuple[str, ...]:
        """The objects of the scene, in the order of the returned poses."""
        return self._objects.names

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """The links of the robot, including links fixed to other links."""
        return tuple(self._model.link_by_name)

    def pad_names(self, gripper: str | None = None) -> tuple[str, str]:
        """Return the links of the two pads, in the order of ``pad_forces``.

        Raises:
            ControlError: If there is no such gripper, or it does not have two pads.
        """
        return pad_links(self._model, self._kinematics.gripper(gripper))

    @property
    def grippers(self) -> Mapping[str, ParallelGripper]:
        """The grippers by name."""
        return self._kinematics.grippers

    # ---- the state ------------------------------------------------------------------

    @property
    def time(self) -> Array:
        """Simulated time since the last reset of each copy [s], shape (n,)."""
        return self._state.time

    @property
    def position(self) -> Array:
        """Joint positions [rad | m], shape (n, n_joints)."""
        return self._state.joints()[0]

    @property
    def velocity(self) -> Array:
        """Joint velocities [rad/s | m/s], shape (n, n_joints)."""
        return self._state.joints()[1]

    @property
    def effort(self) -> Array:
        """Efforts that the drives applied in the last step [N·m | N], (n, n_joints)."""
        return self._state.joints()[2]

    @property
    def diverged(self) -> NDArray[np.bool_]:
        """Whether each copy has stopped because its physics failed, shape (n,)."""
        return self._state.diverged

    def tool_pose(self, robot: str | None = None) -> tuple[Array, Array]:
        """Return tool0's position [m] and quat_wxyz in the root frame.

        The position has the shape (n, 3), and the quaternion has the shape (n, 4).

        Args:
            robot: Name of the arm; may be omitted if there is only one arm.

        Raises:
            ControlError: If there is no such arm, or there are several arms and
                ``robot`` is None.
        """
        frames = self._kinematics.tool_pose(robot)
        return frozen(frames.position), frozen(frames.quat_wxyz)

    def tcp_pose(self, gripper: str | None = None) -> tuple[Array, Array]:
        """Return the TCP's position [m] and quat_wxyz in the root frame.

        The position has the shape (n, 3), and the quaternion has the shape (n, 4).

        The TCP is the point midway between the pads.  The y axis of the TCP frame
        points from one pad to the other, and the z axis points away from the gripper.
        The TCP frame is also the frame of ``Gripper.tcp``.

        Args:
            gripper: Name of the gripper; may be omitted if there is only one gripper.

        Raises:
            ControlError: If there is no such gripper, or there are several grippers and
                ``gripper`` is None.
        """
        frames = self._kinematics.tcp_pose(gripper)
        return frozen(frames.position), frozen(frames.quat_wxyz)

    def inverse_kinematics(
        self,
        position: ArrayLike,
        quat: ArrayLike,
        *,
        robot: str | None = None,
        which: Which | None = None,
    ) -> Array:
        """Return joint positions that place tool0 at poses in the root frame.

        Of the solutions within the joint limits, the method returns the solution that
        the arm reaches first, at full speed from its current positions.

        Args:
            position: Positions of tool0 [m], shape (n, 3).
            quat: Orientations of tool0 (w, x, y, z), shape (n, 4).
            robot: Name of the arm; may be omitted if there is only one arm.
            which: The copies.

        Returns:
            Joint positions [rad], shape (n, 6), from base to flange.  The rows of poses
            that are out of reach or singular, and of copies that are not in ``which``,
            are NaN.

        Raises:
            ControlError: If a shape or a value is wrong, or there is no such arm.
        """
        return frozen(self._kinematics.inverse(position, quat, robot, which))

    def opening(self, gripper: str | None = None) -> Array:
        """Return the distance between the pads, 0 if closed [m], shape (n,)."""
        return frozen(self._kinematics.opening(gripper))

    @property
    def object_position(self) -> Array:
        """Positions of the objects in the root frame [m], shape (n, n_objects, 3)."""
        return self._state.objects().position

    @property
    def object_quat(self) -> Array:
        """Orientations of the objects (w, x, y, z), shape (n, n_objects, 4)."""
        return self._state.objects().quat

    @property
    def object_linear(self) -> Array:
        """Linear velocities of the objects in root axes [m/s], (n, n_objects, 3)."""
        return self._state.objects().linear

    @property
    def object_angular(self) -> Array:
        """Angular velocities of the objects in root axes [rad/s], (n, n_objects, 3)."""
        return frozen(self._state.objects().angular)

    def pad_forces(self, gripper: str | None = None) -> Array:
        """Return the normal force on each pad in the last step [N], shape (n, 2).

        The force is the sum over all contacts of a pad with any body.

        Raises:
            ControlError: If there is no such gripper, or it does not have two pads.
        """
        pads = self.pad_names(gripper)
        with self._alone:
            return frozen(self._copies.pad_forces(pads))

    @property
    def device_arrays(self) -> DeviceArrays:
        """The state in the memory of the GPU, which is not copied to the host.

        Raises:
            ControlError: If the batch runs on the CPU.
        """
        with self._alone:
            return self._copies.arrays()

    def tool_wrench(self, robot: str | None = None) -> Array:
        """Return the force [N] and torque [N·m] of contacts on the tool, shape (n, 6).

        The wrench is given at the origin and in the axes of tool0.  The wrench is the
        sum over all contacts in the last step between links beyond tool0 and other
        bodies.  A held object is one of the other bodies, so its weight and contacts
        contribute to the wrench.  The weight and inertia of the gripper are not part of
        the wrench.

        Args:
            robot: Name of the arm; may be omitted if there is only one arm.

        Raises:
            ControlError: If there is no such arm, there are several arms and ``robot``
                is None, or the batch runs on a GPU.
        """
        flange = self._kinematics.flange(robot)
        links = frozenset(self._model.links_from(flange))
        with self._alone:
            return frozen(self._copies.wrenches(links, flange))

    def contacts(
        self,
        first: Bodies | None = None,
        second: Bodies | None = None,
        which: Which | None = None,
    ) -> Contacts:
        """Return the contacts in the last step, one row per pair of touching bodies.

        Contacts are computed on request and have the same fields as in
        ``Robot.contacts``.  Pairs of bodies without a normal force are left out.

        Args:
            first: Name of a link or an object, ``ground``, or a sequence of these
                names, which are ``first`` in the rows (default: any body).
            second: Name of the link or object that touches ``first``, or several names
                (default: any body).
            which: The copies.

        Raises:
            ControlError: If there is no such link or object, or the batch runs on a
                GPU.
        """
        bodies = self._bodies("contacts", first), self._bodies("contacts", second)
        rows = Arguments(self._n, "contacts").which(which)
        with self._alone:
            found = self._copies.contacts(*bodies)
        return contacts_of(found, rows)

    def in_contact(
        self, first: Bodies, second: Bodies | None = None
    ) -> NDArray[np.bool_]:
        """Return whether two bodies touched in the last step, shape (n,).

        This method is faster than ``contacts``.

        Args:
            first: Name of a link or an object, ``ground``, or a sequence of these
                names, any of which may touch ``second``.
            second: Name of the body that touches ``first``, or several names (default:
                any body).

        Raises:
            ControlError: If there is no such link or object.
        """
        bodies = self._bodies("in_contact", first), self._bodies("in_contact", second)
        assert bodies[0] is not None
        with self._alone:
            return frozen(self._copies.are_touching(bodies[0], bodies[1]))

    @property
    def force_torque(self) -> BatchForceTorque:
        """The force-torque sensor at the robot's only tool0 link, in each copy."""
        return self.force_torque_of(None)

    def force_torque_of(self, link: str | None) -> BatchForceTorque:
        """Return the force-torque sensor at a link, given the link's or sensor's name.

        Raises:
            ModelError: If there is neither a link nor a sensor of that name.
            ControlError: If ``link`` is None, and the robot has no tool0 link or
                several tool0 links.
        """
        return self._sensors.at(link)

    # ---- commands -------------------------------------------------------------------

    def command(
        self,
        positions: ArrayLike,
        *,
        velocities: ArrayLike | None = None,
        duration: float,
        joints: Sequence[str] | None = None,
        which: Which | None = None,
    ) -> None:
        """Move joints to ``positions`` within a duration.

        The motion corresponds to a message with one point on the ROS topic
        ``~/command``.

        The motion starts from the current setpoint and replaces the remaining part of
        the previous motion.

        Args:
            positions: Positions [rad | m], shape (n, k).  An array in the GPU's memory,
                such as a PyTorch tensor, is not copied to the host, and its values are
                not checked: values beyond a limit are clamped to the limit, and a copy
                with a non-finite value diverges.  An array in the GPU's memory must be
                float32 and must have the full shape.
            velocities: Velocities at the positions [rad/s | m/s], shape (n, k); without
                velocities, the setpoints move linearly and then stop, like in ROS.
            duration: Duration of the motion [s].
            joints: Names of the k joints (default: ``arm_joints``).
            which: The copies.

        Raises:
            ControlError: If a shape, a value or a joint is wrong, in which case no
                motion is started.
        """
        check = Arguments(self._n, "command")
        duration = check.duration(duration)
        names, parts = self._commands.parts(joints)
        rows = check.which(which)
        shape, axes = (len(names),), f" for joints {', '.join(names)}"
        if self._copies.holds(positions):
            for name, array in (("positions", positions), ("velocities", velocities)):
                if array is not None:
                    is_held = self._copies.holds(array)
                    check.on_device(name, array, shape, axes, is_held=is_held)
            with self._changing:
                self._commands.start_on_device(
                    rows, parts, positions, velocities, duration
                )
            return
        q = check.rows("positions", positions, shape, rows, axes)
        qd = None
        if velocities is not None:
            qd = check.rows("velocities", velocities, shape, rows, axes)
        self._commands.check_positions(names, q[:, None], rows)
        with self._changing:
            speeds = None if qd is None else qd[:, None]
            self._commands.start(rows, parts, q[:, None], speeds, [duration])

    def follow(
        self,
        positions: ArrayLike,
        times: ArrayLike,
        *,
        velocities: ArrayLike | None = None,
        joints: Sequence[str] | None = None,
        which: Which | None = None,
    ) -> None:
        """Move joints along trajectories.

        The motion corresponds to a message on the ROS topic ``~/command``.

        Args:
            positions: Positions of m points [rad | m], shape (n, m, k).
            times: Times of the points from now, in increasing order [s], shape (m,).
            velocities: Velocities at the points [rad/s | m/s], shape (n, m, k); without
                velocities, the setpoints move linearly between the points.
            joints: Names of the k joints (default: ``arm_joints``).
            which: The copies.

        Raises:
            ControlError: If a shape, a value or a joint is wrong, in which case no
                motion is started.
        """
        check = Arguments(self._n, "follow")
        names, parts = self._commands.parts(joints)
        rows = check.which(which)
        points = check.times(times)
        shape = (len(points), len(names))
        axes = f" for joints {', '.join(names)}"
        q = check.rows("positions", positions, shape, rows, axes)
        qd = None
        if velocities is not None:
            qd = check.rows("velocities", velocities, shape, rows, axes)
        self._commands.check_positions(names, q, rows)
        with self._changing:
            self._commands.start(rows, parts, q, qd, points)

    def move_gripper(
        self,
        opening: ArrayLike,
        *,
        speed: ArrayLike | None = None,
        force: ArrayLike | None = None,
        gripper: str | None = None,
        which: Which | None = None,
    ) -> None:
        """Move the pads to ``opening``.

        An object between the pads is gripped with ``force``.

        The driven joint moves along a single cubic that ends at rest
        (``motion.gripper.direct_path``); a GripperActionController uses a different
        motion.

        Args:
            opening: Distance between the pads [m], shape (n,).  See ``command`` for an
                array in the GPU's memory.
            speed: Speed of the pads relative to each other [m/s], shape (n,) (default:
                the gripper's maximum speed).
            force: Largest force at each pad [N], shape (n,) (default: the gripper's
                maximum force).
            gripper: Name of the gripper; may be omitted if there is only one gripper.
            which: The copies.

        Raises:
            ModelError: If an opening is outside the gripper's range.
            ControlError: If a shape, a speed or a force is wrong, or no running
                controller drives the gripper, in which case no motion is started.
        """
        check = Arguments(self._n, "move_gripper")
        geometry = self._kinematics.gripper(gripper)
        rows = check.which(which)
        grip = self._commands.checked_grip(
            geometry, rows, opening, speed=speed, force=force, check=check
        )
        with self._changing:
            self._commands.grip(geometry, rows, *grip, has_force=force is not None)

    # ---- time -----------------------------------------------------------------------

    def step(self, ticks: int = 1, which: Which | None = None) -> None:
        """Advance copies by ``ticks`` control periods.

        A copy that has diverged does not advance.

        Args:
            ticks: Number of ticks.
            which: The copies to advance (default: all copies).  Time does not advance
                in the other copies.

        Raises:
            ControlError: If ``ticks`` is negative or not a whole number, or if
                ``which`` leaves out copies on a GPU.
        """
        if not isinstance(ticks, int | np.integer) or ticks < 0:
            raise ControlError(
                f"Batch.step: 'ticks' must be a whole number, 0 or more, got {ticks!r}"
            )
        rows = Arguments(self._n, "step").which(which)
        if len(rows) < self._n and self._device != CPU:
            raise needs_cpu("Batch.step(which=…)", self._device)
        with self._changing:
            self._copies.step(int(ticks), rows)

    def run(self, duration: float) -> None:
        """Advance all copies by ``duration`` [s], rounded to whole control periods."""
        time = Arguments(self._n, "run").duration(duration)
        self.step(max(0, math.ceil(time / self.control_period - 0.5)))

    def reset(
        self, which: Which | None = None, position: ArrayLike | None = None
    ) -> None:
        """Reset the time, objects, controllers and pose of copies.

        Args:
            which: The copies.
            position: Positions of all joints [rad | m], shape (n, n_joints) (default:
                the initial pose).  Mimic joints follow the joints that they mimic, so
                the values of mimic joints are ignored.

        Raises:
            ControlError: If a shape or a number is wrong.
            LimitsError: If a position is outside a joint's limits, in which case the
                copies are unchanged.
        """
        check = Arguments(self._n, "reset")
        rows = check.which(which)
        starts: dict[str, Array] = {}
        if position is not None:
            starts = initial_positions(
                self._model, self.joint_names, position, rows, check
            )
        with self._changing:
            self._copies.reset(rows, starts)

    def save(self) -> BatchState:
        """Return an immutable state of all copies.

        The state contains all variables that affect how the copies continue: joints;
        objects with their sizes, masses and friction coefficients; warm start and
        contacts of the physics; motions; integrals of the controllers; grippers; and
        time.  The state also contains the appearance of the copies in images.

        Raises:
            ControlError: If a goal of a GripperActionController is active in a copy, or
                the batch runs on a GPU.
        """
        with self._changing:
            return BatchState(self._copies.save(), self._images.save(), self._dt)

    def restore(
        self,
        state: BatchState,
        which: Which | None = None,
        source: ArrayLike | None = None,
    ) -> None:
        """Restore saved states of copies, which then continue bit for bit from them.

        Args:
            state: State of this batch, or of a batch with the same robot, controllers
                and objects; the objects' sizes may differ.
            which: The copies.
            source: Number of the saved copy to restore in each copy, shape (n,)
                (default: the number of the copy).

        Raises:
            ControlError: If a number is not the number of a saved copy, the robot or
                the controllers differ, or the batch runs on a GPU.
            EngineError: If the objects differ.
        """
        if self._device != CPU:
            raise needs_cpu("Batch.restore", self._device)
        check = Arguments(self._n, "restore")
        rows = check.which(which)
        sources = checked_sources(state, source, rows, check, n=self._n, dt=self._dt)
        with self._changing:
            self._copies.restore(rows, [state.copies[k] for k in sources])
            self._images.restore(rows, [state.looks[k] for k in sources])
            self._objects.forget_sizes()

    # ---- the scene ------------------------------------------------------------------

    def place(
        self,
        name: str,
        position: ArrayLike,
        quat: ArrayLike | None = None,
        which: Which | None = None,
    ) -> None:
        """Place an object at rest; a reset returns the object to its initial pose.

        Args:
            name: The object.
            position: Position of the object's origin in the root frame [m], shape (n,
                3).
            quat: Orientation of the object in the root frame (w, x, y, z), shape (n, 4)
                (default: aligned with the root's axes).
            which: The copies.

        Raises:
            ControlError: If there is no such object, the object is fixed and the batch
                runs on a GPU, or a shape or a value is wrong, in which case the object
                is not moved.
        """
        self._objects.place(name, position, quat, which)

    def set_mass(self, name: str, mass: ArrayLike, which: Which | None = None) -> None:
        """Change the mass of a movable object without changing its shape.

        Args:
            name: The object.
            mass: Mass [kg], shape (n,).
            which: The copies.

        Raises:
            ControlError: If there is no such object, the object is fixed, or a mass is
                not positive, in which case no mass is changed.
        """
        self._objects.set_mass(name, mass, which)

    def set_friction(
        self, name: str, friction: ArrayLike, which: Which | None = None
    ) -> None:
        """Change the friction coefficient of an object.

        Args:
            name: The object.
            friction: Friction coefficient (see ``SceneObject.friction``), shape (n,).
            which: The copies.

        Raises:
            ControlError: If there is no such object, or a value is negative, in which
                case no coefficient is changed.
        """
        self._objects.set_friction(name, friction, which)

    def set_size(self, name: str, size: ArrayLike, which: Which | None = None) -> None:
        """Change the size of a box, a cylinder or a sphere without changing its mass.

        The object's origin, which is its center, does not move.  Place the object so
        that it does not overlap other bodies.  A reset does not change the size.

        Args:
            name: The object.
            size: Edges of a box along x, y, z [m], shape (n, 3); radius and length of a
                cylinder, (n, 2); radius of a sphere, (n,).
            which: The copies.

        Raises:
            ControlError: If there is no such object, the object has another shape, a
                value is not positive, or the batch runs on a GPU, in which case no size
                is changed.
        """
        self._objects.set_size(name, size, which)

    def object_size(self, name: str) -> Array:
        """Return the size of a box, cylinder or sphere [m] in the form of ``set_size``.

        Raises:
            ControlError: If there is no such object, or the object has another shape.
        """
        return self._objects.size(name)

    # ---- images and close -----------------------------------------------------------

    def render(self, i: int, camera: str) -> CameraImage:
        """Return an image of copy ``i``.

        Raises:
            ControlError: If there is no such copy.
            RenderError: If there is no such camera, or OpenGL is not available.
        """
        if not 0 <= i < self._n:
            raise ControlError(
                f"Batch.render: no copy {i}; there are 0 … {self._n - 1}"
            )
        return self.render_all(camera, i)[0]

    def render_all(
        self, camera: str, which: Which | None = None
    ) -> tuple[CameraImage, ...]:
        """Return an image of each copy, rendered by the threads that step the copies.

        Args:
            camera: A camera of the robot or of the scene.
            which: The copies (default: all copies).

        Raises:
            RenderError: If there is no such camera, or OpenGL is not available.
        """
        rows = Arguments(self._n, "render_all").which(which)
        with self._alone:
            return self._images.render(camera, rows)

    def segment_all(
        self, camera: str, which: Which | None = None
    ) -> tuple[NDArray[np.int32], ...]:
        """Return a segmentation image per copy, each of shape (height, width).

        Each pixel is the index of an object in ``object_names``, -1 for the robot, -2
        for the ground or -3 for the background.

        Args:
            camera: A camera of the robot or of the scene.
            which: The copies (default: all copies).

        Raises:
            RenderError: If there is no such camera, or OpenGL is not available.
        """
        rows = Arguments(self._n, "segment_all").which(which)
        with self._alone:
            return self._images.segment(camera, rows)

    def set_camera(
        self,
        name: str,
        position: ArrayLike,
        quat: ArrayLike,
        which: Which | None = None,
    ) -> None:
        """Move a camera of copies, relative to the link that carries the camera.

        Args:
            name: A camera of the robot or of the scene.
            position: Position of the optical frame [m], shape (n, 3).
            quat: Orientation of the optical frame (w, x, y, z), shape (n, 4).
            which: The copies.

        Raises:
            ControlError: If a shape or a number is wrong.
            RenderError: If there is no such camera.
        """
        with self._alone:
            self._images.set_camera(name, position, quat, which)

    def set_look(
        self,
        *,
        lamp: ArrayLike = LAMP,
        brightness: ArrayLike = 1.0,
        which: Which | None = None,
    ) -> None:
        """Change the light in the images of copies.

        Args:
            lamp: Position of the lamp in the root frame [m], shape (n, 3).
            brightness: Brightness of all light, relative to the default, shape (n,).
            which: The copies.

        Raises:
            ControlError: If a shape or a number is wrong.
            ConfigError: If a value is out of range.
        """
        with self._alone:
            self._images.set_look(lamp, brightness, which)

    def set_colour(
        self, name: str, rgba: ArrayLike, which: Which | None = None
    ) -> None:
        """Change the color of an object in the images of copies.

        Args:
            name: The object.
            rgba: Red, green, blue and alpha, each 0 … 1, shape (n, 4).
            which: The copies.

        Raises:
            ControlError: If a shape or a number is wrong, or there is no such object.
        """
        self._objects.check_name(name)
        with self._alone:
            self._images.set_colour(name, rgba, which)

    def close(self) -> None:
        """Close the batch; it may be closed more than once."""
        with self._alone:
            self._state.close()
            self._images.close()
            for core in self._cores:
                core.engine.close()

    def __enter__(self) -> Batch:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    # ---- details --------------------------------------------------------------------

    def __reduce__(self) -> NoReturn:
        """Raise an error, because a batch cannot be pickled or copied."""
        raise TypeError(
            "a Batch cannot be pickled or copied: it is memory of the physics and "
            "threads of this process; make one where it is needed, from the same "
            "arguments"
        )

    def _bodies(self, method: str, given: Bodies | None) -> frozenset[str] | None:
        names = self.object_names
        return checked_bodies(f"Batch.{method}", given, self._model, names)
