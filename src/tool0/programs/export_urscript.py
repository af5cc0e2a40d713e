"""Programs as URScript, for the control box of a UR with a Robotiq gripper."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import final

import numpy as np

from tool0.description.model import FLANGE, ROBOTIQ
from tool0.description.transform_arrays import matrix_of, rotation_vector
from tool0.errors import ProgramError
from tool0.kinematics.chain import Array, fixed_transform
from tool0.motion.moves import Move
from tool0.programs.planning import (
    is_planned,
    moves_from,
    problems_text,
    static_problems,
)
from tool0.programs.robot_context import RobotContext
from tool0.protocol.program import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveStep,
    PlaceObjectStep,
    SetOutputStep,
    Step,
    StepPath,
    UntilStep,
    WaitStep,
    path_text,
    walk,
)


def urscript_text(context: RobotContext) -> str:
    """Return an equivalent URScript program for a UR's control box.

    The script does not place objects; a comment in the script marks each omitted step.

    Raises:
        ProgramError: If a step is impossible, or if its path must be planned around
            obstacles.
    """
    steps = dict(walk(context.program.steps))
    for path, step in steps.items():
        if is_planned(step):
            raise ProgramError(
                f"step {path_text(path)}: URScript cannot plan around obstacles: "
                "replace 'plan' by moves through waypoints, or export to Python"
            )
    problems = [
        problem
        for problem in static_problems(context)
        if not isinstance(steps.get(problem.step), PlaceObjectStep)
    ]
    if problems:
        raise ProgramError(problems_text(context.program.name, problems))
    return "\n".join(_Writer(context).program()) + "\n"


@final
class _Writer:
    def __init__(self, context: RobotContext) -> None:
        self._context = context
        model, chain = context.model, context.chain
        base = f"{context.tip.removesuffix(FLANGE)}base"
        T_chain_base = np.eye(4)
        if any(link.name == base for link in model.links):
            T_chain_base = fixed_transform(model, chain.base, base).matrix
        self._T_base_root = np.linalg.inv(context.T_root_base @ T_chain_base)
        """Pose of the robot's root in the base frame of UR's controller, shape (4,
        4)."""

    def program(self) -> Iterator[str]:
        program = self._context.program
        name = re.sub(r"\W", "_", program.name, flags=re.ASCII)
        yield f"# {_one_line(program.name)}: exported by tool0"
        if program.collision == "refuse":
            yield "# the controller does not check moves for collisions"
        yield f"def program_{name}():"
        yield f"  set_tcp({_pose(self._context.T_tip_tool)})"
        if any(isinstance(step, GripperStep) for _, step in walk(program.steps)):
            yield "  if not rq_is_gripper_activated():"
            yield "    rq_activate_and_wait()"
            yield "  end"
        yield from self._block(program.steps, (), "  ")
        yield "end"

    def _block(
        self, steps: Sequence[Step], parents: StepPath, space: str
    ) -> Iterator[str]:
        for number, step in enumerate(steps, 1):
            path = (*parents, number)
            if isinstance(step, LoopStep):
                yield from self._loop(step, path, space)
                continue
            goes_on = bool(moves_from(steps, number, parents))
            for line in self._step(step, path, goes_on):
                yield space + line

    def _step(self, step: Step, path: StepPath, goes_on: bool) -> Iterator[str]:
        match step:
            case CommentStep():
                yield f"# {_one_line(step.text)}"
            case GripperStep():
                yield from self._grip(step, path)
            case WaitStep(input=None):
                yield f"sleep({step.duration:g})"
            case WaitStep():
                yield from _wait(step, path)
            case UntilStep():
                yield from self._search(step, path)
            case PlaceObjectStep():
                yield f"# '{_one_line(step.name)}' is placed in the simulation only"
            case SetOutputStep():
                yield f"set_digital_out({step.output}, {step.level})"
            case LoopStep():
                pass  # _block writes loops
            case _:
                yield self._move(step, goes_on)

    def _move(self, step: MoveStep, goes_on: bool) -> str:
        """Return the line of a move; it has a blend only if the path continues."""
        move: Move = self._context.move(step)
        if move.q is not None:
            target = "[" + ", ".join(f"{q:.9g}" for q in move.q) + "]"
        else:
            assert move.pose is not None  # a move has joint positions or a pose
            target = _pose(self._T_base_root @ matrix_of(move.pose))
        blend = f", r={move.r:.6g}" if move.r and goes_on else ""
        label = f"  # {_one_line(step.label)}" if step.label else ""
        return f"{move}({target}, a={move.a:.6g}, v={move.v:.6g}{blend}){label}"

    def _grip(self, step: GripperStep, path: StepPath) -> Iterator[str]:
        geometry = self._context.geometry
        opening = self._context.opening(step)
        assert geometry is not None  # the step has an opening, so the geometry is known
        if geometry.protocol != ROBOTIQ:
            raise ProgramError(
                f"step {path_text(path)}: URScript has functions for Robotiq grippers "
                "only, and the description of this one does not have their protocol"
            )
        speed = _percent(geometry.speed, step.speed)
        yield f"rq_set_speed_norm({speed:.6g})"
        yield f"rq_set_force_norm({_percent(geometry.force, step.force):.6g})"
        if step.opening == "open":
            yield "rq_open_and_wait()"
        elif step.opening == "closed":
            yield "rq_close_and_wait()"
        else:
            yield f"rq_move_and_wait_mm({1e3 * opening:.6g})"
        if step.must_hold:
            text = "the gripper holds nothing"
            yield from _halt("not rq_is_object_detected()", path, text)

    def _search(self, step: UntilStep, path: StepPath) -> Iterator[str]:
        name = _name(path)
        direction = np.array(step.direction) / np.linalg.norm(step.direction)
        yield f"{name}_start = get_actual_tcp_pose()"
        if step.frame == "tool":
            ahead = f"p[{_numbers(direction)}, 0, 0, 0]"
            yield f"{name}_ahead = pose_trans({name}_start, {ahead})"
            difference = ", ".join(
                f"{name}_ahead[{k}] - {name}_start[{k}]" for k in range(3)
            )
            yield f"{name}_d = [{difference}]"
        else:
            yield f"{name}_d = [{_numbers(self._T_base_root[:3, :3] @ direction)}]"
        d = [f"{name}_d[{k}]" for k in range(3)]
        touched = f"tool_contact([{', '.join(d)}, 0, 0, 0]) > 0"
        if step.force is not None:
            along = " + ".join(f"{name}_f[{k}] * {d[k]}" for k in range(3))
            yield f"{name}_f = get_tcp_force()"
            yield f"{name}_f0 = {along}"
            touched = f"{name}_f0 - ({along}) >= {step.force:.6g}"
        velocity = ", ".join(f"{step.speed:.6g} * {item}" for item in d)
        yield f"{name}_touched = False"
        distance = f"point_dist({name}_start, get_actual_tcp_pose())"
        yield f"while not {name}_touched and {distance} < {step.distance:.6g}:"
        a = f"{step.acceleration:.6g}"
        yield f"  speedl([{velocity}, 0, 0, 0], {a}, get_steptime())"
        if step.force is not None:
            yield f"  {name}_f = get_tcp_force()"
        yield f"  {name}_touched = {touched}"
        yield "end"
        yield f"stopl({a})"
        if step.must_touch:
            yield from _halt(f"not {name}_touched", path, "nothing was touched")

    def _loop(self, loop: LoopStep, path: StepPath, space: str) -> Iterator[str]:
        name = _name(path)
        condition = "True"
        if loop.times is not None:
            yield f"{space}{name}_count = 0"
            condition = f"{name}_count < {loop.times}"
        elif loop.while_input is not None:
            condition = f"get_digital_in({loop.while_input}) == {loop.level}"
        yield f"{space}while {condition}:"
        yield from self._block(loop.steps, path, space + "  ")
        if loop.times is not None:
            yield f"{space}  {name}_count = {name}_count + 1"
        yield f"{space}  sync()"
        yield f"{space}end"


def _wait(step: WaitStep, path: StepPath) -> Iterator[str]:
    name = _name(path)
    if step.duration is not None:
        yield f"{name}_time = 0.0"
    yield f"while get_digital_in({step.input}) != {step.level}:"
    if step.duration is not None:
        late = f"{name}_time >= {step.duration:.6g}"
        text = f"input {step.input} did not change in time"
        yield from ("  " + line for line in _halt(late, path, text))
        yield f"  {name}_time = {name}_time + get_steptime()"
    yield "  sync()"
    yield "end"


def _halt(condition: str, path: StepPath, text: str) -> Iterator[str]:
    yield f"if {condition}:"
    yield f'  textmsg("step {path_text(path)}: {text}")'
    yield "  halt"
    yield "end"


def _name(path: StepPath) -> str:
    return "step_" + "_".join(map(str, path))


def _percent(span: tuple[float, float], value: float | None) -> float:
    low, high = span
    if value is None or high <= low:
        return 100.0
    return 100.0 * (value - low) / (high - low)


def _pose(T: Array) -> str:
    return f"p[{_numbers(T[:3, 3])}, {_numbers(rotation_vector(T[:3, :3]))}]"


def _numbers(values: Array) -> str:
    return ", ".join(f"{value + 0.0:.9g}" for value in values.tolist())


def _one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip()
