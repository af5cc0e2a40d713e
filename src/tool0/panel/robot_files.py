"""The robot as files that a page can fetch: its URDF, and the meshes it names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast, final

from tool0.description.catalogue import RobotDescription
from tool0.description.model import Mesh
from tool0.description.scene import SceneObject
from tool0.description.xml_source import parse_text, to_text

if TYPE_CHECKING:
    from xml.dom.minidom import Document, Element

URDF_PATH = "/robot.urdf"


@final
class RobotFiles:
    """Only what model and scene name is here; a page's paths never reach a disk."""

    def __init__(
        self, description: RobotDescription, objects: Sequence[SceneObject] = ()
    ) -> None:
        self._description = description
        geometries = [item.geometry for item in objects]
        for link in description.model.links:
            geometries += [shape.geometry for shape in link.visuals]
            geometries += [shape.geometry for shape in link.collisions]
        meshes = [item for item in geometries if isinstance(item, Mesh)]
        files = dict.fromkeys(mesh.path for mesh in meshes)
        self._url_of = {
            file: f"/meshes/{number}{file.suffix.lower()}"
            for number, file in enumerate(files)
        }
        self._url_of_uri = {mesh.uri: self._url_of[mesh.path] for mesh in meshes}

    @property
    def meshes(self) -> Mapping[str, Path]:
        """Path on the server → file."""
        return {url: file for file, url in self._url_of.items()}

    def url(self, mesh: Mesh) -> str:
        """Return the path of a mesh on the server."""
        return self._url_of[mesh.path]

    @cached_property
    def urdf(self) -> bytes:
        """The URDF with the paths of the server in the place of files."""
        document: Document = parse_text(self._description.urdf)
        for element in document.getElementsByTagName("mesh"):
            uri = element.getAttribute("filename")
            element.setAttribute("filename", self._url_of_uri.get(uri, ""))
        for element in list(document.getElementsByTagName("texture")):
            # It is not served, and a page would miss it.
            cast("Element", element.parentNode).removeChild(element)
        return to_text(document).encode()
