"""The layout on desktops, tablets and phones, and what a user can change of it."""

import gzip
import struct
from pathlib import Path

import pytest
from browser import Tab
from playwright.sync_api import Browser

from conftest import OpenTab
from tool0.panel.server import STATIC, Panel

READY = "[data-testid=scene][data-ready=true]"
FIRST_VIEW = 300_000
"""Largest size of what the first view needs, compressed by gzip [bytes]."""
OVERFLOW = "document.documentElement.scrollWidth - innerWidth"


@pytest.fixture
def panel(shared_panel: Panel) -> Panel:
    return shared_panel


def bottom(tab: Tab, test_id: str) -> float:
    box = tab.get(test_id).bounding_box()
    assert box is not None
    return box["y"] + box["height"]


def width(tab: Tab, selector: str) -> float:
    box = tab.page.locator(selector).bounding_box()
    assert box is not None
    return box["width"]


def test_joints_gripper_and_poses_fit_into_900_pixels(tab: Tab) -> None:
    names = ["joint-slider-wrist_3_joint", "gripper-force", "pose-go-home", "pose-save"]
    assert [name for name in names if bottom(tab, name) > 900] == []


def test_a_phone_has_a_header_of_one_row(browser: Browser, panel: Panel) -> None:
    tab = Tab(browser, panel.url, width=390, height=844, has_touch=True)
    assert tab.page.evaluate(OVERFLOW) <= 0
    for name in ("estop", "sim-pause", "sim-time", "menu"):
        assert bottom(tab, name) <= 60
    assert tab.get("language-zh").count() == 0
    tab.get("menu").click()
    tab.get("language-zh").click()
    tab.text("tab-motion", "运动")
    tab.get("theme-dark").click()
    tab.see("[data-theme=dark]")
    tab.get("tab-motion").click()
    tab.get("language-zh").wait_for(state="hidden")
    tab.close()


@pytest.mark.parametrize("size", [(390, 844), (820, 1180), (1024, 768)])
def test_no_tab_is_wider_than_the_screen(
    browser: Browser, panel: Panel, size: tuple[int, int]
) -> None:
    tab = Tab(browser, panel.url, width=size[0], height=size[1])
    for one in tab.page.locator("[role=tab][data-testid^=tab-]").all():
        one.click()
        tab.see("[role=tabpanel] > *")
        assert tab.page.evaluate(OVERFLOW) <= 0, one.get_attribute("data-testid")
    tab.close()


def test_the_column_and_the_plots_are_resized_and_stay_so(tab: Tab) -> None:
    tab.see(READY)
    before = width(tab, ".column")
    bar = tab.get("splitter-column")
    box = bar.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + 300
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x - 100, y, steps=4)
    tab.page.mouse.up()
    assert width(tab, ".column") == pytest.approx(before + 100, abs=2)
    bar.press("ArrowRight")
    assert width(tab, ".column") == pytest.approx(before + 76, abs=2)
    tab.get("plots-toggle").click()
    tab.get("splitter-plots-height").press("ArrowUp")
    plots = tab.page.locator("#plots").bounding_box()
    tab.page.reload()
    tab.see(READY)
    assert width(tab, ".column") == pytest.approx(before + 76, abs=2)
    again = tab.page.locator("#plots").bounding_box()
    assert plots is not None
    assert again is not None
    assert again["height"] == pytest.approx(plots["height"], abs=2)


def test_shortcuts_are_listed(tab: Tab) -> None:
    tab.see(READY)
    tab.page.locator("body").press("?")
    tab.text("shortcut-help", "Emergency stop")
    tab.get("shortcut-help-close").click()
    tab.get("shortcut-help").wait_for(state="hidden")
    tab.get("pose-name").press("?")  # which is typed there
    assert tab.get("shortcut-help").count() == 0


def test_a_picture_of_the_scene_is_saved(tab: Tab, tmp_path: Path) -> None:
    tab.see(READY)
    size = tab.page.locator("[data-testid=scene] canvas").bounding_box()
    with tab.page.expect_download() as download:
        tab.get("scene-screenshot").click()
    file = tmp_path / "picture.png"
    download.value.save_as(file)
    assert download.value.suggested_filename == "ur5_robot.png"
    data = file.read_bytes()
    assert data.startswith(b"\x89PNG")
    assert size is not None
    pixels = struct.unpack(">II", data[16:24])
    assert pixels == pytest.approx((2 * size["width"], 2 * size["height"]), abs=4)
    assert len(set(data)) == 256  # it is no blank picture
    assert len(data) > 50_000


def test_the_camera_stays_above_the_floor(tab: Tab) -> None:
    """From below, the ground would hide nothing and everything would be seen."""
    tab.see(READY)
    canvas = tab.page.locator("[data-testid=scene] canvas")
    canvas.focus()
    for _ in range(40):
        canvas.press("ArrowDown")
    eye = "Number(document.querySelector('[data-testid=scene]').dataset.eye)"
    tab.page.wait_for_function(f"() => {eye} < 0.05")
    assert tab.page.evaluate(eye) >= 0.0


def test_the_first_view_is_small(panel: Panel, open_tab: OpenTab) -> None:
    tab = open_tab(panel.url)
    tab.see(READY)
    paths = {url.split("?")[0].removeprefix(panel.url) for url in tab.requested}
    files = [STATIC / (path.strip("/") or "index.html") for path in paths]
    sizes = {
        file.name: len(gzip.compress(file.read_bytes(), 6))
        for file in files
        if file.is_file()
    }
    print(sum(sizes.values()), sizes)
    assert any("scene" in name for name in sizes)
    assert sum(sizes.values()) <= FIRST_VIEW


@pytest.mark.parametrize("language", ["en", "zh"])
def test_every_tab_is_in_sight(tab: Tab, language: str) -> None:
    tab.get(f"language-{language}").click()
    strip = tab.page.locator(".column [role=tablist]")
    assert strip.evaluate("(tabs) => tabs.scrollWidth - tabs.clientWidth") <= 0
    assert strip.evaluate("(tabs) => tabs.scrollHeight - tabs.clientHeight") <= 0


def test_no_number_of_the_tool_is_cut_off(tab: Tab) -> None:
    tab.get("tool-toggle").click()
    tab.get("tool-5").wait_for()
    fields = "[data-testid=tool-pose] input"
    cut = "(all) => all.map((one) => one.scrollWidth - one.clientWidth)"
    for unit in ("rad", "deg"):
        tab.get(f"unit-{unit}").click()
        assert max(tab.page.locator(fields).evaluate_all(cut)) <= 0


def test_a_small_laptop_has_the_controls_beside_the_view(
    browser: Browser, panel: Panel
) -> None:
    tab = Tab(browser, panel.url, width=1024, height=768)
    view = tab.page.locator(".scene").bounding_box()
    controls = tab.page.locator(".column").bounding_box()
    assert view is not None
    assert controls is not None
    assert controls["x"] >= view["x"] + view["width"] - 1
    assert bottom(tab, "tab-motion") < 200
    tab.close()


@pytest.mark.parametrize("size", [(390, 844), (820, 1180)])
def test_the_view_stays_in_sight_above_the_controls(
    browser: Browser, panel: Panel, size: tuple[int, int]
) -> None:
    tab = Tab(browser, panel.url, width=size[0], height=size[1])
    line = tab.get("timeline")
    line.wait_for()
    tab.get("pose-save").scroll_into_view_if_needed()
    assert tab.page.evaluate("scrollY") > 0
    header = bottom(tab, "estop")
    view = tab.page.locator(".scene").bounding_box()
    strip = line.bounding_box()
    assert view is not None
    assert strip is not None
    assert view["y"] == pytest.approx(header, abs=10)
    assert view["height"] < 0.45 * size[1]
    assert strip["y"] == pytest.approx(view["y"] + view["height"], abs=2)
    assert strip["height"] < 50  # one row
    tab.close()


def test_motion_is_beside_the_program_where_there_is_room(
    browser: Browser, panel: Panel
) -> None:
    tab = Tab(browser, panel.url, width=1680, height=1000)
    tab.get("tab-program").click()
    program = tab.get("program-add-wait").bounding_box()
    motion = tab.get("joint-slider-elbow_joint").bounding_box()
    assert program is not None
    assert motion is not None
    assert motion["x"] > program["x"] + program["width"]
    tab.close()
