"""``tool0 demo``: entire tasks, which are measured and shown in the panel."""

from __future__ import annotations

import contextlib
import json
import select
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TextIO, final

from tool0.cli import GOAL_FAILED, OK, options
from tool0.cli.bringup import quiet_overruns
from tool0.cli.options import PanelOptions
from tool0.cli.parameters import AsJson
from tool0.cli.text import ProgressBar, finite, panel_line, print_json
from tool0.description.config import DescriptionConfig
from tool0.description.units import Metres
from tool0.errors import ConfigError
from tool0.simulation.config import SimulationConfig
from tool0.user_data import require_writable

if TYPE_CHECKING:
    from tool0.api.robot import Robot
    from tool0.cli.demos.hand import PickOptions
    from tool0.cli.demos.report import PickReport
    from tool0.cli.demos.setup import Cube, Demo
    from tool0.cli.demos.trials import DemoReport
    from tool0.protocol.state import Snapshot

READERS = options.READERS

PAGE_TIMEOUT = 300.0
"""Longest wait for a browser to load the scene [wall s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DemoArguments:
    """The cube, the trials, and the output."""

    engine: str = SimulationConfig().engine
    """The physics engine: mujoco or gazebo."""
    n: int = 1
    """Number of trials.  The cube's pose is random from the second trial onward; with
    --seed, it is random in all trials."""
    seed: int | None = None
    """Seed of the random poses; without a seed, the first trial uses the pose from the
    scene."""
    size: Metres = 0.045
    """Edge of the cube [m]."""
    mass: float = 0.1
    """Mass of the cube [kg]."""
    friction: float = 1.0
    """Coefficient of friction of the cube."""
    force: float = 60.0
    """Gripping force at each pad [N]; it must be within the gripper's range."""
    speed: float = 0.7
    """Speed of the arm's joints, as a fraction of their maximum speed."""
    grasp_assist: bool = False
    """Attach the gripped cube to the gripper, regardless of friction and force."""
    headless: bool = False
    """Run without the panel, and as fast as possible."""
    report: Path | None = None
    """Also write the report to this file, as JSON."""
    video: Path | None = None
    """Record a video in this MP4 file; this requires `pip install '.[video]'`."""
    camera: str = "scene"
    """The camera that records the video: scene or wrist."""
    as_json: AsJson = False
    """Print the report as one JSON object."""

    def __post_init__(self) -> None:
        if self.n < 1:
            raise ConfigError(f"--n must be 1 or more, got {self.n}")

    @property
    def cube(self) -> Cube:
        """The cube to pick."""
        from tool0.cli.demos.setup import Cube

        return Cube(edge=self.size, mass=self.mass, friction=self.friction)

    @property
    def options(self) -> PickOptions:
        """Options for gripping and transporting the object."""
        from tool0.cli.demos.hand import PickOptions

        return PickOptions(force=self.force, speed=self.speed)


def pick(
    arguments: DemoArguments = DemoArguments(),
    description: DescriptionConfig = DescriptionConfig(),
    panel: PanelOptions = PanelOptions(),
) -> int:
    """Pick a cube from a table, and place it in a bin.

    Only friction holds the cube.  The positions of the table and the bin depend on the
    arm's reach.  The demo runs in real time and starts when a browser shows the robot.
    After the demo, Enter repeats it, and Ctrl-C ends the command.  With --headless, the
    demo runs as fast as possible and then ends.

    The exit status is 1 if a cube is not in the bin.
    """
    _check_files(arguments)  # check the files first, because the picks take minutes
    from tool0.cli.demos.setup import pick_demo

    return _run(
        pick_demo(arguments.cube, arguments.options, description), arguments, panel
    )


def handover(
    arguments: DemoArguments = DemoArguments(),
    giver: str = "ur5+2f85",
    taker: str = "ur10e+hande",
    panel: PanelOptions = PanelOptions(),
) -> int:
    """Pick a cube with one arm, hand it to a second arm, and place it in a bin.

    Only friction holds the cube.  For the panel, repetitions and the exit status, see
    `demo pick`.

    Args:
        giver: The arm that picks the cube, with its gripper: ARM+GRIPPER.
        taker: The arm that places the cube, with its gripper: ARM+GRIPPER.
    """
    _check_files(arguments)
    from tool0.cli.demos.setup import handover_demo

    return _run(
        handover_demo(arguments.cube, arguments.options, giver, taker), arguments, panel
    )


def shelf(
    arguments: DemoArguments = DemoArguments(),
    description: DescriptionConfig = DescriptionConfig(),
    second: str | None = None,
    panel: PanelOptions = PanelOptions(),
) -> int:
    """Pick a cube from a shelf, and place it in a bin behind a wall.

    All motions, including those that carry the cube, are planned around the obstacles.
    Only friction holds the cube.  The arm must have at least the reach of a UR5.  For
    the panel, repetitions and the exit status, see `demo pick`.

    Args:
        second: A second robot, which blocks the space above the bin: ARM or
            ARM+GRIPPER.  The second robot moves aside while the first robot carries the
            cube; the two motions are planned together.
    """
    _check_files(arguments)
    from tool0.cli.demos.setup import shelf_demo

    return _run(
        shelf_demo(arguments.cube, arguments.options, description, second),
        arguments,
        panel,
    )


demo = {"pick": pick, "handover": handover, "shelf": shelf}


def _check_files(arguments: DemoArguments) -> None:
    if arguments.report is not None and arguments.report == arguments.video:
        raise ConfigError(f"--report and --video are one file, {arguments.report}")
    if arguments.report is not None:
        require_writable(arguments.report)
    if arguments.video is not None:
        from tool0.recording.video_writer import require_encoder

        require_encoder(arguments.video)


def _run(what: Demo, arguments: DemoArguments, panel: PanelOptions) -> int:
    from tool0.api.bringup import bringup

    simulation = SimulationConfig(
        engine=arguments.engine,
        grasp_assist=arguments.grasp_assist,
        scene=what.scene,
        realtime=not arguments.headless,
    )
    with contextlib.ExitStack() as exits:
        exits.enter_context(quiet_overruns())
        robot = exits.enter_context(
            bringup(description=what.description, simulation=simulation)
        )
        if arguments.video is not None:
            robot.camera(arguments.camera).image()
        if not arguments.headless:
            _show(robot, panel, exits)
        report = _play(robot, what, arguments)
        _print_report(report, arguments)
        while not arguments.headless and _wants_replay():
            robot.reset()
            again = replace(arguments, video=None, report=None)
            _print_report(_play(robot, what, again), again)
    return OK if report.n_succeeded == len(report.picks) else GOAL_FAILED


def _show(robot: Robot, options: PanelOptions, exits: contextlib.ExitStack) -> None:
    """Serve the panel, and wait until a web page shows the robot."""
    from tool0.cli.panel import listening, show
    from tool0.panel.server import Panel

    endpoint = exits.enter_context(listening(options))
    panel = exits.enter_context(Panel(robot, endpoint=endpoint))
    print(panel_line(panel.url), file=sys.stderr)
    if show(panel.url, options, sys.stderr) is None:
        print("It starts when a browser shows that page.", file=sys.stderr, flush=True)
    if not panel.await_page(PAGE_TIMEOUT):
        text = (
            f"No page has shown the robot within {PAGE_TIMEOUT:.0f} s; it starts now."
        )
        print(text, file=sys.stderr, flush=True)


def _wants_replay() -> bool:
    """Wait for Enter or Ctrl-C while the panel is running; return True after Enter."""
    from tool0.cli.stop_signal import StopSignal

    sources: list[StopSignal | TextIO] = []
    text = "The panel stays open; Ctrl-C ends it."
    if sys.stdin.isatty():
        sources.append(sys.stdin)
        text = "The panel stays open: Enter repeats the demo, Ctrl-C ends it."
    with StopSignal() as stop:
        print(text, file=sys.stderr, flush=True)
        select.select([stop, *sources], [], [])
        return not stop.is_set and sys.stdin.readline() != ""


def _play(robot: Robot, what: Demo, arguments: DemoArguments) -> DemoReport:
    from tool0.cli.demos.monitor import FrameRecorder

    recorder = FrameRecorder()

    def on_snapshot(snapshot: Snapshot) -> None:
        if arguments.video is not None:
            recorder.record(snapshot)

    report = what.play(
        robot,
        arguments.n,
        seed=arguments.seed,
        on_snapshot=on_snapshot,
        on_pick=(lambda pick: None) if arguments.as_json else _print_pick,
    )
    if arguments.video is None:
        return report
    with ProgressBar() as progress:
        recorder.write(arguments.video, robot, arguments.camera, progress)
    return replace(report, video=str(arguments.video))


def _print_pick(pick: PickReport) -> None:
    print(pick.to_text(), flush=True)


def _print_report(report: DemoReport, arguments: DemoArguments) -> None:
    if arguments.as_json:
        print_json(report.to_json())
    else:
        print(report.to_text(), flush=True)
    if arguments.report is not None:
        _write(arguments.report, report)


def _write(path: Path, report: DemoReport) -> None:
    text = json.dumps(finite(report.to_json()), allow_nan=False, indent=2)
    try:
        path.write_text(text + "\n")
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None
