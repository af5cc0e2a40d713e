"""The request handlers of a simulation, one function for each kind of request."""

from tool0.simulation.handlers import arm as arm
from tool0.simulation.handlers import arm_motion as arm_motion
from tool0.simulation.handlers import control_box as control_box
from tool0.simulation.handlers import gripper as gripper
from tool0.simulation.handlers import hardware as hardware
from tool0.simulation.handlers import motion as motion
from tool0.simulation.handlers import objects as objects
from tool0.simulation.handlers import planning as planning
from tool0.simulation.handlers import program as program
from tool0.simulation.handlers import reproduction as reproduction
from tool0.simulation.handlers import sensors as sensors
from tool0.simulation.handlers import state as state
from tool0.simulation.handlers import stream_watch as stream_watch
