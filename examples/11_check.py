"""Find mistakes in a controllers' YAML file without starting a simulation."""

from pathlib import Path
from tempfile import TemporaryDirectory

import tool0

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
    report = tool0.check([file])
for finding in report.findings:
    print(f"line {finding.location.line}, {finding.severity}: {finding.text}")
print(f"errors: {report.n_errors}, warnings: {report.n_warnings}")
