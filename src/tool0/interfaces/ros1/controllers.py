"""The topics, actions and services of the controllers that are loaded."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import final

from tool0.api.robot import Robot
from tool0.control.forward_command import ForwardCommandSpec
from tool0.control.gripper_action import GripperActionSpec
from tool0.control.joint_state import JointStateSpec
from tool0.control.joint_trajectory import JointTrajectorySpec
from tool0.errors import ControlError
from tool0.interfaces.ros1.forward_edge import ForwardEdge
from tool0.interfaces.ros1.gripper_edge import GripperEdge
from tool0.interfaces.ros1.joint_state_edge import JointStateEdge
from tool0.interfaces.ros1.node import Part, RosNode, Worker
from tool0.interfaces.ros1.trajectory_edge import TrajectoryEdge
from tool0.sensing.snapshot import Snapshot

_PATIENCE = 10.0
"""For one controller's names at a busy master [wall s]; one that is gone refuses at
once."""
_EDGES: dict[type, Callable[..., Part]] = {
    JointStateSpec: JointStateEdge,
    JointTrajectorySpec: TrajectoryEdge,
    GripperActionSpec: GripperEdge,
    ForwardCommandSpec: ForwardEdge,
}
"""What presents a controller, by the class of its parameters."""


@final
class ControllerEdges:
    """Follows what is loaded, whoever loads it: ROS, the panel, the command line.

    As in ROS, a controller's names are there from its loading to its unloading.
    """

    def __init__(self, node: RosNode, robot: Robot) -> None:
        self._node = node
        self._robot = robot
        self._edges: dict[str, tuple[object, Part]] = {}  # by name, with the spec
        self._seen: tuple[str, ...] = ()
        self._changing = threading.Lock()
        self._is_closing = False
        # Who registers waits for the master, which those who publish must not.
        self._registrar = Worker("tool0 ros1 registrar")
        self.follow()

    def publish(self, snapshot: Snapshot) -> None:
        """Publish what running controllers tell; see whether others are loaded."""
        loaded = tuple(status.name for status in snapshot.controllers)
        if loaded != self._seen:
            self._seen = loaded
            self._registrar.defer(self.follow)
        edges = self._edges  # as they are now: they may be replaced meanwhile
        for status in snapshot.controllers:
            if status.state == "running" and status.name in edges:
                edges[status.name][1].publish(snapshot)

    def follow(self) -> None:
        """Present the controllers that are loaded now, and no others."""
        with self._changing:
            specs = {}
            for status in self._robot.controllers():
                try:
                    specs[status.name] = self._robot.controller(status.name).spec
                except ControlError:
                    continue  # it has just been unloaded
            before = self._edges
            edges = {n: e for n, e in before.items() if specs.get(n) is e[0]}
            self._edges = dict(edges)  # published no longer; then it may close
            for name, (_, edge) in before.items():
                if name not in edges:
                    edge.close()
            for name, spec in specs.items():
                if name not in edges and not self._is_closing:
                    make = _EDGES[type(spec)]
                    controller = self._robot.controller(name)
                    edges[name] = spec, make(self._node, spec, controller)
            self._edges = edges

    def restart(self) -> None:
        """Forget times: simulated time has gone back to zero."""
        for _, edge in self._edges.values():
            edge.restart()

    def close(self) -> None:
        """Stop following; the node unregisters everything by itself.

        What is being registered is waited for: after the node it would stay behind.
        """
        self._is_closing = True
        self._registrar.close(_PATIENCE)
