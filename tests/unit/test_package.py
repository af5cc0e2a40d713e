"""What the package says about itself."""

import re
from pathlib import Path

import tool0

ROOT = Path(__file__).parent.parent.parent


def test_every_file_has_the_version_of_the_package() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    (version,) = re.findall(r'^version = "(.*?)"', project, re.MULTILINE)
    assert tool0.__version__ == version
    manifests = list((ROOT / "src/tool0/ros_packages").glob("*/package.xml"))
    assert len(manifests) >= 2
    for path in manifests:
        assert f"<version>{version}</version>" in path.read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {version}\n" in citation
    plugin = ROOT / "plugins/lerobot_robot_tool0/pyproject.toml"
    assert f'\nversion = "{version}"\n' in plugin.read_text(encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(
        rf"^## \[{re.escape(version)}\] - \d{{4}}-\d\d-\d\d$", changelog, re.MULTILINE
    )
    protocol = (ROOT / "docs/reference/panel-protocol.md").read_text(encoding="utf-8")
    assert f'"version": "{version}"' in protocol


def test_every_command_of_the_contributing_page_is_a_target() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    named = set(re.findall(r"(?:^|`)make ([a-z-]+)", text, re.MULTILINE))
    assert len(named) > 8
    assert named <= targets
