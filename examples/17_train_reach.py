"""Train a linear policy for Reach with evolution: `pip install '.[gym]'`.

The strategy is the cross-entropy method.  The strategy tries 24 policies in parallel,
each on the same two goals, and draws the next policies around the best policies.
"""

import gymnasium
import numpy as np

import tool0.gym  # noqa: F401  # registers the tasks

POLICIES, GOALS, ELITES, GENERATIONS = 24, 2, 6, 8
STEPS, N = 25, POLICIES * GOALS
ENVS = gymnasium.make_vec(
    "tool0/Reach-v0",
    num_envs=N,
    action="joint",
    control_rate=10,
    dt=0.002,
    autoreset_mode="Disabled",
    terminate_on_success=False,
)
PARTS = ENVS.unwrapped.state_slices


def run(weights: np.ndarray, seeds: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean reward and last success of each copy, for weights (N, 7, 4)."""
    state, info = ENVS.reset(seed=seeds)
    total, bias = np.zeros(N), np.full((N, 1), 0.5)
    for _ in range(STEPS):
        features = np.concatenate([5.0 * state[:, PARTS["to_goal"]], bias], axis=1)
        action = np.einsum("nij,nj->ni", weights, features)
        state, reward, _, _, info = ENVS.step(action.clip(-1.0, 1.0))
        total += reward / STEPS
    return total, info["is_success"]


def success_rate(weights: np.ndarray) -> float:
    """Return the success rate of a policy for goals that were not in its training."""
    seeds = list(range(10_000, 10_000 + N))
    return float(run(np.tile(weights, (N, 1, 1)), seeds)[1].mean())


rng = np.random.default_rng(0)
mean, spread = np.zeros((7, 4)), np.ones((7, 4))
print(f"success before: {success_rate(mean):.0%}")
for generation in range(GENERATIONS):
    tried = mean + spread * rng.standard_normal((POLICIES, 7, 4))
    goals = [generation * GOALS + k for k in range(GOALS)]
    reward, _ = run(np.repeat(tried, GOALS, axis=0), goals * POLICIES)
    score = reward.reshape(POLICIES, GOALS).mean(axis=1)
    print(f"generation {generation}: mean reward {score.mean():.3f}")
    best = tried[np.argsort(score)[-ELITES:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
print(f"success after: {success_rate(mean):.0%}")
ENVS.close()
