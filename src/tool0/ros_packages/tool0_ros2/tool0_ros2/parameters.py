"""Parameters of the controllers' nodes."""

from collections.abc import Collection, Mapping
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.parameter import Parameter

from tool0_ros2.bridge import Context
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.requests import set_controller_parameters


def to_parameters(values: Mapping[str, Any]) -> list[Parameter]:
    """Return ROS parameters with dotted names.

    Parameters without a value are omitted.
    """
    found = []
    for name, value in values.items():
        if isinstance(value, (list, tuple)):
            items = _list(value)
            kind = Parameter.Type.from_parameter_value(items or [""])
            found.append(Parameter(name, kind, items))
        elif isinstance(value, (bool, int, float, str)):
            found.append(Parameter(name, value=value))
    return found


def _list(values: Any) -> list[Any]:
    """Return a list of one type.  If any value is a float, all values become floats."""
    if any(isinstance(value, float) for value in values):
        return [float(value) for value in values]
    return list(values)


class ControllerParameters:
    """Forwards changes of a controller's parameters to the simulation."""

    def __init__(
        self,
        context: Context,
        controller: str,
        node: Any,
        values: dict[str, Any],
        adjustable: Collection[str],
    ) -> None:
        """Declare ``values`` as parameters of ``node``, and accept changes.

        ``values`` contains full names, and the ROS parameters contain own names.
        ``adjustable`` contains the names of the parameters that may change while the
        controller runs.
        """
        self._context, self._controller = context, controller
        self._values = values
        own = context.names.own_values
        self._full_names = {own(name): name for name in values}
        self._full_texts = {
            own(text): text
            for value in values.values()
            for text in (value if isinstance(value, list) else [value])
            if isinstance(text, str)
        }
        for parameter in to_parameters(own(values)):
            name = parameter.name
            if not node.has_parameter(name):
                is_fixed = self._full_names[name] not in adjustable
                when = "when it is configured" if is_fixed else "at any time"
                about = ParameterDescriptor(
                    description=f"Read by the controller {when}.", read_only=is_fixed
                )
                node.declare_parameter(name, parameter.value, about)
        node.add_on_set_parameters_callback(self._set)

    def _set(self, parameters: list[Any]) -> SetParametersResult:
        """Change parameters in the simulation, or return the reason for a failure."""
        changes = {
            self._full_names[item.name]: self._full(item.value)
            for item in parameters
            if item.name in self._full_names
        }
        changes = {k: v for k, v in changes.items() if v != self._values[k]}
        if not changes:
            return SetParametersResult(successful=True)
        try:
            self._context.connection.call(
                set_controller_parameters(
                    controller=self._controller, parameters=changes
                )
            )
        except RequestFailedError as error:
            reason = self._context.names.text(error)
            return SetParametersResult(successful=False, reason=reason)
        self._values.update(changes)
        return SetParametersResult(successful=True)

    def _full(self, value: Any) -> Any:
        """Return a parameter's value as a plain value with full names."""
        if isinstance(value, str):
            return self._full_texts.get(value, value)
        if isinstance(value, (bool, int, float)):
            return value
        return [self._full(item) for item in value]
