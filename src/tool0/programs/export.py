"""Programs as scripts: Python for tool0's API, or URScript for UR's control box."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from tool0.programs.robot_context import RobotContext


def exported(
    context: RobotContext, language: Literal["yaml", "python", "urscript"]
) -> str:
    """Return a program as text, or raise ControlError if this is impossible."""
    from tool0.programs.files import program_text

    match language:
        case "yaml":
            return program_text(context.program)
        case "python":
            from tool0.programs.export_python import python_text

            return python_text(context.program)
        case "urscript":
            from tool0.programs.export_urscript import urscript_text

            return urscript_text(context)
