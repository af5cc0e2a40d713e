"""What is wrong with a YAML of controllers, found before anything is run."""

from pathlib import Path
from tempfile import TemporaryDirectory

from tool0.lint.check import check

YAML = """\
gripper_controller:
  type: effort_controllers/JointTrajectoryController
  joints: [finger_joint]
  gains:
    finger_jont: {p: 10, d: 0.1, i: 1, i_clamp: 1}
  stall_timeout: 1.0
"""

with TemporaryDirectory() as folder:
    file = Path(folder, "controllers.yaml")
    file.write_text(YAML, encoding="utf-8")
    report = check([file])
for finding in report.findings:
    print(f"line {finding.location.line}, {finding.severity}: {finding.text}")
print(f"{report.n_errors} errors, {report.n_warnings} warnings")
