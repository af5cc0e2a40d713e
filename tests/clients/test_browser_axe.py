"""What axe-core finds in the page: nothing, in either theme, on any tab and width.

It is the axe-core of ``web/node_modules``, https://github.com/dequelabs/axe-core
"""

from pathlib import Path

import pytest
from browser import Tab
from playwright.sync_api import Browser
from promised import absent

from tool0.panel.server import Panel

AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"
VIOLATIONS = """async () => (await axe.run(document)).violations.flatMap((rule) =>
    rule.nodes.map((node) => `${rule.id}: ${node.target.join(" ")}: ${node.html}`))"""
WIDTHS = {"desktop": (1440, 900), "tablet": (820, 1180), "phone": (390, 844)}


@pytest.fixture
def panel(shared_panel: Panel) -> Panel:
    return shared_panel


def violations(tab: Tab) -> list[str]:
    """Return what axe finds, without the animations that hide what is there."""
    tab.page.evaluate(
        "Promise.allSettled(document.getAnimations().map((a) => a.finished))"
    )
    found: list[str] = tab.page.evaluate(VIOLATIONS)
    return found


@pytest.mark.parametrize(
    ("width", "theme"), list(zip(WIDTHS, ("dark", "light", "dark"), strict=True))
)
def test_axe_finds_nothing(
    browser: Browser, panel: Panel, width: str, theme: str
) -> None:
    if not AXE.is_file():
        absent("browser", "axe-core is not installed in web/node_modules")
    tab = Tab(browser, width=WIDTHS[width][0], height=WIDTHS[width][1])
    tab.page.add_init_script(f"localStorage.setItem('tool0.theme', '{theme}')")
    tab.open(panel.url)
    tab.see("[data-testid=scene][data-ready=true]")
    assert tab.page.evaluate("document.documentElement.dataset.theme") == theme
    tab.page.evaluate(AXE.read_text("utf-8"))
    found = {"read-only": violations(tab)}
    tab.drive()
    tab.get("plots-toggle").click()
    tab.see("[data-testid=plots-chart] canvas")
    tab.get("scene-options").click()
    tabs = tab.page.locator("[role=tab][data-testid^=tab-]")
    names = [one.get_attribute("data-testid") or "" for one in tabs.all()]
    for name in names:
        tab.get(name).click()
        tab.see("[role=tabpanel] > *")
        found[name] = violations(tab)
    tab.get("shortcuts").click()
    tab.get("shortcut-help").wait_for()
    found["help"] = violations(tab)
    tab.close()
    assert len(names) >= 5
    assert {name: what for name, what in found.items() if what} == {}
