"""The environment as an `Env` of brax, for its PPO and SAC.

    pip install brax==0.14.2 "jax<0.8"       # the PPO of this version calls functions that later versions of JAX do not have
    python examples/walk/brax_env.py --steps 20e6
"""

import argparse

import jax
import jax.numpy as jnp
from brax.envs.base import Env, State
from brax.training.agents.ppo import networks, train
from environment import EPISODE, Walk
from train import BATCHES, DISCOUNT, DIVERGENCE, ENTROPY, HIDDEN, HORIZON, PASSES


class WalkBrax(Env):
    """One world, which brax's wrappers make many. A reset draws it from `worlds` worlds. The wrappers also end episodes."""

    def __init__(self, worlds=1024, seed=0):
        self.environment = Walk()
        self._worlds = self.environment.worlds(seed, worlds)

    def _world(self, index):
        """Returns one world, with a leading axis of length 1."""
        differ = self._worlds._replace(starts=None)
        return jax.tree.map(lambda x: x[index][None], differ)._replace(starts=self._worlds.starts)

    def _observe(self, world, state, key):
        seen = jax.tree.map(lambda x: x[0], self.environment.observe(world, state, key))
        return {"state": seen.actor, "privileged_state": seen.critic}

    def reset(self, rng):
        own, index, first, noise = jax.random.split(rng, 4)
        index = jax.random.randint(index, (), 0, len(self._worlds.friction))
        world = self._world(index)
        state = self.environment.reset(first, world)
        zero = jnp.zeros(())
        rewards = jax.eval_shape(self.environment.step, world, state, jnp.zeros((1, self.action_size)), first).rewards
        metrics = {name: zero for name in rewards}
        return State(state, self._observe(world, state, noise), zero, zero, metrics, {"key": own, "world": index})

    def step(self, state, action):
        key, own, noise = jax.random.split(state.info["key"], 3)
        world = self._world(state.info["world"])
        after = self.environment.step(world, state.pipeline_state, action[None], own)
        return state.replace(
            pipeline_state=after.final,
            obs=self._observe(world, after.final, noise),
            reward=after.reward[0],
            done=after.fell[0].astype(float),
            metrics=state.metrics | {name: reward[0] for name, reward in after.rewards.items()},
            info=state.info | {"key": key},
        )

    @property
    def observation_size(self):
        return {"state": (self.environment.actor,), "privileged_state": (self.environment.critic,)}

    @property
    def action_size(self):
        return self.environment.actions

    @property
    def backend(self):
        return "modyn"


def make_networks(*sizes, **named):
    """Returns networks of the sizes of `train.py`, whose critic has the privileged observations."""
    hidden = {"policy_hidden_layer_sizes": HIDDEN, "value_hidden_layer_sizes": HIDDEN}
    return networks.make_ppo_networks(*sizes, **hidden, value_obs_key="privileged_state", **named)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=float, default=20e6, help="the control steps of all worlds together")
    parser.add_argument("--worlds", type=int, default=1024)
    given = parser.parse_args()
    show = lambda steps, metrics: print(steps, {k: float(v) for k, v in metrics.items() if k.startswith("eval/episode_reward")}, flush=True)
    train.train(
        WalkBrax(given.worlds), round(given.steps), num_envs=given.worlds, episode_length=EPISODE, unroll_length=HORIZON,
        batch_size=given.worlds // BATCHES, num_minibatches=BATCHES, num_updates_per_batch=PASSES, learning_rate=1e-3,
        learning_rate_schedule="ADAPTIVE_KL", learning_rate_schedule_max_lr=3e-3, desired_kl=DIVERGENCE, discounting=DISCOUNT,
        entropy_cost=ENTROPY, num_evals=10, network_factory=make_networks, progress_fn=show,
    )


if __name__ == "__main__":
    main()
