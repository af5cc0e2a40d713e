"""A task of your own: put the cube on a coaster.  Also for `tool0 collect`:

tool0 collect --task examples/29_own_task.py:Coaster-v0 --episodes 20
"""

import math
from dataclasses import replace

import gymnasium
import numpy as np

import tool0.gym
from tool0.scene import Cylinder, SceneObject

THICKNESS, RADIUS = 0.01, 0.04


class Coaster(tool0.gym.Task):
    """Functions of the state of all copies: arrays with one row per copy."""

    instruction = "Put the cube on the coaster."
    objects = ("cube", "coaster")
    goal_names = ("x", "y", "z", "released")

    def scene(self):
        """Return the table and a cube, and a coaster beside it."""
        table = self.workspace.scene(("cube",))
        coaster = SceneObject(
            name="coaster",
            geometry=Cylinder(radius=RADIUS, length=THICKNESS),
            mass=0.2,
        )
        return replace(table, objects=(*table.objects, coaster))

    def draw(self, rng):
        """Return a random start: places [m], yaws [rad] and the goal."""
        places = self.workspace.draw_on_table(rng, 2, lambda p: math.dist(*p) > 0.13)
        places[1, 2] += (THICKNESS - self.workspace.edge) / 2
        goal = [*places[1, :2], places[0, 2] + THICKNESS, 1.0]
        return tool0.gym.Start(places, rng.uniform(-3.1, 3.1, 2), np.array(goal))

    def achieved(self, state):
        """Return where the cube is, and whether the gripper has let go of it."""
        released = state.opening > self.workspace.edge + 0.006
        return np.column_stack([state.object_position[:, 0], released])

    def is_success(self, achieved, desired):
        """Return whether it is on the coaster."""
        away = np.abs(achieved - desired)
        return (away[..., :2].max(axis=-1) < 0.02) & (away[..., 2:] < 0.004).all(-1)

    def expert(self, state, commanded):
        """Return where to go next."""
        return tool0.gym.place(self.workspace, state, commanded, self.desired(state))


tool0.gym.register("Coaster-v0", Coaster, max_episode_steps=200)

if __name__ == "__main__":
    envs = gymnasium.make_vec("Coaster-v0", num_envs=8, arm="ur5e")
    expert = tool0.gym.expert(envs)
    state, info = envs.reset(seed=0)
    solved = np.zeros(8, bool)
    for _ in range(120):
        state, reward, terminated, truncated, info = envs.step(expert(state))
        solved |= terminated
    print(f"{solved.sum()} of 8 solved; {len(state[0])} numbers in an observation")
    envs.close()
