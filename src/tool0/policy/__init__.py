"""Execute policies in episodes of a task or on a running robot.

::

    from tool0.policy import evaluate

    report = evaluate("my_policy.py:Policy", "Lift", range(100))
    print(report.success_rate, report.interval)
"""

from __future__ import annotations

from tool0.policy.chunks import ChunkOptions
from tool0.policy.evaluation import evaluate, execute
from tool0.policy.report import Report, wilson
from tool0.policy.robot_environment import RobotEnvironment
from tool0.policy.running import EpisodeRun, RunOptions

__all__ = [
    "ChunkOptions",
    "EpisodeRun",
    "Report",
    "RobotEnvironment",
    "RunOptions",
    "evaluate",
    "execute",
    "wilson",
]
