"""Joint forces of MuJoCo's actuators and their activations after a step, for random models.

Each model is a chain of hinges and slides with two fixed tendons, and has an actuator of each kind that modyn reads. Their
attributes are random, also in classes. In one model, a joint follows another one by `<equality>`; its force is then that of the
leader times the multiplier.
"""

import mujoco
import numpy

MODELS = 10
STATES = 4
JOINTS = 6


def numbers(*values):
    return " ".join(f"{value:.6g}" for value in values)


class Maker:
    """Random parts of a model with these joints and tendons."""

    def __init__(self, rng, joints=tuple(f"j{k}" for k in range(JOINTS)), tendons=("t0", "t1")):
        self.rng, self.joints, self.tendons = rng, joints, tendons

    def maybe(self, text, chance=0.5):
        return text if self.rng.random() < chance else ""

    def pair(self, scale=1.0):
        return numbers(*numpy.sort(self.rng.uniform(-scale, scale, 2)))

    def around_zero(self, scale):
        return numbers(-self.rng.uniform(0.1, scale), self.rng.uniform(0.1, scale))

    def number(self, low, high):
        return numbers(self.rng.uniform(low, high))

    def body(self, k):
        rng = self.rng
        kind = "hinge" if rng.random() < 0.7 else "slide"
        axis = rng.normal(size=3)
        attributes = f'name="j{k}" type="{kind}" axis="{numbers(*axis)}" range="{self.pair(2)}" armature="{self.number(0, 0.3)}"'
        attributes += self.maybe(f' ref="{self.number(-0.5, 0.5)}"') + self.maybe(f' actuatorfrcrange="{self.pair(8)}"', 0.3)
        inside = self.body(k + 1) if k + 1 < JOINTS else ""
        return (f'<body pos="{numbers(*rng.normal(size=3))}"><joint {attributes}/>'
                f'<geom size="0.1" pos="{numbers(*rng.normal(size=3))}"/>{inside}</body>')

    def tendon(self, k):
        joints = "".join(f'<joint joint="j{j}" coef="{self.number(-2, 2)}"/>'
                         for j in self.rng.choice(JOINTS, 3, replace=False))
        return (f'<fixed name="t{k}" range="{self.pair(2)}"{self.maybe(f" actuatorfrcrange={chr(34)}{self.around_zero(4)}{chr(34)}")}>'
                f'{joints}</fixed>')

    def target(self):
        rng = self.rng
        if rng.random() < 0.7 or not self.tendons:
            return f'joint="{self.joints[rng.integers(len(self.joints))]}"'
        return f'tendon="{self.tendons[rng.integers(len(self.tendons))]}"'

    def common(self):
        return (self.maybe(f' gear="{self.number(-3, 3)}"') + self.maybe(f' forcerange="{self.pair(6)}"', 0.3)
                + self.maybe(f' group="{self.rng.integers(4)}"', 0.3) + self.maybe(' class="c"', 0.3))

    def activated(self):
        return self.maybe(f' actrange="{self.pair(1.5)}"')

    def control(self):
        return self.maybe(f' ctrlrange="{self.pair(2)}"')

    def servo(self):
        damping = self.rng.choice(["", f' kv="{self.number(0, 3)}"', f' dampratio="{self.number(0.1, 2)}"'])
        return self.maybe(f' kp="{self.number(0, 20)}"', 0.8) + damping

    def general(self):
        rng = self.rng
        gain, bias = rng.choice(["fixed", "affine"]), rng.choice(["none", "affine"])
        dynamics = rng.choice(["none", "integrator", "filter", "filterexact"])
        text = f' gaintype="{gain}" biastype="{bias}" dyntype="{dynamics}" gainprm="{numbers(*rng.normal(size=3))}"'
        text += f' biasprm="{numbers(*rng.normal(size=3))}" dynprm="{self.number(0.005, 0.1)}"' + self.control()
        return text + (self.activated() + self.maybe(' actearly="true"') if dynamics != "none" else "")

    def actuators(self):
        """The attributes of an actuator of each kind, by the name of its element."""
        inherited = f' inheritrange="{self.number(0.5, 1.2)}"'
        time = f' timeconst="{self.number(0.005, 0.1)}"'
        yield "motor", self.control()
        yield "position", self.servo() + self.control()
        yield "position", self.servo() + self.maybe(inherited)
        yield "position", self.servo() + self.control() + time
        yield "velocity", f' kv="{self.number(0, 5)}"' + self.control()
        yield "intvelocity", self.servo() + self.control() + self.activated()
        yield "intvelocity", self.servo() + inherited
        yield "damper", f' kv="{self.number(0, 5)}" ctrlrange="0 {self.number(0.5, 2)}"'
        yield "cylinder", f' area="{self.number(0.5, 2)}" bias="{numbers(*self.rng.normal(size=3))}"' + time
        yield "cylinder", f' diameter="{self.number(0.5, 2)}"' + self.control()
        for _ in range(4):
            yield "general", self.general()

    def classes(self):
        """Default classes. A class does not inherit a range that excludes the attributes of an actuator."""
        return (f'<default><general gear="{self.number(0.5, 2)}"/><default class="c">'
                f'<position kp="{self.number(1, 9)}" kv="{self.number(0, 2)}"/>'
                f'{self.maybe(f"<velocity forcerange={chr(34)}{self.pair(9)}{chr(34)}/>")}</default></default>')

    def section(self):
        """The actuators, in random order."""
        actuators = list(self.actuators())
        self.rng.shuffle(actuators)
        return "".join(f"<{name} {self.target()}{self.common()}{attributes}/>" for name, attributes in actuators)

    def model(self, equality=""):
        rng = self.rng
        clamped = self.maybe('<flag clampctrl="disable"/>', 0.2)
        classes, actuators = self.classes(), self.section()
        return (f'<mujoco model="m"><compiler angle="radian"/>'
                f'<option actuatorgroupdisable="{rng.integers(1, 4)}">{clamped}</option>{classes}'
                f'<worldbody>{self.body(0)}</worldbody><tendon>{self.tendon(0)}{self.tendon(1)}</tendon>{equality}'
                f'<actuator>{actuators}</actuator></mujoco>')


def states(rng, text, follows):
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = 0.004
    data = mujoco.MjData(model)
    found = []
    for _ in range(STATES):
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = rng.normal(size=model.nq).round(3), rng.normal(size=model.nv).round(3)
        if follows:
            data.qpos[4] = model.qpos0[4] + 0.25 + 1.5 * (data.qpos[1] - model.qpos0[1])
            data.qvel[4] = 1.5 * data.qvel[1]
        data.ctrl[:], data.act[:] = 2 * rng.normal(size=model.nu).round(3), rng.normal(size=model.na).round(3)
        before = {"q": data.qpos.tolist(), "qd": data.qvel.tolist(), "ctrl": data.ctrl.tolist(), "act": data.act.tolist()}
        mujoco.mj_step(model, data)
        tau = data.qfrc_actuator.copy()
        if follows:
            tau[1] += 1.5 * tau[4]
            tau = numpy.delete(tau, 4)
            before["q"].pop(4), before["qd"].pop(4)
        found.append({**before, "tau": tau.tolist(), "next_act": data.act.tolist()})
    return {"xml": text, "step": model.opt.timestep, "states": found}


def make(root):
    rng = numpy.random.default_rng(11)
    equality = '<equality><joint joint1="j4" joint2="j1" polycoef="0.25 1.5 0 0 0"/></equality>'
    models = []
    for k in range(MODELS):
        follows = k == 0
        models.append(states(rng, Maker(rng).model(equality if follows else ""), follows))
    return models
