"""A robot that learns to walk: many worlds as functions of JAX on modyn's steps. The leading axis counts worlds.

The methods `worlds`, `reset`, `step` and `observe` of `Walk` keep no state, so JAX can compile and scan them.
"""

import warnings
from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import modyn
import modyn.jax
import numpy as np
from tasks import COMMANDS, QUADRUPED

#: The time between two actions, s, and the steps of the simulation in it.
CONTROL, STEPS = 0.02, 5
#: The tolerance of the solver in training, relative to the weight and the largest force. The default is 1e-4.
TOLERANCE = 5e-3
#: In control steps: an episode, the time of a command, and the time between two pushes.
EPISODE, COMMAND, PUSH = 500, 200, 100


class Gait(NamedTuple):
    """How high each foot should be, from 0 on the ground to 1, and how far ahead of the hip, from -1 to 1: (..., feet) each."""

    lift: jax.Array
    ahead: jax.Array


class Feet(NamedTuple):
    """The heights of the feet above the ground, (..., feet), m; their velocities along it, (..., feet, 2), m/s; their forces on it, N."""

    heights: jax.Array
    velocities: jax.Array
    forces: jax.Array


class State(NamedTuple):
    """The states of worlds."""

    q: jax.Array
    qd: jax.Array
    qdd: jax.Array
    feet: Feet
    command: jax.Array
    action: jax.Array
    #: the part of the gait's period that has passed
    phase: jax.Array
    #: the control steps since the episode began
    time: jax.Array


class Worlds(NamedTuple):
    """What differs between worlds and stays."""

    settings: jax.Array
    #: of the ground
    friction: jax.Array
    #: on the trunk: (..., 10), as `modyn.jax.parameters` has it
    payload: jax.Array
    #: of the actuators, in steps of the simulation
    delay: jax.Array
    #: the states from which episodes begin
    starts: State


class Observation(NamedTuple):
    """What the actor knows; and the critic, which is only needed while the actor learns: no noise, and what robots do not measure."""

    actor: jax.Array
    critic: jax.Array


class Transition(NamedTuple):
    """What follows an action."""

    #: the state, which is a new one where an episode has ended
    state: State
    #: the state in which the action ended, before an episode begins again
    final: State
    reward: jax.Array
    #: the rewards by name, per second
    rewards: dict
    #: whether the episode ended by a fall, or by its time
    fell: jax.Array
    timed_out: jax.Array


def square(x):
    return (x * x).sum(-1)


def down(q):
    """Returns the direction of gravity in the axes of the trunk."""
    x, y, z, w = jnp.moveaxis(q[..., 3:7], -1, 0)
    return -jnp.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1)


class Walk:
    """The task: to walk at a commanded velocity."""

    def __init__(self, task=QUADRUPED, scalar="f32", randomize=True):
        self.task, self.randomize = task, randomize
        with warnings.catch_warnings():
            # The friction of the joints acts in steps only, as it should here.
            warnings.simplefilter("ignore", modyn.DescriptionWarning)
            feet = [(function, foot) for function in ("link_pose", "link_velocity") for foot in task.feet]
            self.robot = modyn.load(task.robot, scalar=scalar, payload=[task.trunk], fused={"feet": feet})
        self.dt = self.robot.time_step
        self.stand = jnp.asarray(self.robot.keyframe("stand").q, self.robot.dtype)
        self.motion = modyn.jax.rollout(self.robot, step="actuated")
        self.actuate = modyn.jax.function(self.robot, "actuate")
        self.feet_motion = modyn.jax.function(self.robot, "feet")

    @property
    def actions(self):
        """The number of actuators that the policy moves."""
        return len(self.task.posture)

    @property
    def actor(self):
        """The number of values that the actor observes."""
        return 11 + 2 * (self.robot.nv - 6) + self.actions

    @property
    def critic(self):
        """The number of values that the critic observes."""
        return self.actor + 6 + 2 * len(self.task.feet)

    def worlds(self, seed, count, starts=4096):
        """Returns worlds that differ in friction, softness of the ground, load and delay, unless `randomize` is false."""
        rng = np.random.default_rng(seed)
        friction, payload = np.full(count, 0.7), np.zeros((count, 10))
        solref, delay = np.tile([0.02, 1.0], (count, 1)), np.zeros(count, int)
        if self.randomize:
            friction, solref[:, 0] = rng.uniform(0.4, 1.0, count), rng.uniform(0.008, 0.03, count)
            payload[:, :3] = self.task.load * rng.uniform([0, -0.075, -0.075], [1, 0.075, 0.075], (count, 3))
            delay = rng.integers(0, 4, count)
        settings = self.robot.step_settings()
        surfaces = [replace(surface, friction=friction, solref=solref) for surface in settings.surfaces]
        q = np.zeros((starts, 1)) + np.asarray(self.stand)
        yaw = rng.uniform(-np.pi, np.pi, starts) / 2
        q[:, 5], q[:, 6] = np.sin(yaw), np.cos(yaw)
        q[:, 7:] += rng.uniform(-0.1, 0.1, q[:, 7:].shape)
        array = lambda x: jnp.asarray(x, self.stand.dtype)
        begins = jax.jit(self.start)(array(q), array(rng.uniform(-0.2, 0.2, (starts, self.robot.nv))))
        settings = replace(settings, surfaces=surfaces, tolerance=TOLERANCE if self.randomize else None)
        return Worlds(array(settings), array(friction), array(payload), jnp.asarray(delay), begins)

    def start(self, q, qd):
        """Returns states that begin at coordinates and velocities, with a command to stand."""
        zeros = lambda *shape: jnp.zeros((len(q), *shape), q.dtype)
        feet = self.feet(q, qd, zeros(len(self.task.feet)))
        return State(q, qd, jnp.zeros_like(qd), feet, zeros(3), zeros(self.actions), zeros(), jnp.zeros(len(q), int))

    def feet(self, q, qd, forces):
        motion, count = self.feet_motion(q, qd), len(self.task.feet)
        heights = jnp.stack([pose.translation[..., 2] for pose in motion[:count]], -1) - self.task.sole
        return Feet(heights, jnp.stack([velocity[..., :2] for velocity in motion[count:]], -2), forces)

    def reset(self, key, worlds):
        """Returns the first states of episodes, one for each world."""
        count = len(worlds.friction)
        keys = jax.random.split(key, 3)
        states = jax.tree.map(lambda x: x[jax.random.randint(keys[0], (count,), 0, len(worlds.starts.q))], worlds.starts)
        phase = jax.random.uniform(keys[1], (count,))
        return states._replace(command=self.command(keys[2], count), phase=phase)

    def command(self, key, count):
        """Returns velocity commands; one in ten is to stand."""
        velocity, walks = jax.random.split(key)
        low, high = jnp.asarray(COMMANDS, self.stand.dtype)
        return jax.random.uniform(velocity, (count, 3), low.dtype, low, high) * (jax.random.uniform(walks, (count, 1)) > 0.1)

    def gait(self, phase):
        """Returns where the feet should be: each swings, then stands."""
        part = (phase[:, None] + jnp.array(self.task.phases)) % 1
        swing, stance = part / self.task.swing, (part - self.task.swing) / (1 - self.task.swing)
        lift = jnp.where(swing < 1, jnp.sin(jnp.pi * swing) ** 2, 0)
        return Gait(lift, jnp.where(swing < 1, -jnp.cos(jnp.pi * swing), jnp.cos(jnp.pi * stance)))

    def targets(self, phase, command, action):
        """Returns the targets of all actuators for an action."""
        gait = self.gait(phase)
        lifted = gait.lift[..., None] * jnp.array(self.task.lifted)
        ahead = gait.ahead[..., None] * (command[:, None] @ jnp.array(self.task.stride))
        offsets = (lifted + ahead).reshape(action.shape) + self.task.action * action
        return self.stand[7:] + jnp.pad(offsets, ((0, 0), (0, self.robot.nv - 6 - self.actions)))

    def advance(self, worlds, state, action):
        """Returns the states after an action of CONTROL seconds, and which feet are on the ground after each step, (..., STEPS, feet)."""
        acts = (jnp.arange(STEPS) >= worlds.delay[:, None])[..., None]
        new = self.targets(state.phase, state.command, action)
        old = self.targets(state.phase - self.task.frequency * CONTROL, state.command, state.action)
        controls = jnp.where(acts, new[:, None], old[:, None])
        own = {"settings": worlds.settings, "parameters": {"payload": {self.task.trunk: worlds.payload}}}
        motion = self.motion(state.q, state.qd, controls, self.dt, warm_start=state.qdd, **own)
        q, qd, qdd = (x[:, -1] for x in (motion.q, motion.qd, motion.qdd))
        # The points that touch the ground are in the order of the feet.
        forces = motion.forces[..., 2].reshape(len(q), STEPS, len(self.task.feet), -1).sum(-1)
        after = state._replace(
            q=q, qd=qd, qdd=qdd, feet=self.feet(q, qd, forces[:, -1]), action=action,
            phase=(state.phase + self.task.frequency * CONTROL) % 1, time=state.time + 1,
        )
        return after, forces > 0

    def observe(self, worlds, state, key=None):
        """Returns the observations. If there is a key, the actor's has noise."""
        clock = 2 * jnp.pi * state.phase[:, None]
        joints = self.robot.nv - 6
        measured = [state.qd[:, 3:6], down(state.q), state.q[:, 7:] - self.stand[7:], state.qd[:, 6:]]
        known = [state.command, state.action, jnp.sin(clock), jnp.cos(clock)]
        joined = lambda turn, down, angles, rates: jnp.concatenate([turn * 0.25, down, angles, rates * 0.05, *known], -1)
        exact = noisy = joined(*measured)
        if key is not None:
            scales = (3, 0.05), (3, 0.03), (joints, 0.02), (joints, 0.05), (self.actions + 5, 0.0)
            noise = jnp.concatenate([jnp.full(count, scale) for count, scale in scales])
            noisy = exact + noise * jax.random.uniform(key, exact.shape, minval=-1, maxval=1)
        hidden = [
            state.qd[:, :3], state.feet.forces > 0, state.feet.heights * 10, worlds.friction[:, None], worlds.payload[:, :1],
            (state.q[:, 2:3] - self.task.height) * 10,
        ]
        return Observation(noisy, jnp.concatenate([exact, *hidden], -1))

    def rewards(self, before, state, touched):
        """Returns the rewards of a control step by name."""
        task = self.task
        # The wide kernel shows a robot that stands which way to go, the narrow one makes it exact.
        tracking = lambda error: (1 - task.exact) * jnp.exp(-error / 0.5) + task.exact * jnp.exp(-error / 0.05)
        lift = self.gait(state.phase).lift
        swings = lift > 0
        torques = self.actuate(state.q, state.qd, self.targets(before.phase, before.command, state.action), self.dt).tau[..., 6:]
        linear, angular, feet = state.qd[:, :3], state.qd[:, 3:6], state.feet
        on_ground = feet.forces > 0
        rewards = {
            "tracking_lin_vel": tracking(square(linear[:, :2] - state.command[:, :2])),
            "tracking_ang_vel": tracking((angular[:, 2] - state.command[:, 2]) ** 2),
            "gait": jnp.where(swings, 1 - touched, touched).mean(-1),
            "feet_clearance": jnp.where(swings, jnp.exp(-((feet.heights / task.lift - lift) ** 2) * 4), 1.0).mean(-1),
            "alive": jnp.ones(len(swings)),
            "lin_vel_z": linear[:, 2] ** 2,
            "ang_vel_xy": square(angular[:, :2]),
            "orientation": square(down(state.q)[:, :2]),
            "base_height": (state.q[:, 2] - task.height) ** 2,
            "torques": square(torques),
            "action_rate": square(state.action - before.action),
            "pose": square((state.q - self.stand)[:, 7 : 7 + self.actions] * jnp.array(task.posture)),
            "feet_slip": (on_ground * square(feet.velocities)).sum(-1),
        }
        return {name: task.rewards[name] * value for name, value in rewards.items()}

    def step(self, worlds, state, action, key):
        """Returns what follows actions of one control step. Episodes that end begin again."""
        count = len(action)
        command, reset, push = jax.random.split(key, 3)
        after, touched = self.advance(worlds, state, action)
        rewards = self.rewards(state, after, touched.mean(1))
        broken = ~jnp.isfinite(after.q).all(-1) | (jnp.abs(after.qd[:, :6]) > 30).any(-1)
        fell = (down(after.q)[:, 2] > -0.6) | (after.q[:, 2] < self.task.fallen) | broken
        reward = jnp.where(fell, -1.0, CONTROL * jnp.maximum(sum(rewards.values()), 0))
        new_command = (after.time % COMMAND == 0)[:, None]
        pushed = (after.time % PUSH == PUSH // 2)[:, None] if self.randomize else False
        kick = jnp.where(pushed, jax.random.uniform(push, (count, 2), minval=-0.3, maxval=0.3), 0.0)
        after = after._replace(
            qd=after.qd.at[:, :2].add(kick), command=jnp.where(new_command, self.command(command, count), after.command)
        )
        timed_out = (after.time >= EPISODE) & ~fell
        ended = fell | timed_out
        choose = lambda new, old: jnp.where(ended.reshape(-1, *(1,) * (old.ndim - 1)), new, old)
        states = jax.tree.map(choose, self.reset(reset, worlds), after)
        return Transition(states, after, reward, rewards, fell, timed_out)
