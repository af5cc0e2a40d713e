"""controller_manager's spawner, in any namespace."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

from ros import TIMEOUT, Ros, system_python

SPAWNER = """
import sys
import rospy
from controller_manager_msgs.srv import *

def manager(name, kind):
    rospy.wait_for_service("controller_manager/" + name, timeout=30)
    return rospy.ServiceProxy("controller_manager/" + name, kind)

def shut_down():
    switch([], names, SwitchControllerRequest.STRICT, False, 0.0)
    for name in reversed(names):
        unload(name)

rospy.init_node("spawner", anonymous=True)
load = manager("load_controller", LoadController)
switch = manager("switch_controller", SwitchController)
unload = manager("unload_controller", UnloadController)
rospy.on_shutdown(shut_down)
names = [name for name in sys.argv[1:] if load(name).ok]
if switch(names, [], SwitchControllerRequest.STRICT, False, 0.0).ok:
    # Not loginfo, which asks the master: Ctrl-C during that blocks rospy for good.
    print("Started controllers:", ", ".join(names), flush=True)
rospy.spin()
"""
"""For machines without the package controller_manager: the calls that its makes."""


@contextlib.contextmanager
def spawned(ros: Ros, *controllers: str, namespace: str = "/") -> Iterator[None]:
    """Run the spawner in a namespace; enter once its controllers run, end by Ctrl-C."""
    prefixes = os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    found = (Path(prefix, "lib/controller_manager/spawner") for prefix in prefixes)
    real = next((str(path) for path in found if path.is_file()), None)
    command = [real] if real else [system_python(), "-c", SPAWNER]
    with subprocess.Popen(
        [*command, *controllers],
        env={**ros.tools, "ROS_NAMESPACE": namespace},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as spawner:
        try:
            assert spawner.stdout is not None
            assert any("Started controllers" in line for line in spawner.stdout)
            yield
            spawner.send_signal(signal.SIGINT)
            spawner.communicate(timeout=TIMEOUT)
        finally:
            spawner.kill()
    assert spawner.returncode == 0
