"""``tool0 replay``: show a recording in the panel."""

from __future__ import annotations

import contextlib
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tool0.cli.options import PanelOptions
from tool0.cli.panel import listening, show
from tool0.cli.parameters import AsJson, Option
from tool0.cli.stop_signal import StopSignal
from tool0.cli.text import ProgressBar, columns, counted, panel_line, print_json
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.cli.outputs import ComparisonOutput
    from tool0.recording.reading import RecordingFile
    from tool0.recording.resimulation import Resimulation
    from tool0.recording.simulated_run import SimulatedRun


def replay(
    file: Annotated[Path, Option(is_positional=True)],
    *,
    speed: float = 1.0,
    loop: bool = False,
    simulate: bool = False,
    compare: bool = False,
    as_json: AsJson = False,
    panel: PanelOptions = PanelOptions(),
) -> int:
    """Show a recording with a timeline in a web page.

    Args:
        file: The recording, an MCAP file.
        speed: Speed of the playback: recorded seconds per second of wall time.
        loop: Start again at the beginning when the recording ends.
        simulate: Simulate the recording again without a web page, and compare every
            frame bit by bit.  The exit status is 1 if a frame differs.
        compare: Simulate the recorded requests in MuJoCo, and print the differences
            between the recorded and the simulated motion.  The plots show both motions;
            the simulated motion is dashed.
        as_json: With --simulate or --compare, print one JSON object and exit.
    """
    if as_json and not (simulate or compare):
        raise ConfigError("--json needs --simulate or --compare")
    if simulate and compare:
        raise ConfigError("give --simulate or --compare, not both")
    from tool0.panel.replay.view import Replay
    from tool0.panel.server import Panel
    from tool0.recording.reading import open_recording

    recording = open_recording(file)
    if simulate:
        return _simulate(recording, as_json=as_json)
    beside = _simulated_beside(recording, as_json=as_json) if compare else None
    if as_json:
        return 0
    with contextlib.ExitStack() as exits:
        endpoint = exits.enter_context(listening(panel))
        stop = exits.enter_context(StopSignal())
        source = Replay(recording, beside)
        source.playhead.set_speed(speed)
        source.playhead.set_loops(loop)
        exits.enter_context(Panel(source, endpoint=endpoint))
        if not recording.is_complete:
            print(
                f"tool0: warning: {file} was cut off; its last whole part ends at "
                f"t = {recording.time[-1]:.2f} s",
                file=sys.stderr,
            )
        print(f"{panel_line(endpoint.url)}\nCtrl-C ends it.", flush=True)
        show(endpoint.url, panel, sys.stdout)
        stop.wait()
    return 0


def _simulate(recording: RecordingFile, *, as_json: bool) -> int:
    """Simulate a recording again, and print the differences; return the exit status."""
    from tool0.recording.resimulation import resimulate

    with ProgressBar(sys.stderr) as bar:
        outcome = resimulate(
            recording,
            lambda done, total: bar("simulating", done / total, f"{done}/{total}"),
        )
    if as_json:
        print_json({"is_identical": outcome.is_identical, **asdict(outcome)})
    else:
        _print_outcome(outcome, recording.duration)
    return 0 if outcome.is_identical else 1


def _simulated_beside(recording: RecordingFile, *, as_json: bool) -> SimulatedRun:
    """Simulate a recording's requests, and print how much the motions differ."""
    from tool0.recording.simulated_run import simulate_beside

    with ProgressBar(sys.stderr) as bar:
        run = simulate_beside(
            recording,
            lambda done, total: bar("simulating", done / total, f"{done}/{total}"),
        )
    if as_json:
        found: ComparisonOutput = {
            "lag": run.lag,
            "joints": run.joints,
            "notes": run.notes,
        }
        print_json(found)
        return run
    print(
        f"recorded ({recording.info.engine}) and simulated, {recording.duration:.2f} s;"
        f" the recorded arm is {1e3 * run.lag:.0f} ms later, which is taken out"
    )
    head = ("joint", "position rms", "most", "effort rms", "recorded effort")
    rows = [
        (
            name,
            f"{item.position_rms:.5f}",
            f"{item.position_most:.5f}",
            f"{item.effort_rms:.2f}",
            f"{item.recorded_effort:.2f}",
        )
        for name, item in run.joints.items()
    ]
    print(columns([head, *rows]), end="")
    for note in run.notes:
        print(f"note: {note}")
    return run


def _print_outcome(outcome: Resimulation, duration: float) -> None:
    if outcome.is_identical:
        print(
            f"identical: {counted(outcome.frames, 'frame')}, {duration:.2f} s, "
            f"{counted(outcome.requests, 'request')}"
        )
    else:
        print(f"different {outcome.divergence}")
        print(f"{outcome.frames} of {outcome.total_frames} frames before are identical")
    for reason in outcome.reasons:
        print(f"note: {reason}")
