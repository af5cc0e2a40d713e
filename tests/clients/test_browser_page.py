"""The page itself: how big it is, when it paints, in which language, in which mode."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from browser import TIMEOUT, Tab
from playwright.sync_api import Browser

import tool0
from conftest import OpenTab
from tool0.description.loading import assemble
from tool0.panel.robot_info import RobotFiles
from tool0.panel.server import STATIC, Panel
from tool0.panel.view import RobotView

WEB = Path(__file__).parents[2] / "web"
READY = "[data-testid=scene][data-ready=true]"
SEEN_READY_AT = """
new MutationObserver((_, watch) => {
    if (!document.querySelector('[data-testid=scene][data-ready="true"]')) return;
    window.readyAt = performance.now();
    watch.disconnect();
}).observe(document, { subtree: true, childList: true, attributes: true });
"""
FIRST_PAINT = """new Promise((resolve) => {
    new PerformanceObserver((list) => {
        const paint = list.getEntriesByName("first-contentful-paint")[0];
        if (paint) resolve(paint.startTime);
    }).observe({ type: "paint", buffered: true });
})"""
ARE_DRAWN_ALIKE = """([one, other]) => {
    const drawn = (text) => {
        const canvas = document.createElement("canvas");
        const context = canvas.getContext("2d");
        context.font = "48px " + getComputedStyle(document.body).fontFamily;
        context.fillText(text, 10, 60);
        return canvas.toDataURL();
    };
    return drawn(one) === drawn(other);
}"""


def test_the_controls_are_painted_before_the_scene_is_ready(
    panel: Panel, open_tab: OpenTab, record_property: Callable[[str, object], None]
) -> None:
    tab = open_tab()
    tab.page.add_init_script(SEEN_READY_AT)
    tab.open(panel.url)
    tab.see(READY)
    paint, ready = tab.page.evaluate(
        f"async () => [await {FIRST_PAINT}, window.readyAt]"
    )
    record_property("first_contentful_paint_ms", round(paint))
    record_property("scene_ready_ms", round(ready))
    print(f"first contentful paint {paint:.0f} ms, scene ready {ready:.0f} ms")
    assert 0.0 < paint < ready


def test_the_scene_and_the_plots_draw(tab: Tab) -> None:
    tab.see(READY)
    tab.page.wait_for_function(
        "() => Number(document.querySelector('[data-testid=scene]').dataset.frames) > 0"
    )
    tab.get("plots-toggle").click()
    tab.see("[data-testid=plots-chart] canvas")


def test_the_server_learns_when_the_robot_is_drawn(
    panel: Panel, open_tab: OpenTab
) -> None:
    assert not panel.await_page(0.0)
    tab = open_tab(panel.url)
    assert panel.await_page(TIMEOUT)
    assert tab.page.locator(READY).count() == 1


def test_every_tab_opens(tab: Tab) -> None:
    tab.get("tab-tree").click()
    tab.get("tree-link-tool0").wait_for()
    tab.get("tab-log").click()
    tab.get("log-filter").wait_for()
    tab.get("tab-controllers").click()
    tab.get("controller-row-joint_state_controller").wait_for()
    tab.get("tab-motion").click()
    tab.get("joint-slider-elbow_joint").wait_for()


def test_chinese_is_chinese(tab: Tab) -> None:
    tab.text("estop", "STOP")
    tab.get("language-zh").click()
    tab.text("estop", "急停")
    tab.text("tab-controllers", "控制器")
    assert tab.page.locator("html").get_attribute("lang") == "zh-CN"
    # without a font that knows them, all characters are the same empty box
    assert not tab.page.evaluate(ARE_DRAWN_ALIKE, ["急", "停"])
    tab.page.reload()
    tab.text("estop", "急停")


def test_the_grasp_assist_is_shown_on_every_tab(open_tab: OpenTab) -> None:
    simulation = tool0.SimulationConfig(grasp_assist=True, realtime=False)
    with (
        tool0.bringup(simulation=simulation) as robot,
        Panel(robot) as panel,
    ):
        tab = open_tab(panel.url)
        for name in ("motion", "log"):
            tab.get(f"tab-{name}").click()
            tab.text("grasp-assist", "assist")
        for width in (1440, 1024, 390):  # beside the emergency stop, or over the view
            tab.page.set_viewport_size({"width": width, "height": 800})
            for test_id in ("grasp-assist", "estop"):
                box = tab.get(test_id).bounding_box()
                assert box is not None
                assert box["x"] + box["width"] <= width
        tab.close()  # before its server


def test_themes_change_the_colours(tab: Tab) -> None:
    background = "() => getComputedStyle(document.body).backgroundColor"
    tab.get("theme-light").click()
    light = tab.page.evaluate(background)
    tab.get("theme-dark").click()
    tab.page.wait_for_function(f"(light) => ({background})() !== light", arg=light)


@pytest.fixture
def view() -> Iterator[Panel]:
    with Panel(RobotView(assemble(), ground=-0.1)) as panel:
        yield panel


def test_view_poses_joints_for_every_page(view: Panel, open_tab: OpenTab) -> None:
    one, other = open_tab(view.url), open_tab(view.url)
    one.send_joint("elbow_joint", 0.7)
    for tab in (one, other):
        tab.shows_joint("elbow_joint", 0.7, 1e-3)
    other.get("joint-slider-elbow_joint").press("ArrowRight")
    for tab in (one, other):
        tab.shows_joint("elbow_joint", 0.71, 1e-3)
    assert one.get("estop").count() == 0
    assert one.get("tab-controllers").count() == 0
    for tab in (one, other):
        tab.see(READY)


def test_a_tablet_has_every_control_in_its_width(
    browser: Browser, panel: Panel
) -> None:
    tab = Tab(browser, panel.url, width=820, height=1180)
    overflow = "document.documentElement.scrollWidth - innerWidth"
    assert tab.page.evaluate(overflow) <= 0
    for name in ("estop", "menu", "sim-pause", "enable-toggle"):
        tab.get(name).scroll_into_view_if_needed()
        box = tab.get(name).bounding_box()
        assert box is not None
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 820
    tab.close()


def test_the_meshes_are_small() -> None:
    meshes = {
        file: file.stat().st_size for file in RobotFiles(assemble()).meshes.values()
    }
    print(f"meshes {sum(meshes.values()) / 1e6:.2f} MB")
    assert 0 < sum(meshes.values()) <= 2_000_000


@pytest.mark.usefixtures("browser")
def test_the_page_has_no_source_maps() -> None:
    assert not list(STATIC.rglob("*.map"))


@pytest.mark.usefixtures("browser")
def test_every_bundled_package_is_named_with_its_licence(tab: Tab) -> None:
    names = json.loads((WEB / "package.json").read_text("utf-8"))["dependencies"]
    notices = (STATIC / "licenses.md").read_text("utf-8")
    assert {"three", "preact", "uplot", "urdf-loader"} <= set(names)
    for name in names:
        assert f"## {name} - " in notices
    for text in ("The MIT License", "Apache License", "Copyright"):
        assert text in notices
    with tab.context.expect_page() as opened:
        tab.get("licenses").click()
    shown = opened.value.locator("body")
    assert shown.inner_text().split() == notices.split()
