from pathlib import Path

import pytest
from coupling import coupled_pairs, packages, report


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """Write four packages: a - b by a module, a - c for annotations, d alone."""
    root = tmp_path / "tool0"
    files = {
        "__init__.py": "from tool0.a.one import A",
        "a/__init__.py": "",
        "a/one.py": "def f():\n    from tool0 import b\n",
        "a/deep/two.py": "if TYPE_CHECKING:\n    import tool0.c\n",
        "b/__init__.py": "from tool0.a.one import A\nfrom tool0.b.other import B\n",
        "c.py": "import toolbox, tool0\nfrom json import dumps",
        "d/__init__.py": "from dataclasses import dataclass",
        "ros_packages/__init__.py": "import tool0.d",
    }
    for name, text in files.items():
        file = root / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return root


def test_any_import_couples_two_packages_once(source: Path) -> None:
    assert packages(source) == ["a", "b", "c", "d"]
    assert coupled_pairs(source) == [("a", "b"), ("a", "c")]


def test_the_share_is_printed_and_bounded(source: Path) -> None:
    text = "coupled package pairs: 2 of 6 (33%)"
    assert report(source, 0.33) == (text, 0)
    line, status = report(source, 0.32)
    assert line.startswith(text)
    assert status == 1
