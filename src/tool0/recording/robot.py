"""The description of the robot in a recording, with the attached meshes."""

from __future__ import annotations

import tempfile
import weakref
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import final

import msgspec

from tool0.description.model import ParallelGripper
from tool0.description.parts import find_arms, find_grippers, flange_names
from tool0.description.robot import RobotDescription
from tool0.description.scene import SceneObject
from tool0.description.xml_source import parse_text
from tool0.protocol.objects import ObjectInfo, object_of, with_meshes
from tool0.protocol.received_description import described_by
from tool0.protocol.robot import DescriptionInfo
from tool0.recording.damage import damage
from tool0.recording.frames import wrench_topics


@final
class RecordedRobot:
    """Description, meshes and objects of a recorded robot.

    Meshes are unpacked into a temporary folder, because the original files may have
    changed.  The folder exists as long as this object.
    """

    def __init__(
        self,
        source: Path,
        meshes: Mapping[str, str],
        info: DescriptionInfo,
        attachments: Mapping[str, bytes],
    ) -> None:
        """Prepare the description.

        ``meshes`` maps mesh URIs to names of attachments.
        """
        self._source = source
        self._info = info
        self._meshes, self._attachments = dict(meshes), attachments

    @cached_property
    def folder(self) -> Path:
        """Temporary folder with the unpacked meshes."""
        folder = tempfile.TemporaryDirectory(prefix="tool0-recording-")
        weakref.finalize(self, folder.cleanup)
        return Path(folder.name)

    @cached_property
    def description(self) -> RobotDescription:
        """The robot with the recorded meshes.

        Raises:
            RecordingError: If the robot cannot be read.
        """
        with damage(self._source, "the robot"):
            document = parse_text(self._info.urdf)
            for mesh in document.getElementsByTagName("mesh"):
                file = self._file(mesh.getAttribute("filename"))
                mesh.setAttribute("filename", file)
            return described_by(self._info, document)

    @cached_property
    def wrench_topics(self) -> Mapping[str, tuple[str, str]]:
        """Topic of the wrench, and link in whose axes it is given, by arm."""
        model = self.description.model
        topics, flanges = wrench_topics(model), flange_names(model)
        return {arm: (topics[arm], flanges[arm]) for arm in flanges}

    @cached_property
    def arms(self) -> Mapping[str, tuple[str, ...]]:
        """Joints of each arm from the base to the flange, by arm."""
        arms = find_arms(self.description.model)
        return {
            name: tuple(joint.name for joint in arm.joints)
            for name, arm in arms.items()
        }

    @cached_property
    def grippers(self) -> Mapping[str, ParallelGripper]:
        """The grippers by name."""
        return find_grippers(self.description.model)

    def scene(self, infos: Sequence[ObjectInfo]) -> Iterator[SceneObject]:
        """Yield the objects of a scene, with the recorded meshes."""
        for info in infos:
            shape = with_meshes(info.shape, self.mesh_files)
            yield object_of(msgspec.structs.replace(info, shape=shape))

    @cached_property
    def mesh_files(self) -> Mapping[str, Path]:
        """Current paths of the meshes by URI."""
        return {uri: Path(self._file(uri)) for uri in self._meshes}

    def _file(self, uri: str) -> str:
        """Return the current path of a mesh, or its URI if it is not in the file."""
        name = self._meshes.get(uri)
        data = None if name is None else self._attachments.get(name)
        if name is None or data is None:
            return uri
        file = self.folder / Path(name).name
        if not file.exists():
            file.write_bytes(data)
        return str(file)
