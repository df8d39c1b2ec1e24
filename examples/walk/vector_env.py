"""The environment as a Gymnasium `VectorEnv` on NumPy's arrays, for Stable-Baselines3, CleanRL or skrl.

    python examples/walk/vector_env.py             # steps per second under random actions
"""

import time

import gymnasium
import jax
import numpy as np
from environment import Walk


class WalkVector(gymnasium.vector.VectorEnv):
    """Worlds whose episodes begin again in the step in which they end. `info["final_obs"]` holds the observations before."""

    metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.SAME_STEP}

    def __init__(self, num_envs=1024):
        self.num_envs, self.environment = num_envs, Walk()
        box = lambda count: gymnasium.spaces.Box(-np.inf, np.inf, (count,), np.float32)
        self.single_observation_space, self.single_action_space = box(self.environment.actor), box(self.environment.actions)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self._reset, self._step = jax.jit(self._first), jax.jit(self._after)

    def _first(self, worlds, key):
        state = self.environment.reset(key, worlds)
        return state, self.environment.observe(worlds, state).actor

    def _after(self, worlds, state, actions, key):
        own, noise = jax.random.split(key)
        after = self.environment.step(worlds, state, actions, own)
        seen, final = self.environment.observe(worlds, after.state, noise), self.environment.observe(worlds, after.final)
        return after, seen.actor, final.actor

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        seed = int(self.np_random.integers(2**31))
        self._worlds, self._key = self.environment.worlds(seed, self.num_envs), jax.random.key(seed)
        self._state, seen = self._reset(self._worlds, self._key)
        return np.asarray(seen), {}

    def step(self, actions):
        self._key, key = jax.random.split(self._key)
        after, seen, final = self._step(self._worlds, self._state, np.asarray(actions, np.float32), key)
        self._state = after.state
        ended = np.asarray(after.fell | after.timed_out)
        info = {"final_obs": np.asarray(final), "_final_obs": ended, "rewards": {k: np.asarray(x) for k, x in after.rewards.items()}}
        return np.asarray(seen), np.asarray(after.reward), np.asarray(after.fell), np.asarray(after.timed_out), info


if __name__ == "__main__":
    walk = WalkVector()
    walk.reset(seed=0)
    actions = [0.3 * np.random.default_rng(k).normal(size=walk.action_space.shape) for k in range(4)]
    walk.step(actions[0])
    began = time.perf_counter()
    for k in range(100):
        walk.step(actions[k % 4])
    print(f"{100 * walk.num_envs / (time.perf_counter() - began):,.0f} steps of worlds per second")
