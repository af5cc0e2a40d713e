"""The handlers of a simulation: one function for each request of the contract."""

from tool0.requests import (
    arm as arm,
)
from tool0.requests import (
    arm_motion as arm_motion,
)
from tool0.requests import (
    control_box as control_box,
)
from tool0.requests import (
    gripper as gripper,
)
from tool0.requests import (
    hardware as hardware,
)
from tool0.requests import (
    motion as motion,
)
from tool0.requests import (
    objects as objects,
)
from tool0.requests import (
    program as program,
)
from tool0.requests import (
    sensors as sensors,
)
from tool0.requests import (
    state as state,
)
from tool0.requests import (
    stream_watch as stream_watch,
)
