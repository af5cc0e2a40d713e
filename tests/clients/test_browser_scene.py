"""What is selected, changed and shown in the 3D view."""

import base64
import re

import pytest
from browser import Tab, eventually
from playwright.sync_api import TimeoutError as TooLate
from playwright.sync_api import ViewportSize

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Solid, Sphere
from tool0.description.transform import Pose

READY = "[data-testid=scene][data-ready=true]"
MAGENTA = (1.0, 0.0, 1.0, 1.0)
SMALL: ViewportSize = {"width": 900, "height": 600}
"""[px]; software GL draws each of them."""
CENTRE = """async (encoded) => {
    const bytes = Uint8Array.from(atob(encoded), (char) => char.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let [count, across, down] = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4) {
        const [r, g, b] = data.subarray(i, i + 3);
        if (!(r > 80 && b > 80 && g < 60)) continue;
        count += 1;
        across += (i / 4) % image.width;
        down += Math.floor(i / 4 / image.width);
    }
    return count < 200 ? null : [across / count, down / count];
}"""


def magenta(tab: Tab) -> tuple[float, float] | None:
    """Return the middle of what is magenta in the picture [px], if there is enough."""
    picture = base64.b64encode(tab.get("scene").screenshot()).decode()
    middle = tab.page.evaluate(CENTRE, picture)
    return None if middle is None else (middle[0], middle[1])


def click_magenta(tab: Tab) -> None:
    eventually(lambda: magenta(tab) is not None, "a magenta object is seen")
    middle = magenta(tab)
    assert middle is not None
    x, y = middle
    tab.get("scene").click(position={"x": x, "y": y})


def thing(
    name: str, geometry: Solid, xyz: tuple[float, float, float], mass: float | None
) -> SceneObject:
    pose = Pose(xyz=xyz)
    return SceneObject(name=name, geometry=geometry, pose=pose, mass=mass, rgba=MAGENTA)


def show(tab: Tab, *overlays: str) -> None:
    tab.get("scene-options").click()
    for name in overlays:
        tab.get(f"scene-show-{name}").click()
    tab.get("scene-options").click()


def written(tab: Tab) -> list[float]:
    """Return the forces that are written in the scene [N], the largest first."""
    texts = tab.page.locator(".scene-labels span").all_text_contents()
    found = (re.fullmatch(r"(\d+\.\d) N", text) for text in texts)
    return sorted((float(match[1]) for match in found if match), reverse=True)


def test_what_is_clicked_is_selected_and_changed_by_keys_and_changed_back(
    tab: Tab, robot: tool0.Robot
) -> None:
    tab.page.set_viewport_size(SMALL)
    robot.scene.add(thing("cube", Box(size=(0.3, 0.3, 0.3)), (0.7, 0.3, 0.05), 2.0))
    tab.see(READY)
    click_magenta(tab)
    tab.see("[data-testid=selection][data-name=cube]")
    tab.text("selection", "300 mm, 2 kg")
    tab.text("selection-contact-ground", "19.6 N")
    before = robot.scene.pose("cube").position

    tab.page.keyboard.press("Control+d")
    tab.see("[data-testid=selection][data-name='cube 2']")
    copy = robot.scene["cube 2"]
    assert (copy.geometry, copy.mass) == (robot.scene["cube"].geometry, 2.0)
    tab.page.keyboard.press("Control+z")
    eventually(lambda: "cube 2" not in robot.scene, "the copy is gone")

    click_magenta(tab)
    tab.see("[data-testid=selection][data-name=cube]")
    tab.page.keyboard.press("Delete")
    eventually(lambda: "cube" not in robot.scene, "the cube is gone")
    tab.get("selection").wait_for(state="detached")
    tab.page.keyboard.press("Control+z")
    eventually(lambda: "cube" in robot.scene, "the cube is back")
    assert robot.scene.pose("cube").position == pytest.approx(before, abs=1e-3)
    assert robot.scene["cube"].rgba == MAGENTA

    tab.get("tab-objects").click()
    tab.get("object-move-cube").click()
    field = tab.get("object-target-position-0")
    field.fill("1200")
    field.press("Enter")
    tab.get("object-put-cube").click()
    eventually(lambda: robot.scene.pose("cube").position[0] > 1.1, "the cube moved")
    tab.get("objects-undo").click()
    eventually(
        lambda: robot.scene.pose("cube").position == pytest.approx(before, abs=1e-3),
        "the cube is where it was",
    )


def test_an_object_is_added_where_the_pointer_is(tab: Tab, robot: tool0.Robot) -> None:
    tab.page.set_viewport_size(SMALL)
    table = thing("table", Box(size=(0.6, 0.6, 0.3)), (0.8, 0.0, 0.0), None)
    robot.scene.add(table)
    tab.see(READY)
    tab.get("scene-view-top").click()
    eventually(lambda: magenta(tab) is not None, "the table is seen")
    tab.get("scene").locator("canvas").focus()
    tab.page.keyboard.press("a")
    tab.get("placing").wait_for()
    click_magenta(tab)
    tab.see("[data-testid=selection][data-name=box]")
    x, y, z = robot.scene["box"].pose.xyz
    assert (x, y) == pytest.approx((0.8, 0.0), abs=0.1)
    assert z == pytest.approx(0.15 + 0.02, abs=0.002)  # it stands on the table


def test_arrows_show_the_forces_of_a_grip(tab: Tab, robot: tool0.Robot) -> None:
    tab.page.set_viewport_size(SMALL)
    tcp = robot.pose("tool0") @ robot.gripper.tcp(opening=0.05)
    robot.scene.add(thing("ball", Sphere(radius=0.025), tcp.position, None))
    robot.gripper.move(opening=0.0, force=60.0)
    assert robot.gripper.wait(30.0).motion == "holding_inside"
    robot.pause()
    tab.see(READY)
    assert not robot.simulation.bus.wants_contacts
    assert written(tab) == []
    show(tab, "contacts")
    forces = [
        sum(part**2 for part in contact.force) ** 0.5 for contact in robot.contacts()
    ]
    largest = sorted(forces, reverse=True)
    assert largest[0] > 20.0
    wanted = [round(force, 1) for force in largest if force > 0.05][:8]
    eventually(lambda: written(tab) == pytest.approx(wanted, abs=0.051), f"{wanted}")
    show(tab, "contacts")
    eventually(lambda: written(tab) == [], "the arrows are gone")
    eventually(lambda: not robot.simulation.bus.wants_contacts, "nobody asks for them")


def test_an_arrow_shows_the_wrench_at_the_tool(tab: Tab, robot: tool0.Robot) -> None:
    tab.page.set_viewport_size(SMALL)
    tab.see(READY)
    show(tab, "wrench", "trace", "inertia")
    robot.apply_wrench("tool0", force=(0.0, 0.0, -30.0), torque=(0.0, 1.0, 0.0))

    def force() -> float:
        texts = tab.page.locator(".scene-labels span").all_text_contents()
        found = [re.match(r"F (\d+\.\d) N", text) for text in texts]
        return next((float(match[1]) for match in found if match), 0.0)

    def of_robot() -> float:
        fx, fy, fz, *_ = robot.arm.motion.state.wrench
        return float((fx**2 + fy**2 + fz**2) ** 0.5)

    eventually(lambda: abs(of_robot() - 30.0) < 1.0, "the robot feels it")
    eventually(lambda: abs(force() - 30.0) < 1.0, "the page shows it")


def test_the_card_of_a_link_is_not_clipped(tab: Tab) -> None:
    tab.see(READY)
    box = tab.get("scene").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def is_on_a_link() -> bool:
        tab.page.mouse.move(x + 1, y)
        tab.page.mouse.move(x, y)
        return tab.page.locator(".scene-tip").is_visible()

    def is_selected() -> bool:
        tab.get("scene-view-tool").click()
        eventually(is_on_a_link, "the view has turned to the tool")
        tab.page.mouse.click(x, y)  # ends the turn, perhaps beside the link
        try:
            tab.page.locator("[data-testid=selection] dl").wait_for(timeout=2000)
        except TooLate:
            return False
        return True

    eventually(is_selected, "a link is selected")
    beyond = tab.get("selection").evaluate(
        """card => {
            const { left, right } = card.getBoundingClientRect();
            const parts = [...card.querySelectorAll("*")];
            const places = parts.map(part => part.getBoundingClientRect());
            return places.filter(at => at.left < left || at.right > right).length;
        }"""
    )
    assert beyond == 0
