"""The control box, which all ports share: the arm, registers, messages and program.

The module may be used only in the event loop of the UR process.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Final, TypeVar, final

import numpy as np

from tool0.description.model import (
    FLANGE,
    GRIPPER_PROTOCOLS,
    ROBOTIQ,
    JointLimits,
)
from tool0.description.parts import find_grippers, gripper_of
from tool0.description.transform import Transform, Vector3
from tool0.description.transform_arrays import matrix_of
from tool0.errors import Tool0Error, UnreachableError
from tool0.kinematics.chain import ArmChain, Array, find_chains, fixed_transform
from tool0.kinematics.inverse import InverseKinematics
from tool0.kinematics.scalar_kinematics import ScalarChain, ScalarPosture
from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.request import Request
from tool0.protocol.socket_channel import SocketChannel
from tool0.protocol.state import (
    MAX_SNAPSHOT_RATE,
    ArmSample,
    ArmSetpoint,
    Six,
    Snapshot,
)
from tool0.protocol.state_message import StateField
from tool0.protocol.subscriptions import Subscribe
from tool0.ur.dynamics import BoxDynamics
from tool0.ur.messages import Messages
from tool0.ur.modbus.signals import Signals
from tool0.ur.pose import pose_of, transform_of
from tool0.ur.programs import LineInterpreter, ProgramSlot
from tool0.ur.registers import N_FLAGS, Registers
from tool0.ur.robotiq.gripper import RobotiqGripper
from tool0.ur.rtde_sensor import RtdeSensor
from tool0.ur.urscript_errors import URScriptError

logger = logging.getLogger(__name__)
R = TypeVar("R")

CB3_ARMS: Final = frozenset({"ur3", "ur5", "ur10"})
"""Arms with a CB3 control box. All other arms have an e-Series box."""
E_SERIES_VERSION: Final = (5, 25, 1)
"""Software version that an e-Series box reports: the first version in which
``direct_torque`` has friction scales. UR's driver uses torque control starting with the
same version."""
CB3_VERSION: Final = (3, 15, 8)
_FIELDS: Final[tuple[StateField, ...]] = (
    *("joint_names", "position", "velocity", "effort", "control_boxes", "arms"),
)


def box_states(arms: Collection[str]) -> Subscribe:
    """Return the request for the states that the arms' control boxes need."""
    return Subscribe(
        rate=MAX_SNAPSHOT_RATE, fields=_FIELDS, arms=tuple(arms), newest_only=True
    )


@final
class UrControlBox:
    """An arm and the state of its control box."""

    def __init__(
        self,
        channel: SocketChannel,
        arm: str,
        first: Snapshot,
        *,
        limits: Mapping[str, JointLimits] | None = None,
        allow_sockets: bool = False,
    ) -> None:
        """Represent the control box of one of the bring-up's arms.

        Args:
            channel: The connection to the bring-up.
            arm: Name of the arm in ``list_arms``.
            first: The first state of the subscription that ``box_states`` requests.
            limits: Limits of each driven joint; by default, the URDF's limits.
            allow_sockets: Whether programs may connect to other machines.
        """
        self.allow_sockets = allow_sockets
        self._channel = channel
        self._event_loop = asyncio.get_running_loop()
        model = channel.description.model
        self.arm = arm
        self.chain: ArmChain = find_chains(model, limits)[arm]
        self.kinematics = InverseKinematics(self.chain)
        prefix = self.chain.tip.removesuffix(FLANGE)
        base = f"{prefix}base"
        has_base = any(link.name == base for link in model.links)
        self.T_chain_base: Array = (
            fixed_transform(model, self.chain.base, base).matrix
            if has_base
            else np.eye(4)
        )
        """Pose of UR's base frame in the frame of the chain's base link, shape (4,
        4)."""
        self.model_name = next(
            (r.arm.name for r in channel.description.robots if r.prefix == prefix), ""
        )
        """Model of the arm in the catalog, such as ``ur5e``; empty if the robot is not
        from the catalog."""
        self.is_e_series = self.model_name not in CB3_ARMS
        self.version = E_SERIES_VERSION if self.is_e_series else CB3_VERSION
        """Software version that the box reports."""
        self.rate = 500.0 if self.is_e_series else 125.0
        """Rate of RTDE and the real-time interface [Hz]."""
        self.registers = Registers()
        self.flags = [False] * N_FLAGS
        """Flags of programs. A flag keeps its value when a program ends."""
        self.messages = Messages()
        self.programs = ProgramSlot(self)
        self.rtde_sensor = RtdeSensor()
        """Force sensor with readings that an RTDE client sends."""
        self.encoders: dict[int, tuple[range, float]] = {}
        """Range and tick count of each conveyor encoder that programs have set, by
        encoder number."""
        self.interpreter: LineInterpreter | None = None
        """Interpreter of the running program; None if the program has no
        interpreter."""
        self.modbus = Signals(lambda: self.programs.is_running)
        """Signals of Modbus units that programs read and write."""
        self.when_updated: set[Callable[[], None]] = set()
        """Callbacks for updates. If several updates are received together, the
        callbacks are called only for the newest update."""
        self.when_shown: set[Callable[[], None]] = set()
        """Callbacks that send data. The callbacks are called for every update, in
        order, even if several updates are received together."""
        index = {name: k for k, name in enumerate(first.joint_names)}
        self._indices = [index[name] for name in self.chain.joint_names]
        self._waiting: list[asyncio.Future[None]] = []
        self._postures_of = ScalarChain(
            self.chain, np.asarray(np.linalg.inv(self.T_chain_base))
        )
        self._postures: dict[bool, ScalarPosture] = {}
        """Postures at the current update: measured (False) and at the setpoint
        (True)."""
        self._T_tip_tcp: tuple[tuple[float, ...], Transform] = ((), Transform())
        """Pose of the TCP in the flange's frame, as UR's pose and as a transform."""
        self._known: dict[tuple[str, bool], Six] = {}
        """Quantities that have been computed for the current update."""
        self.snapshot = first
        """Newest state of the bring-up."""
        self._show(first)
        self.dynamics = BoxDynamics(self, model, first.joint_names)
        """Mass matrix, Jacobians and other dynamics, for programs."""
        self.gripper: RobotiqGripper | None = None
        """Gripper on the arm if the gripper uses Robotiq's protocol; otherwise,
        None."""
        self.has_foreign_gripper = False
        """Whether the arm carries a gripper that does not use Robotiq's protocol."""
        name = gripper_of(model, arm)
        if name is not None:
            geometry = find_grippers(model)[name]
            self.has_foreign_gripper = geometry.protocol != ROBOTIQ
            if not self.has_foreign_gripper:
                joint = index[geometry.joint]
                self.gripper = RobotiqGripper(self, name, geometry, joint)

    @property
    def bringup(self) -> str:
        """Name of the bring-up."""
        return self._channel.name

    # ---- updates --------------------------------------------------------------------

    def show(self, snapshot: Snapshot) -> None:
        """Apply an update that is immediately followed by another update.

        Data is sent for every update, but programs react only to the last one.
        """
        self._show(snapshot)
        _call(self.when_shown)

    def take(self, snapshot: Snapshot) -> None:
        """Apply the newest update and notify all tasks that wait for updates."""
        self._show(snapshot)
        _call(self.when_updated)
        _call(self.when_shown)
        waiting, self._waiting = self._waiting, []
        for future in waiting:
            if not future.done():
                future.set_result(None)

    def _show(self, snapshot: Snapshot) -> None:
        self._elapsed = snapshot.time - self.snapshot.time
        self._last_velocity = self.snapshot.velocity
        self.snapshot = snapshot
        self.arm_sample: ArmSample = snapshot.arms[self.arm]
        self.state: ControlBoxState = next(
            box for box in snapshot.control_boxes if box.arm == self.arm
        )
        self._postures.clear()
        self._known.clear()

    async def next_update(self) -> None:
        """Wait for the next update."""
        future: asyncio.Future[None] = self._event_loop.create_future()
        self._waiting.append(future)
        await future

    async def until(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition is true, which is checked now and at each update."""
        while not condition():
            await self.next_update()

    # ---- requests -------------------------------------------------------------------

    async def call(self, request: Request[R]) -> R:
        """Return the bring-up's response; raise its error if the request fails."""
        future: asyncio.Future[R] = self._event_loop.create_future()

        def finish(outcome: Callable[[], R]) -> None:
            if future.done():
                return  # cancelled
            try:
                future.set_result(outcome())
            except Exception as error:
                future.set_exception(error)

        def when_done(outcome: Callable[[], R]) -> None:
            self._event_loop.call_soon_threadsafe(finish, outcome)

        self._channel.submit(request, when_done)
        return await future

    def send(self, request: Request[Any]) -> None:
        """Send a request without waiting for the response; failures are reported."""
        try:
            self._channel.post(request)
        except Tool0Error as error:
            self.report(error)

    def report(self, error: Tool0Error) -> None:
        """Report an error to the clients and in the log."""
        logger.warning("%s: %s", self.arm, error)
        if isinstance(error, URScriptError):
            self.messages.exception(error)
        else:
            self.messages.error(str(error))

    # ---- the arm --------------------------------------------------------------------

    @property
    def why_no_gripper(self) -> str:
        """Reason why the arm has no ``gripper`` that programs and clients can use."""
        if not self.has_foreign_gripper:
            return "the arm carries no gripper"
        return (
            "the arm's gripper speaks no protocol that tool0 has (there is "
            f"{', '.join(GRIPPER_PROTOCOLS)}): no ports, no rq_ functions"
        )

    @property
    def stopped(self) -> str:
        """Reason why programs cannot move the arm; empty if the arm can move."""
        state = self.state
        if state.protective_stop:
            return f"protective stop: {state.protective_stop}"
        is_off = "" if state.may_move else "the arm was stopped or switched off"
        return state.motion_failure or is_off

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.snapshot.time

    @property
    def q(self) -> Six:
        """Measured joint positions, ordered from base to flange [rad]."""
        return self._of_joints(self.snapshot.position)

    @property
    def qd(self) -> Six:
        """Measured joint velocities, ordered from base to flange [rad/s]."""
        return self._of_joints(self.snapshot.velocity)

    @property
    def qdd(self) -> Six:
        """Joint accelerations between the last two measured velocities [rad/s²]."""
        if not self._elapsed > 0.0:
            return (0.0,) * 6
        pairs = zip(self.qd, self._of_joints(self._last_velocity), strict=True)
        return _six([(v - before) / self._elapsed for v, before in pairs])

    @property
    def effort(self) -> Six:
        """Torques of the joint drives [N·m]."""
        return self._of_joints(self.snapshot.effort)

    @property
    def target_q(self) -> Six:
        """Joint setpoint [rad]; if there is no motion, the measured positions."""
        return _six(self._setpoint.positions)

    @property
    def target_qd(self) -> Six:
        """Setpoint of the joint velocities [rad/s]."""
        return _six(self._setpoint.velocities)

    @property
    def target_qdd(self) -> Six:
        """Setpoint of the joint accelerations [rad/s²]."""
        return _six(self._setpoint.accelerations)

    @property
    def _setpoint(self) -> ArmSetpoint:
        setpoint = self.arm_sample.setpoint
        assert setpoint is not None  # sampled states contain a setpoint
        return setpoint

    @property
    def tcp(self) -> Six:
        """Pose of the tool center point (TCP) in the flange's frame."""
        return self.state.tcp

    def tcp_pose(self, *, target: bool = False) -> Six:
        """Return the pose of the TCP in the base frame, measured or at the setpoint."""
        return self._once("pose", target, self._compute_pose)

    def tcp_speed(self, *, target: bool = False) -> Six:
        """Return the velocity of the TCP in the base frame's axes [m/s, rad/s]."""
        return self._once("speed", target, self._compute_speed)

    def tcp_frame(self, *, target: bool = False) -> Transform:
        """Return the TCP's frame relative to the base frame."""
        if self.tcp != self._T_tip_tcp[0]:
            self._T_tip_tcp = self.tcp, transform_of(self.tcp)
        return self.posture(target=target).flange @ self._T_tip_tcp[1]

    def flange_wrench(self) -> tuple[Vector3, Vector3]:
        """Return the external force [N] and torque [N·m] at the flange in base axes."""
        flange, (fx, fy, fz, tx, ty, tz) = self.posture().flange, self.sensed_wrench
        return flange.rotate((fx, fy, fz)), flange.rotate((tx, ty, tz))

    @property
    def sensed_wrench(self) -> Six:
        """External wrench at the flange in flange axes, from the active sensor."""
        if self.rtde_sensor.is_used:
            return self.rtde_sensor.wrench
        return self.arm_sample.wrench

    def tcp_wrench(self) -> Six:
        """Return the external wrench at the TCP in the base frame's axes [N, N·m]."""
        return self._once("wrench", False, self._compute_wrench)

    def forward(self, q: Sequence[float], tcp: Sequence[float] | None = None) -> Six:
        """Return the TCP's pose in the base frame at joint positions ``q`` [rad]."""
        T_tip_tcp = transform_of(self.tcp if tcp is None else tcp)
        return pose_of(self._postures_of.forward(q).flange @ T_tip_tcp)

    def posture_at(self, q: Sequence[float]) -> ScalarPosture:
        """Return the arm's posture in the base frame at joint positions ``q`` [rad]."""
        return self._postures_of.forward(q)

    def velocity_at(self, q: Sequence[float], qd: Sequence[float]) -> Six:
        """Return the TCP's velocity in the base frame's axes [m/s, rad/s].

        Args:
            q: Joint positions [rad].
            qd: Joint velocities [rad/s].
        """
        posture = self._postures_of.forward(q)
        linear, angular = posture.velocity(posture.flange.apply(self.tcp[:3]), qd)
        return (*linear, *angular)

    def inverse(
        self,
        pose: Sequence[float],
        near: Sequence[float] | None = None,
        tcp: Sequence[float] | None = None,
    ) -> Six:
        """Return the inverse kinematics solution that is nearest to ``near`` [rad].

        Args:
            pose: Pose of the TCP in the base frame.
            near: Joint positions [rad]; by default, the setpoint's positions.
            tcp: Pose of the TCP in the flange's frame; by default, the box's TCP.

        Raises:
            UnreachableError: If there is no solution; the message contains the reason.
        """
        T_tip_tcp = matrix_of(self.tcp if tcp is None else tcp)
        T = self.T_chain_base @ matrix_of(pose) @ np.linalg.inv(T_tip_tcp)
        reference = self.target_q if near is None else near
        found = self.kinematics.solutions(T, np.asarray(reference, dtype=np.float64))
        return _six([found[0].positions[name] for name in self.chain.joint_names])

    def has_inverse(
        self,
        pose: Sequence[float],
        near: Sequence[float] | None = None,
        tcp: Sequence[float] | None = None,
    ) -> bool:
        """Return whether ``inverse`` finds a solution."""
        try:
            self.inverse(pose, near, tcp)
        except UnreachableError:
            return False
        return True

    def _of_joints(self, values: Sequence[float]) -> Six:
        return _six([values[k] for k in self._indices])

    def posture(self, *, target: bool = False) -> ScalarPosture:
        """Return the arm's posture in the base frame, measured or at the setpoint."""
        if target not in self._postures:
            q = self.target_q if target else self.q
            self._postures[target] = self._postures_of.forward(q)
        return self._postures[target]

    def _once(self, what: str, target: bool, compute: Callable[[bool], Six]) -> Six:
        """Return a quantity, which is computed only once per update."""
        key = (what, target)
        if key not in self._known:
            self._known[key] = compute(target)
        return self._known[key]

    def _compute_pose(self, target: bool) -> Six:
        return pose_of(self.tcp_frame(target=target))

    def _compute_speed(self, target: bool) -> Six:
        posture = self.posture(target=target)
        qd = self.target_qd if target else self.qd
        linear, angular = posture.velocity(posture.flange.apply(self.tcp[:3]), qd)
        return (*linear, *angular)

    def _compute_wrench(self, target: bool) -> Six:
        (fx, fy, fz), (tx, ty, tz) = self.flange_wrench()
        x, y, z = self.posture(target=target).flange.rotate(self.tcp[:3])
        torque = (tx - y * fz + z * fy, ty - z * fx + x * fz, tz - x * fy + y * fx)
        return (fx, fy, fz, *torque)


def _call(callbacks: Collection[Callable[[], None]]) -> None:
    for callback in tuple(callbacks):
        try:
            callback()
        except Exception:  # one callback must not stop the others
            logger.exception("an update could not be shown")


def _six(values: Sequence[float]) -> Six:
    a, b, c, d, e, f = values
    return (a, b, c, d, e, f)
