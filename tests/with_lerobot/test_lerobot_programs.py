"""LeRobot's own programs with tool0's data sets, policies and robots.

``make test-lerobot`` runs this in an environment of its own: LeRobot needs another
Python.  The loop is closed once: collect, train, evaluate.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("lerobot.policies")

import tool0
from tool0.collect import collect
from tool0.policy import RunOptions, evaluate

pytestmark = pytest.mark.timeout(5400)
"""The training takes about 11 minutes of processor time."""

PROGRAMS = Path(sys.executable).parent
JOINT = "wrist_2_joint"
SMALL_ACT = (
    "--policy.type=act --policy.device=cpu --policy.push_to_hub=false "
    "--policy.use_vae=false --policy.chunk_size=10 --policy.n_action_steps=10 "
    "--num_workers=0 --wandb.enable=false"
)


@pytest.fixture(scope="module", autouse=True)
def settings(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep LeRobot's files here, and its connections on this machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HF_HUB_OFFLINE", "1")
        patch.setenv("HF_LEROBOT_HOME", str(tmp_path_factory.mktemp("lerobot")))
        patch.setenv("OMP_NUM_THREADS", "1")
        yield


def lerobot(program: str, line: str) -> str:
    """Run a program of LeRobot to its end, and return what it says."""
    done = subprocess.run(
        [PROGRAMS / program, *line.split()],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-3000:]
    return done.stdout


@contextmanager
def brought_up(name: str) -> Iterator[tool0.Robot]:
    """Bring up a robot in a process of its own; yield a connection."""
    words = [sys.executable, "-m", "tool0", "bringup", "--headless", "--name", name]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline()  # it says that it is ready
            with tool0.connect(name) as robot:
                yield robot
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(20.0)


def test_collect_train_evaluate(tmp_path: Path) -> None:
    collect("Lift", 200, tmp_path / "lift", format="lerobot")
    lerobot(
        "lerobot-train",
        f"{SMALL_ACT} --policy.dim_model=128 --policy.n_heads=4 "
        "--policy.dim_feedforward=256 --policy.n_encoder_layers=2 "
        "--policy.optimizer_lr=3e-4 --batch_size=64 --steps=4000 --save_freq=4000 "
        f"--dataset.repo_id=tool0/lift --dataset.root={tmp_path / 'lift'} "
        f"--output_dir={tmp_path / 'train'}",
    )
    policy = f"lerobot:{tmp_path / 'train/checkpoints/last/pretrained_model'}"
    seeds = range(100_000, 100_050)
    report = evaluate(policy, "Lift", seeds, run=RunOptions(clips=True))
    assert report.success_rate >= 0.8, report


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record an episode with LeRobot: a robot follows another one."""
    folder = tmp_path_factory.mktemp("recorded") / "set"
    with brought_up("leader") as leader, brought_up("follower") as follower:
        line = (
            "--robot.type=tool0 --robot.bringup=follower --robot.fps=10 "
            "--robot.camera_names=[wrist] --teleop.type=tool0_leader "
            f"--dataset.repo_id=me/set --dataset.root={folder} --dataset.fps=10 "
            "--dataset.num_episodes=1 --dataset.episode_time_s=12 "
            "--dataset.reset_time_s=1 --dataset.single_task=follow "
            "--dataset.push_to_hub=false --play_sounds=false --dataset.video=false"
        )
        words = [PROGRAMS / "lerobot-record", *line.split()]
        with subprocess.Popen(words) as recording:
            motion = follower.arm.motion
            assert follower.channel.wait_until(lambda: motion.state.mode != "free", 60)
            target = leader.joint_state.position[JOINT] + 0.6
            leader.move_joints({JOINT: target})[0].wait()
            assert follower.channel.wait_until(
                lambda: abs(follower.joint_state.position[JOINT] - target) < 0.01, 10
            )
            assert recording.wait(60) == 0
        assert follower.channel.wait_until(lambda: motion.state.mode == "free", 5)
    return folder


def test_a_robot_follows_its_leader_and_is_recorded(recorded: Path) -> None:
    info = json.loads((recorded / "meta/info.json").read_text())
    assert info["total_frames"] > 60
    assert f"{JOINT}.pos" in info["features"]["action"]["names"]
    assert info["features"]["observation.images.wrist"]["shape"][2] == 3


@pytest.mark.parametrize("program", ["teleoperate", "record"])
def test_a_gamepad_moves_the_tool(program: str, tmp_path: Path) -> None:
    line = (
        "--robot.type=tool0 --robot.bringup=jogged --robot.fps=20 "
        "--teleop.type=tool0_gamepad --teleop.bringup=jogged --teleop.speed=0.05"
    )
    if program == "teleoperate":
        line += " --fps=20 --teleop_time_s=4"
    else:
        line += (
            f" --dataset.repo_id=me/set --dataset.root={tmp_path / 'set'} "
            "--dataset.fps=20 --dataset.num_episodes=1 --dataset.episode_time_s=4 "
            "--dataset.single_task=push --dataset.push_to_hub=false "
            "--play_sounds=false"
        )
    code = (
        f"from lerobot.scripts.lerobot_{program} import main; "
        "from virtual_gamepad import push_forward_at_a_line as push; push(); main()"
    )
    words = [sys.executable, "-c", code, *line.split()]
    rigs = {"PYTHONPATH": os.pathsep.join(sys.path)}
    with brought_up("jogged") as robot:
        motion, before = robot.arm.motion, robot.arm.pose()
        with subprocess.Popen(
            words, stdin=subprocess.PIPE, text=True, env=os.environ | rigs
        ) as running:
            assert running.stdin is not None
            assert robot.channel.wait_until(lambda: motion.state.mode == "servo", 60)
            running.stdin.write("\n")
            running.stdin.flush()
            assert running.wait(60) == 0
        way = robot.arm.pose().matrix[:3, 3] - before.matrix[:3, 3]
    assert way[0] > 0.03
    assert max(abs(way[1:])) < 0.05 * way[0]
    if program == "record":
        info = json.loads((tmp_path / "set/meta/info.json").read_text())
        assert info["total_frames"] > 40
        assert f"{JOINT}.pos" in info["features"]["action"]["names"]


def test_a_policy_is_rolled_out_here_and_by_the_asynchronous_client(
    recorded: Path, tmp_path: Path
) -> None:
    lerobot(
        "lerobot-train",
        f"{SMALL_ACT} --policy.dim_model=64 --policy.n_heads=4 "
        "--policy.pretrained_backbone_weights=null --batch_size=2 --steps=3 "
        f"--save_freq=3 --dataset.repo_id=me/set --dataset.root={recorded} "
        f"--output_dir={tmp_path / 'train'}",
    )
    policy = tmp_path / "train/checkpoints/last/pretrained_model"
    robot_options = (
        "--robot.type=tool0 --robot.bringup=follower --robot.fps=10 "
        "--robot.camera_names=[wrist] --fps=10 --task=follow"
    )
    with brought_up("follower") as follower:
        before = follower.joint_state.position[JOINT]
        lerobot(
            "lerobot-rollout",
            f"--strategy.type=base --policy.path={policy} --policy.device=cpu "
            f"--return_to_initial_position=false --duration=4 {robot_options}",
        )
        assert abs(follower.joint_state.position[JOINT] - before) > 1e-3
        server = [sys.executable, "-m", "lerobot.async_inference.policy_server"]
        client = [sys.executable, "-m", "lerobot.async_inference.robot_client"]
        port = 20_000 + os.getpid() % 10_000
        client += (
            f"--server_address=127.0.0.1:{port} --policy_type=act "
            f"--pretrained_name_or_path={policy} --policy_device=cpu "
            f"--actions_per_chunk=10 {robot_options}"
        ).split()
        with subprocess.Popen([*server, "--host=127.0.0.1", f"--port={port}"]) as one:
            try:
                with subprocess.Popen(client) as two:
                    before = follower.joint_state.position[JOINT]
                    moved = follower.channel.wait_until(
                        lambda: (
                            abs(follower.joint_state.position[JOINT] - before) > 1e-3
                        ),
                        120,
                    )
                    two.kill()
            finally:
                one.kill()
        assert moved
        start = time.monotonic()  # the client was killed: the arm comes to rest
        assert follower.channel.wait_until(
            lambda: max(map(abs, follower.joint_state.velocity.values())) < 1e-3, 5
        )
        assert time.monotonic() - start < 5
