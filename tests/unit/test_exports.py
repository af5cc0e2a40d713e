import subprocess
import sys

import tool0

LOADED = """
import sys
import tool0
heavy = {"mujoco", "numpy", "yaml", "xacro", "tyro", "logging", "socket"}
print(sorted(heavy & sys.modules.keys()))
"""


def test_import_starts_nothing_heavy() -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_exports_are_sorted_and_few() -> None:
    assert tool0.__all__ == sorted(tool0.__all__)
    assert 0 < len(tool0.__all__) <= 16


def test_every_export_is_there_and_shown() -> None:
    for name in tool0.__all__:
        assert getattr(tool0, name) is not None
    assert set(tool0.__all__) <= set(dir(tool0))


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    assert not hasattr(tool0, "no_such_name")


def test_shapes_and_scenes_have_a_module_of_their_own() -> None:
    from tool0 import scene

    assert scene.__all__ == sorted(scene.__all__)
    for name in scene.__all__:
        assert getattr(scene, name) is not None
