"""A new task, which `tool0 collect --task 29_own_task.py:Coaster-v0` can also use."""

import math
from dataclasses import replace

import gymnasium
import numpy as np

import tool0.gym
from tool0.scene import Cylinder, Pose, SceneObject

DISC, ASIDE = Cylinder(radius=0.04, length=0.01), Pose(xyz=(0.5, 0.5, 0.0))
COASTER = SceneObject(name="coaster", geometry=DISC, pose=ASIDE, mass=0.2)


class Coaster(tool0.gym.Task):
    """A task to put a cube on a coaster.  Arrays have one row for each copy."""

    instruction = "Put the cube on the coaster."
    objects, goal_names = ("cube", "coaster"), ("x", "y", "z", "released")

    def scene(self):
        """Return a scene with the table, a cube and a coaster."""
        table = self.workspace.scene(("cube",))
        return replace(table, objects=(*table.objects, COASTER))

    def draw(self, rng):
        """Return a random start with places [m], yaws [rad] and the goal."""
        places = self.workspace.draw_on_table(rng, 2, lambda p: math.dist(*p) > 0.13)
        places[1, 2] += (0.01 - self.workspace.edge) / 2
        goal = [*places[1, :2], places[0, 2] + 0.01, 1.0]
        return tool0.gym.Start(places, rng.uniform(-3.1, 3.1, 2), np.array(goal))

    def achieved(self, state):
        """Return the cube's position, and whether the gripper has released the cube."""
        released = state.opening > self.workspace.edge + 0.006
        return np.column_stack([state.object_position[:, 0], released])

    def is_success(self, achieved, desired):
        """Return whether the released cube is on the coaster."""
        away = np.abs(achieved - desired)
        return (away[..., :2].max(axis=-1) < 0.02) & (away[..., 2:] < 0.004).all(-1)

    def expert(self, state, commanded):
        """Return the expert's next target."""
        return tool0.gym.place(self.workspace, state, commanded, self.desired(state))


tool0.gym.register("Coaster-v0", Coaster, max_episode_steps=200)

if __name__ == "__main__":
    env = gymnasium.make("Coaster-v0", arm="ur5e")
    expert = tool0.gym.expert(env)
    state, _ = env.reset(seed=0)
    steps, terminated = 0, False
    while not terminated:
        state, reward, terminated, *_ = env.step(expert(state))
        steps += 1
    print(f"solved in {steps} steps")
