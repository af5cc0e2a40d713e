"""Descriptions of steps for the display of a program."""

from __future__ import annotations

from tool0.protocol.program import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveJointStep,
    MoveLinearStep,
    MoveStep,
    PlaceObjectStep,
    SetOutputStep,
    Step,
    UntilStep,
    WaitStep,
)

_LONGEST = 80


def step_text(step: Step) -> str:
    """Return a short description of a step."""
    match step:
        case MoveJointStep(plan=True):
            return f"go around to {_target(step)}"
        case MoveJointStep():
            return f"move joints to {_target(step)}"
        case MoveLinearStep():
            return f"move on a line to {_target(step)}"
        case GripperStep(opening=float() | int() as opening):
            return f"gripper to {1e3 * opening:.1f} mm"
        case GripperStep(opening=opening):
            return f"gripper {opening}"
        case WaitStep(input=None):
            return f"wait {step.duration:g} s"
        case WaitStep():
            return f"wait until input {step.input} is {_level(step.level)}"
        case UntilStep(force=None):
            return "move until contact"
        case UntilStep():
            return f"move until {step.force:g} N"
        case PlaceObjectStep():
            return f"place '{step.name}'"
        case SetOutputStep():
            return f"set output {step.output} {_level(step.level)}"
        case CommentStep():
            return step.text[:_LONGEST]
        case LoopStep(times=int() as times):
            return f"repeat {times} times"
        case LoopStep(while_input=int() as pin):
            return f"repeat while input {pin} is {_level(step.level)}"
        case LoopStep():
            return "repeat forever"


def _target(step: MoveStep) -> str:
    if step.label:
        return f"'{step.label[:_LONGEST]}'"
    if step.named_pose is not None:
        return f"'{step.named_pose}'"
    if step.pose is not None:
        x, y, z = step.pose.xyz
        frame = "" if step.pose.relative_to is None else f" in {step.pose.relative_to}"
        return f"({x:.3f}, {y:.3f}, {z:.3f}){frame}"
    return "taught joints"


def _level(level: bool) -> str:
    return "high" if level else "low"
