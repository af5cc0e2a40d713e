"""Train PPO of Stable-Baselines3 on a vector environment, and print its progress.

pip install '.[gym]' stable-baselines3
python train_reach.py
"""

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecMonitor, VecNormalize

import tool0.gym  # noqa: F401  # registers the tasks

STEPS = 60_000


class Copies(VecEnv):
    """A vector environment of tool0, as Stable-Baselines3 wants it."""

    def __init__(self, task: str, num_envs: int, **options: object) -> None:
        self.env = gymnasium.make_vec(
            task, num_envs=num_envs, autoreset_mode="SameStep", **options
        )
        spaces = self.env.single_observation_space, self.env.single_action_space
        super().__init__(num_envs, *spaces)

    def reset(self) -> np.ndarray:
        seeds = list(self._seeds)
        self._reset_seeds()
        return self.env.reset(seed=seeds)[0]

    def step_async(self, actions: np.ndarray) -> None:
        self.actions = actions

    def step_wait(self) -> tuple:
        state, reward, terminated, truncated, infos = self.env.step(self.actions)
        done = terminated | truncated
        each = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(done):
            each[i]["terminal_observation"] = infos["final_obs"][i]
            each[i]["TimeLimit.truncated"] = bool(truncated[i] and not terminated[i])
            each[i]["is_success"] = bool(infos["final_info"]["is_success"][i])
        return state, reward, done, each

    def close(self) -> None:
        self.env.close()

    def get_attr(self, name: str, indices: object = None) -> list:
        return [getattr(self.env, name, None)] * self.num_envs

    def set_attr(self, name: str, value: object, indices: object = None) -> None:
        raise NotImplementedError("the copies have no attributes of their own")

    def env_method(self, name: str, *args: object, **options: object) -> list:
        raise NotImplementedError("the copies have no methods of their own")

    def env_is_wrapped(self, wrapper: type, indices: object = None) -> list[bool]:
        return [False] * self.num_envs


class Progress(BaseCallback):
    """Prints steps, success rate and mean return of the last hundred episodes."""

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        done = self.model.ep_success_buffer
        if done:
            returned = np.mean([one["r"] for one in self.model.ep_info_buffer])
            rate = np.mean(done)
            print(f"{self.num_timesteps},{rate:.3f},{returned:.2f}", flush=True)


if __name__ == "__main__":
    torch.set_num_threads(1)  # the physics needs the processors
    env = VecNormalize(
        VecMonitor(Copies("tool0/Reach-v0", 32, dt=0.002)), norm_reward=False
    )
    model = PPO(
        "MlpPolicy",
        env,
        n_steps=32,
        batch_size=256,
        learning_rate=1e-3,
        gamma=0.95,
        seed=0,
        device="cpu",
        policy_kwargs={"net_arch": [64, 64]},
    )
    model.learn(STEPS, callback=Progress())
    env.close()
