"""Objects that come and go while pages are open."""

import base64
import re
import struct
from pathlib import Path

import pytest
from browser import Tab, eventually
from playwright.sync_api import ViewportSize

import tool0
from conftest import OpenTab
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Compound, Cylinder, Mesh, Solid
from tool0.description.transform import Pose
from tool0.panel.server import Panel

READY = "[data-testid=scene][data-ready=true]"
MAGENTA, GREEN = (1.0, 0.0, 1.0, 1.0), (0.0, 1.0, 0.0, 1.0)
MANY = 500
"""Pixels; these objects cover thousands, their shadows and edges few."""
SMALL: ViewportSize = {"width": 760, "height": 600}
"""[px]; software GL draws each of them."""
COUNT = """async (encoded) => {
    const bytes = Uint8Array.from(atob(encoded), (char) => char.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let [magenta, green] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
        const [r, g, b] = data.subarray(i, i + 3);
        if (r > 80 && b > 80 && g < 30) magenta += 1;
        if (g > 80 && r < 30 && b < 30) green += 1;
    }
    return [magenta, green];
}"""
CORNERS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def pixels(tab: Tab) -> tuple[int, int]:
    """Return how many pixels of the picture are magenta, and how many green."""
    picture = base64.b64encode(tab.get("scene").screenshot()).decode()
    magenta, green = tab.page.evaluate(COUNT, picture)
    return magenta, green


def shows(tab: Tab, magenta: bool, green: bool) -> None:
    eventually(
        lambda: tuple(count > MANY for count in pixels(tab)) == (magenta, green),
        f"magenta {magenta}, green {green}",
    )


def thing(
    name: str, geometry: Solid, y: float, rgba: tuple[float, float, float, float]
) -> SceneObject:
    pose = Pose(xyz=(0.5, y, 0.1))
    return SceneObject(name=name, geometry=geometry, pose=pose, rgba=rgba)


@pytest.fixture
def mesh(tmp_path: Path) -> Mesh:
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(c for i in face for c in CORNERS[i]), 0)
        for face in FACES
    )
    path = tmp_path / "part.stl"
    path.write_bytes(bytes(80) + struct.pack("<I", len(FACES)) + facets)
    return Mesh(uri="part.stl", path=path, scale=(0.3, 0.3, 0.3))


def test_every_page_shows_what_is_there_now(
    panel: Panel, robot: tool0.Robot, open_tab: OpenTab, mesh: Mesh
) -> None:
    old = open_tab(panel.url)
    old.see(READY)
    old.page.set_viewport_size(SMALL)
    shows(old, magenta=False, green=False)
    robot.scene.add(thing("box", Box(size=(0.2, 0.2, 0.2)), 0.5, MAGENTA))
    shows(old, magenta=True, green=False)
    robot.scene.add(thing("part", mesh, -0.6, GREEN))
    new = open_tab(panel.url)
    new.see(READY)
    new.page.set_viewport_size(SMALL)
    for tab in (old, new):
        shows(tab, magenta=True, green=True)
    robot.scene.remove("box")
    for tab in (old, new):
        shows(tab, magenta=False, green=True)
    robot.pause()  # what comes then is seen, too
    half = Box(size=(0.1, 0.1, 0.2))
    ends = (Pose(xyz=(0.0, 0.0, -0.1)), Pose(xyz=(0.0, 0.0, 0.1)))
    post = Compound(parts=tuple((half, end) for end in ends))
    robot.scene.add(thing("post", post, 0.5, MAGENTA))
    robot.scene.remove("part")
    for tab in (old, new):
        shows(tab, magenta=True, green=False)


def fill(tab: Tab, test_id: str, text: str) -> None:
    field = tab.get(test_id)
    field.fill(text)
    field.press("Enter")


def shown_position(tab: Tab, name: str) -> list[float]:
    """Return where the page says an object is [mm]."""
    text = tab.get(f"object-pose-{name}").text_content() or ""
    return [float(part) for part in re.findall(r"-?\d+\.\d", text)[:3]]


def test_a_person_adds_moves_and_removes_objects(tab: Tab, robot: tool0.Robot) -> None:
    tab.page.set_viewport_size(SMALL)
    tab.get("tab-objects").click()
    tab.get("object-name").fill("post")
    tab.get("object-kind-cylinder").click()
    fill(tab, "object-radius", "50")
    fill(tab, "object-length", "200")
    tab.get("object-movable").click()  # it stands still then
    fill(tab, "object-position-0", "1200")
    tab.get("object-add").click()
    tab.get("object-row-post").wait_for()
    item = robot.scene["post"]
    assert tab.get("grasp-assist").count() == 0
    assert item.geometry == Cylinder(radius=0.05, length=0.2)
    assert (item.mass, item.pose.xyz) == (None, (1.2, 0.0, 0.1))
    eventually(lambda: shown_position(tab, "post") == [1200, 0, 100], "it is there")

    tab.get("object-move-post").click()
    fill(tab, "object-target-position-1", "-300")
    tab.get("object-put-post").click()
    eventually(lambda: shown_position(tab, "post") == [1200, -300, 100], "it moved")
    assert robot.scene.pose("post").position == pytest.approx((1.2, -0.3, 0.1))

    tab.get("object-name").fill("post")
    tab.get("object-add").click()
    tab.text("object-add-refusal", "post")
    tab.get("object-remove-post").click()
    tab.get("object-row-post").wait_for(state="detached")
    assert "post" not in robot.scene
