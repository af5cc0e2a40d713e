"""The robot as files that a page can fetch: its URDF, and the meshes it names."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast, final

from tool0.description.catalogue import RobotDescription
from tool0.description.scene import SceneObject
from tool0.description.shapes import Geometry, Mesh
from tool0.description.xml_source import parse_text, to_text

if TYPE_CHECKING:
    from xml.dom.minidom import Document, Element

URDF_PATH = "/robot.urdf"


@final
class RobotFiles:
    """Only what model and scene name is here; a page's paths never reach a disk."""

    def __init__(self, description: RobotDescription) -> None:
        self._description = description
        geometries: list[Geometry] = []
        for link in description.model.links:
            geometries += [shape.geometry for shape in link.visuals]
            geometries += [shape.geometry for shape in link.collisions]
        meshes = [item for item in geometries if isinstance(item, Mesh)]
        self._numbers = itertools.count()
        self._url_of = self._urls(meshes, {})
        self._url_of_uri = {mesh.uri: self._url_of[mesh.path] for mesh in meshes}
        self._url_of_object: Mapping[Path, str] = {}

    def have(self, objects: Sequence[SceneObject]) -> None:
        """Have the meshes of these objects, and of those before no more.

        What comes again has another path then: the file may be another, too.
        """
        geometries = [item.geometry for item in objects]
        meshes = [item for item in geometries if isinstance(item, Mesh)]
        self._url_of_object = self._urls(meshes, self._url_of_object)

    @property
    def meshes(self) -> Mapping[str, Path]:
        """Path on the server → file."""
        both = (self._url_of, self._url_of_object)
        return {url: file for urls in both for file, url in urls.items()}

    def url(self, mesh: Mesh) -> str:
        """Return the path of an object's mesh on the server."""
        return self._url_of_object[mesh.path]

    def _urls(
        self, meshes: Sequence[Mesh], known: Mapping[Path, str]
    ) -> Mapping[Path, str]:
        return {
            file: known.get(file)
            or f"/meshes/{next(self._numbers)}{file.suffix.lower()}"
            for file in dict.fromkeys(mesh.path for mesh in meshes)
        }

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
