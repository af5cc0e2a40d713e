"""Check, run, pause, resume and export a program of steps from a file."""

import tempfile
from pathlib import Path

import tool0

PICK = """
name: pick
tool: {xyz: [0, 0, 0.1418]}   # between the pads, in the flange
steps:
  - {kind: gripper, opening: open}
  - kind: move_joint
    pose: {xyz: [0.5487, 0.1091, 0.2], rpy: [180deg, 0, 0]}
    blend: 0.03
  - kind: move_linear
    pose: {xyz: [0.5487, 0.1091, 0.0025], rpy: [180deg, 0, 0]}
  - {kind: gripper, opening: closed, force: 40, must_hold: true}
  - kind: move_linear
    pose: {xyz: [0.5487, 0.1091, 0.2], rpy: [180deg, 0, 0]}
    blend: 0.05
  - kind: move_joint
    pose: {xyz: [0.50, -0.32, 0.2], rpy: [180deg, 0, 0]}
  - {kind: comment, text: it falls into the bin}
  - {kind: gripper, opening: 0.07}
  - {kind: move_joint, named_pose: home}
"""

with (
    tool0.bringup(arm="ur5e", scene="table_and_bin", realtime=False) as robot,
    tempfile.TemporaryDirectory() as folder,
):
    file = Path(folder, "pick.yaml")
    file.write_text(PICK)

    # The program is checked before the arm moves.
    for problem in robot.programs.check(file).problems:
        print(problem)

    program = robot.run_program(file)
    robot.run(1.0)
    program.pause()
    robot.run(0.5)
    print(program.status.state, "in step", program.status.step)
    program.resume()
    print(program.wait().state)

    script = robot.programs.export(file, "urscript")
    print(script.splitlines()[1])
