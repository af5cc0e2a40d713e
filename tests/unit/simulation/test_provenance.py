from importlib.metadata import version

import pytest

from tool0.engines import registry
from tool0.engines.registry import EngineDefinition, GazeboEngineOptions
from tool0.simulation import provenance


def test_the_package_of_an_engine_decides_its_results() -> None:
    assert provenance.current_versions("mujoco").keys() == {"tool0", "python", "mujoco"}
    assert provenance.current_versions("gazebo").keys() == {"tool0", "python"}
    found = provenance.batch_versions()
    assert found.keys() == {"tool0", "mujoco", "numpy"}
    assert found["mujoco"] == version("mujoco")


def test_an_engine_declares_that_it_is_deterministic() -> None:
    assert provenance.is_deterministic("mujoco")
    assert not provenance.is_deterministic("gazebo")


def test_a_registered_engine_needs_no_edit_elsewhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(registry, "_ENGINES", dict(registry._ENGINES))
    mujoco = registry.engine_definition("mujoco")
    registry.register_engine(
        "exact",
        EngineDefinition(
            options=GazeboEngineOptions,
            create=mujoco.create,
            package="absent-physics",
            is_deterministic=True,
        ),
    )
    assert provenance.is_deterministic("exact")
    assert provenance.current_versions("exact")["absent-physics"] == "not installed"
