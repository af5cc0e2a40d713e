"""A controller manager as the spawner and `ros2 control` call it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ros2_client import Client, Message

BEST_EFFORT, STRICT = 1, 2


class Manager:
    """The services of one controller manager."""

    def __init__(self, client: Client, name: str = "/controller_manager") -> None:
        self._client, self.name = client, name

    def call(self, service: str, kind: str, **request: object) -> Message:
        return self._client.call(
            f"{self.name}/{service}", f"controller_manager_msgs/srv/{kind}", **request
        )

    def controllers(self) -> dict[str, Message]:
        """Return the loaded ones by name."""
        listed = self.call("list_controllers", "ListControllers").controller
        return {one.name: one for one in listed}

    def states(self) -> dict[str, str]:
        """Return the state of each loaded one."""
        return {name: one.state for name, one in self.controllers().items()}

    def load(self, controller: str) -> bool:
        return bool(self.call("load_controller", "LoadController", name=controller).ok)

    def configure(self, controller: str) -> bool:
        return bool(
            self.call("configure_controller", "ConfigureController", name=controller).ok
        )

    def unload(self, controller: str) -> bool:
        return bool(
            self.call("unload_controller", "UnloadController", name=controller).ok
        )

    def switch(
        self,
        activate: Sequence[str] = (),
        deactivate: Sequence[str] = (),
        strictness: int = STRICT,
    ) -> bool:
        """Start and stop controllers, as the spawner's with its time limit."""
        answer = self.call(
            "switch_controller",
            "SwitchController",
            activate_controllers=list(activate),
            deactivate_controllers=list(deactivate),
            strictness=strictness,
            activate_asap=False,
            timeout=5.0,
        )
        return bool(answer.ok)

    def spawn(self, controller: str, file: Path, kind: str | None = None) -> None:
        """Do what `spawner CONTROLLER --inactive -p FILE` does."""
        named: dict[str, object] = {f"{controller}.params_file": [str(file)]}
        if kind is not None:
            named[f"{controller}.type"] = kind
        for one in named.items():
            (answer,) = self._client.set_named(self.name, dict([one]))
            assert answer.successful, answer.reason
        assert self.load(controller)
        assert self.configure(controller)

    def unspawn(self, controller: str) -> None:
        """Do what `unspawner CONTROLLER` does."""
        self.switch(deactivate=[controller], strictness=BEST_EFFORT)
        assert self.unload(controller)
