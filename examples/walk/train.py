"""Trains a robot to walk by PPO (Schulman et al. 2017), with one compiled program per iteration.

    python examples/walk/train.py --steps 30e6 --out policy.npz
    python examples/walk/train.py --check          # a short training, whose return has to rise
"""

import argparse
import sys
import time
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax
from environment import CONTROL, EPISODE, Observation, State, Walk, Worlds
from tasks import TASKS

#: The steps of each world and the passes over them in an iteration; the parts of a pass.
HORIZON, PASSES, BATCHES = 24, 4, 4
DISCOUNT, TRACE, CLIP, ENTROPY = 0.98, 0.95, 0.2, 0.004
#: The change of the policy (Kullback-Leibler divergence) that the learning rate is to give.
DIVERGENCE = 0.02
#: The iterations of a check.
CHECK = 40
#: The sizes of the layers of both networks.
HIDDEN = 128, 128
OPTIMIZER = optax.chain(optax.clip_by_global_norm(1.0), optax.scale_by_adam())


class Layer(NamedTuple):
    weights: jax.Array
    bias: jax.Array


class Policy(NamedTuple):
    """The network of the actor, the logarithm of the standard deviation of its actions, and the network of the critic."""

    actor: list
    log_std: jax.Array
    critic: list


class Learner(NamedTuple):
    """What learning changes."""

    policy: Policy
    optimizer: optax.OptState
    rate: jax.Array
    key: jax.Array


class Episodes(NamedTuple):
    """What acting changes: the states of worlds, and what the policy has seen of them."""

    worlds: Worlds
    state: State
    seen: Observation
    key: jax.Array


class Sample(NamedTuple):
    """What is learnt from: (steps, worlds, ..) each."""

    seen: Observation
    action: jax.Array
    mean: jax.Array
    log_probability: jax.Array
    value: jax.Array
    advantage: jax.Array


class Progress(NamedTuple):
    """Means over the steps of an iteration; the return is per second."""

    returns: jax.Array
    falls: jax.Array
    rewards: dict


def network(key, sizes, scale):
    """Returns the layers of a network with orthogonal weights. The weights of the last layer are multiplied by `scale`."""
    scales = [2**0.5] * (len(sizes) - 2) + [scale]
    keys = jax.random.split(key, len(scales))
    weights = [jax.nn.initializers.orthogonal(s)(k, shape) for k, s, shape in zip(keys, scales, zip(sizes, sizes[1:]))]
    return [Layer(w, jnp.zeros(w.shape[1])) for w in weights]


def output(layers, x):
    """Returns what a network makes of inputs."""
    for layer in layers[:-1]:
        x = jnp.tanh(x @ layer.weights + layer.bias)
    return x @ layers[-1].weights + layers[-1].bias


def log_probability(mean, log_std, action):
    return -(0.5 * ((action - mean) / jnp.exp(log_std)) ** 2 + log_std + 0.5 * np.log(2 * np.pi)).sum(-1)


def start(environment, key):
    """Returns a learner that knows nothing."""
    actor_key, critic_key, key = jax.random.split(key, 3)
    actor = network(actor_key, (environment.actor, *HIDDEN, environment.actions), 0.01)
    critic = network(critic_key, (environment.critic, *HIDDEN, 1), 1.0)
    policy = Policy(actor, jnp.full(environment.actions, -0.7, jnp.float32), critic)
    return Learner(policy, OPTIMIZER.init(policy), jnp.float32(1e-3), key)


def begin(environment, key, worlds):
    """Returns first episodes, which end at different times."""
    state_key, time_key, key = jax.random.split(key, 3)
    state = environment.reset(state_key, worlds)
    state = state._replace(time=jax.random.randint(time_key, state.time.shape, 0, EPISODE))
    return Episodes(worlds, state, environment.observe(worlds, state), key)


def collect(environment, policy, episodes):
    """Lets the policy act for HORIZON steps; returns the episodes, samples and the progress."""
    worlds = episodes.worlds

    def act(carry, key):
        state, seen = carry
        keys = jax.random.split(key, 3)
        mean = output(policy.actor, seen.actor)
        action = mean + jnp.exp(policy.log_std) * jax.random.normal(keys[0], mean.shape)
        after = environment.step(worlds, state, action, keys[1])
        final = environment.observe(worlds, after.final).critic
        kept = seen, action, mean, final, after._replace(state=None, final=None)
        return (after.state, environment.observe(worlds, after.state, keys[2])), kept

    key, own = jax.random.split(episodes.key)
    (state, seen), kept = jax.lax.scan(act, (episodes.state, episodes.seen), jax.random.split(own, HORIZON))
    before, action, mean, final, after = kept
    value, value_after = (output(policy.critic, x)[..., 0] for x in (before.critic, final))

    def backwards(advantage, step):
        value, value_after, reward, fell, timed_out = step
        error = reward + DISCOUNT * value_after * ~fell - value
        advantage = error + DISCOUNT * TRACE * advantage * ~(fell | timed_out)
        return advantage, advantage

    steps = (value, value_after, after.reward, after.fell, after.timed_out)
    advantage = jax.lax.scan(backwards, jnp.zeros(value.shape[1]), steps, reverse=True)[1]
    sample = Sample(before, action, mean, log_probability(mean, policy.log_std, action), value, advantage)
    average = {name: reward.mean() for name, reward in after.rewards.items()}
    progress = Progress(after.reward.mean() / CONTROL, after.fell.mean(), average)
    return Episodes(worlds, state, seen, key), sample, progress


def loss(policy, sample, old_log_std, spread):
    """Returns the loss of PPO, and the divergence of the policy from the one that acted."""
    mean = output(policy.actor, sample.seen.actor)
    ratio = jnp.exp(log_probability(mean, policy.log_std, sample.action) - sample.log_probability)
    advantage = (sample.advantage - spread[0]) / spread[1]
    gain = jnp.minimum(ratio * advantage, jnp.clip(ratio, 1 - CLIP, 1 + CLIP) * advantage).mean()
    target = sample.value + sample.advantage
    value = output(policy.critic, sample.seen.critic)[..., 0]
    clipped = sample.value + jnp.clip(value - sample.value, -CLIP, CLIP)
    error = jnp.maximum((value - target) ** 2, (clipped - target) ** 2).mean()
    variance = jnp.exp(2 * old_log_std) + (sample.mean - mean) ** 2
    divergence = (policy.log_std - old_log_std + variance / (2 * jnp.exp(2 * policy.log_std)) - 0.5).sum(-1).mean()
    return error - gain - ENTROPY * policy.log_std.sum(), divergence


def learn(learner, sample):
    """Returns the learner after PASSES over the samples."""
    old_log_std = learner.policy.log_std
    spread = sample.advantage.mean(), sample.advantage.std() + 1e-8

    def update(carry, worlds):
        policy, optimizer, rate = carry
        part = jax.tree.map(lambda x: x[:, worlds].reshape(-1, *x.shape[2:]), sample)
        gradient, divergence = jax.grad(loss, has_aux=True)(policy, part, old_log_std, spread)
        factor = jnp.where(divergence > 2 * DIVERGENCE, 1 / 1.5, jnp.where(divergence < DIVERGENCE / 2, 1.5, 1.0))
        rate = jnp.clip(rate * factor, 1e-5, 3e-3)
        change, optimizer = OPTIMIZER.update(gradient, optimizer)
        policy = jax.tree.map(lambda x, by: x - rate * by, policy, change)
        return (policy._replace(log_std=jnp.clip(policy.log_std, -2.5, 0.3)), optimizer, rate), None

    key, own = jax.random.split(learner.key)
    count = sample.value.shape[1]
    order = [jax.random.permutation(k, count).reshape(BATCHES, -1) for k in jax.random.split(own, PASSES)]
    (policy, optimizer, rate), _ = jax.lax.scan(update, (learner.policy, learner.optimizer, learner.rate), jnp.concatenate(order))
    return Learner(policy, optimizer, rate, key)


def prepare(environment, seed, count):
    """Returns a learner that knows nothing, and the first episodes of as many worlds."""
    learner_key, episodes_key = jax.random.split(jax.random.key(seed))
    worlds = environment.worlds(seed, count)
    episodes = jax.jit(lambda key, worlds: begin(environment, key, worlds))(episodes_key, worlds)
    return start(environment, learner_key), episodes


def iteration(environment):
    """Returns a function of a learner and its episodes: what they are after acting and learning, and the progress."""

    @jax.jit
    def iterate(learner, episodes):
        episodes, sample, progress = collect(environment, learner.policy, episodes)
        return learn(learner, sample), episodes, progress

    return iterate


def save(path, policy):
    """Writes the actor."""
    layers = {f"{name}_{k}": np.asarray(x) for k, layer in enumerate(policy.actor) for name, x in layer._asdict().items()}
    np.savez(path, **layers)


def load(path):
    """Reads the actor in double precision."""
    found = np.load(path)
    return [Layer(found[f"weights_{k}"].astype(float), found[f"bias_{k}"].astype(float)) for k in range(len(found) // 2)]


def show(progress, learner, seconds, steps):
    """Prints a line."""
    rewards = ", ".join(f"{name} {float(reward):.2f}" for name, reward in progress.rewards.items())
    std = float(jnp.exp(learner.policy.log_std).mean())
    print(
        f"{seconds:5.0f} s, {steps / 1e6:5.2f} M steps, {steps / seconds:,.0f}/s: return {float(progress.returns):.2f}, "
        f"falls {float(progress.falls):.4f}, std {std:.2f}, rate {float(learner.rate):.0e}; {rewards}",
        flush=True,
    )


def check(returns):
    """Ends the program, with an error if the returns of a short training did not rise."""
    first, last = np.mean(returns[:5]), np.mean(returns[-5:])
    print(f"return of a second: {first:.2f} at first, {last:.2f} after {len(returns) - 1} iterations")
    sys.exit(None if last > first + 0.3 else "the return did not rise by 0.3")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--task", choices=TASKS, default="quadruped")
    parser.add_argument("--steps", type=float, default=30e6, help="the control steps of all worlds together")
    parser.add_argument("--worlds", type=int, default=1024)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", default="policy.npz", help="the file of the policy")
    parser.add_argument("--check", action="store_true", help="fail if the return of a short training does not rise")
    given = parser.parse_args()
    environment = Walk(TASKS[given.task])
    iterate, began = iteration(environment), time.perf_counter()
    learner, episodes, progress = jax.block_until_ready(iterate(*prepare(environment, given.seed, given.worlds)))
    print(f"compiled in {time.perf_counter() - began:.1f} s", flush=True)
    began, returns = time.perf_counter(), [float(progress.returns)]
    iterations = CHECK if given.check else round(given.steps / (given.worlds * HORIZON))
    while len(returns) <= iterations:
        learner, episodes, progress = iterate(learner, episodes)
        returns.append(float(progress.returns))
        if len(returns) % 20 == 0:
            show(progress, learner, time.perf_counter() - began, len(returns) * given.worlds * HORIZON)
            if not given.check:
                save(given.out, learner.policy)
    if given.check:
        check(returns)
    save(given.out, learner.policy)


if __name__ == "__main__":
    main()
