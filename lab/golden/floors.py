"""Steps of MuJoCo on planes: random robots of an MJCF with geoms of all kinds, contacts of one to six components, both cones, joint
limits, dry friction, damping, closed loops, fixed tendons, couplings of joints and tendons, and all settings in general position.
"""

import mujoco
import numpy
import standing

STEP = 0.002
ROBOTS = 48
#: The robots with closed loops.
LOOPS = range(24, 32)
#: The first robot with tendons and couplings, and the first one whose couplings are linear: modyn has soft ones of independent joints.
TENDONS = 32
LINEAR = 44
STATES = 4
KINDS = ("sphere", "capsule", "box", "cylinder", "ellipsoid")
#: The power of all curves of impedance: contacts mix those of two geoms, and modyn has integers.
POWER = 3
SIZES = {"sphere": 1, "capsule": 2, "box": 3, "cylinder": 2, "ellipsoid": 3}


def numbers(values):
    return " ".join(f"{x:.6g}" for x in numpy.atleast_1d(values))


def softness(rng, reference="solref", impedance="solimp"):
    least, most = sorted(rng.uniform(0.7, 0.97, 2))
    curve = [least, most, rng.uniform(0.001, 0.02), rng.uniform(0.3, 0.7), POWER]
    direct = rng.random() < 0.2
    pair = [-rng.uniform(300, 3000), -rng.uniform(10, 80)] if direct else [rng.uniform(0.01, 0.05), rng.uniform(0.7, 1.3)]
    return f'{reference}="{numbers(pair)}" {impedance}="{numbers(curve)}"'


def contact(rng):
    friction = [rng.uniform(0.2, 1.2), rng.uniform(0.005, 0.1), rng.uniform(0.005, 0.1)]
    return (f'condim="{rng.choice([1, 3, 4, 6])}" friction="{numbers(friction)}" priority="{rng.integers(0, 2)}" '
            f'solmix="{numbers(rng.uniform(0.5, 2.0))}" margin="{numbers(rng.uniform(0.0, 0.02))}" {softness(rng)}')


def turned(rng):
    quaternion = rng.normal(size=4)
    return f'quat="{numbers(quaternion / numpy.linalg.norm(quaternion))}"'


def geom(rng, kind):
    size = rng.uniform(0.04, 0.15, SIZES[kind])
    return (f'<geom type="{kind}" size="{numbers(size)}" pos="{numbers(rng.uniform(-0.1, 0.1, 3))}" {turned(rng)} '
            f'contype="2" conaffinity="1" {contact(rng)}/>')


def joint(rng):
    kind = rng.choice(["hinge", "slide"])
    lower, upper = sorted(rng.uniform(-0.8, 0.8, 2)) if kind == "hinge" else sorted(rng.uniform(-0.1, 0.1, 2))
    friction = rng.uniform(0.0, 0.5) * (rng.random() < 0.5)
    return (f'<joint type="{kind}" axis="{numbers(rng.normal(size=3))}" pos="{numbers(rng.uniform(-0.05, 0.05, 3))}" '
            f'range="{numbers([lower, upper])}" armature="{numbers(rng.uniform(0, 0.05))}" '
            f'damping="{numbers(rng.uniform(0, 0.5))}" frictionloss="{numbers(friction)}" margin="{numbers(rng.uniform(0, 0.02))}" '
            f'{softness(rng, "solreflimit", "solimplimit")} {softness(rng, "solreffriction", "solimpfriction")}/>')


def named(rng, body):
    """The text of bodies whose joints have names, and the names. Coordinates and springs have references."""
    first, *rest = body.split("<joint ")
    references = [f'ref="{numbers(rng.uniform(-0.2, 0.2))}" springref="{numbers(rng.uniform(-0.2, 0.2))}"' for _ in rest]
    joints = [f'<joint name="j{i}" {reference} {joint}' for i, (reference, joint) in enumerate(zip(references, rest))]
    return first + "".join(joints), [f"j{i}" for i in range(len(rest))]


def tendon(rng, name, joints, k):
    """A fixed tendon of these joints. Every other one has a narrow range, so that both limits act."""
    low, high = numpy.sort(rng.uniform(-0.3, 0.3, 2)) if k % 2 else sorted(0.01 * rng.normal() + rng.uniform(-0.005, 0.005, 2))
    rest = [f'springlength="{numbers(numpy.sort(rng.uniform(-0.2, 0.2, 2)))}"', f'springlength="{numbers(rng.normal())}"', ""][k % 3]
    parts = "".join(f'<joint joint="{joint}" coef="{numbers(rng.normal())}"/>' for joint in joints)
    return (f'<fixed name="{name}" range="{numbers([low, high])}" margin="{numbers(rng.uniform(0, 0.02))}" '
            f'frictionloss="{numbers(rng.uniform(0, 0.5) * (k % 4 != 1))}" {softness(rng, "solreflimit", "solimplimit")} '
            f'{softness(rng, "solreffriction", "solimpfriction")} stiffness="{numbers(rng.uniform(0, 20) * (k % 5 > 1))}" '
            f'damping="{numbers(rng.uniform(0, 1) * (k % 5 != 2))}" {rest}>{parts}</fixed>')


def tendons(rng, joints, k):
    """One or two tendons of all joints, and couplings: by polynomials, or of more than two joints. Robots without couplings have
    limits and friction only, or only a spring."""
    second = list(rng.permutation(joints))[: 1 + k % len(joints)]
    fixed = tendon(rng, "t0", joints, k) + tendon(rng, "t1", second, k + 1)
    curve = f'polycoef="{numbers(rng.normal(size=5) * [0.1, 1, 1, 1, 1])}" {softness(rng)}'
    by_joints = f'<joint joint1="{joints[0]}" joint2="{joints[-1]}" {curve}/>'
    single = f'<joint joint1="{joints[0]}" joint2="{joints[1]}" {curve}/>' if len(joints) < 3 else f'<tendon tendon1="t0" {curve}/>'
    if k >= LINEAR:
        line = f'polycoef="{numbers(rng.normal(size=2) * [0.1, 1])}" {softness(rng)}'
        pair = f'<joint joint1="{joints[0]}" joint2="{joints[-1]}" {line}/>'
        held = f'<joint joint1="{joints[-1]}" polycoef="{numbers(0.1 * rng.normal())}" {softness(rng)}/>'
        tied = f'<tendon tendon1="t0" tendon2="t1" {line}/>'
        return f"<tendon>{fixed}</tendon><equality>{[pair, held, tied, pair + held][k % 4]}</equality>"
    couplings = ["", by_joints, f'<tendon tendon1="t0" tendon2="t1" {curve}/>', single][k % 4]
    return f"<tendon>{fixed}</tendon><equality>{couplings}</equality>"


def pair(rng):
    """A pair with the settings of its own: the base and the floor touch, whatever their masks say."""
    friction = rng.uniform(0.2, 1.0, 2), rng.uniform(0.005, 0.1, 3)
    # MuJoCo's pyramids have a friction for each tangent, modyn's have one.
    friction = [friction[0][0], friction[0][0], friction[1][0], friction[1][1], friction[1][1]]
    return (f'<pair geom1="floor" geom2="base_geom" condim="{rng.choice([3, 4, 6])}" friction="{numbers(friction)}" '
            f'margin="{numbers(rng.uniform(0.0, 0.02))}" {softness(rng)}/>')


def closures(rng, k):
    """A loop between two limbs, or the base and its limb, and one between a limb and the world, by points or welds."""
    def constraint(name, first, second, weld):
        anchor = f'anchor="{numbers(rng.uniform(-0.1, 0.1, 3))}"'
        scale = f'torquescale="{numbers(rng.uniform(0.2, 2.0))}"' * weld
        return f'<{name} body1="{first}" body2="{second}" {anchor} {scale} {softness(rng)}/>'

    kinds = ["connect", "weld"] if k % 2 else ["weld", "connect"]
    first = "limb0" if k % 3 else "base"
    inner = constraint(kinds[0], first, f"limb{k % 3}", kinds[0] == "weld")
    outer = constraint(kinds[1], "limb0", "world", kinds[1] == "weld") * (k % 4 == 1)
    return f"<equality>{inner}{outer}</equality>"


def free(rng, k):
    """The joint of the base, which has damping and armature in the robots with closed loops."""
    if k not in LOOPS:
        return "<freejoint/>"
    return f'<joint type="free" damping="{numbers(rng.uniform(0, 0.5))}" armature="{numbers(rng.uniform(0, 0.2))}"/>'


def overriding(rng):
    """Settings of all contacts, which replace those of the geoms."""
    slide, spin, roll = rng.uniform(0.2, 1.0), *rng.uniform(0.005, 0.1, 2)
    return (f'o_margin="{numbers(rng.uniform(0.0, 0.02))}" o_friction="{numbers([slide, slide, spin, roll, roll])}" '
            f'{softness(rng, "o_solref", "o_solimp")}')


def scene(rng, k):
    """The text of a robot over a plane: a free body, and limbs of one or two links."""
    kinds = [KINDS[(k + i) % len(KINDS)] for i in range(6)]
    limbs = ""
    for i in range(1 + k % 3):
        inner = f"<body pos='{numbers(rng.uniform(-0.2, 0.2, 3))}'>{joint(rng)}{geom(rng, kinds[2 * i])}</body>" * (i != 1)
        limbs += f"<body name='limb{i}' pos='{numbers(rng.uniform(-0.3, 0.3, 3))}' {turned(rng)}>{joint(rng)}{geom(rng, kinds[2 * i + 1])}{inner}</body>"
    limbs, joints = named(rng, limbs) if k >= TENDONS else (limbs, [])
    rotation = numpy.array(standing.rotation(rng.normal(size=3), rng.uniform(0, 0.6)))
    floor = (f'<geom name="floor" type="plane" size="0 0 1" pos="{numbers(rng.uniform(-0.3, 0.3, 3))}" '
             f'quat="{numbers(rotation)}" contype="1" conaffinity="2" {contact(rng)}/>')
    cone = "elliptic" if k % 2 else "pyramidal"
    base = geom(rng, kinds[0]).replace("<geom", '<geom name="base_geom"')
    # Every fourth robot has a pair in place of masks, the next one a body that does not touch the floor, the next one settings of
    # all contacts.
    kind = k % 4
    contacts = f"<contact>{pair(rng)}</contact>" if kind == 1 else ""
    base = base.replace('contype="2"', 'contype="0"').replace('conaffinity="1"', 'conaffinity="0"') if kind == 1 else base
    if kind == 2:
        contacts = '<contact><exclude body1="world" body2="limb0"/></contact>'
    option = overriding(rng) if kind == 3 else ""
    flag = '<flag override="enable"/>' if kind == 3 else ""
    return (f'<mujoco model="floor {k}"><compiler angle="radian"/><option cone="{cone}" impratio="{numbers(rng.uniform(0.5, 4))}" '
            f"{option}>{flag}</option><worldbody>{floor}<body name='base'>{free(rng, k)}{base}{limbs}</body></worldbody>{contacts}"
            f"{closures(rng, k) if k in LOOPS else ''}{tendons(rng, joints, k) if k >= TENDONS else ''}</mujoco>")


def to_modyn(qpos, qvel):
    """Coordinates and velocities in modyn's order: quaternions x y z w, linear velocities in the axes of the base."""
    x, y, z, w, qx, qy, qz = qpos[:7]
    linear = standing.matrix(qpos[3:7]).T @ qvel[:3]
    return [float(a) for a in [x, y, z, qx, qy, qz, w, *qpos[7:]]], [float(a) for a in [*linear, *qvel[3:]]]


def robot(rng, k):
    text = scene(rng, k)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    model.opt.timestep, model.opt.tolerance, model.opt.ls_tolerance = STEP, 0.0, 1e-12
    model.opt.iterations, model.opt.ls_iterations = 300, 100
    normal = standing.matrix(model.geom("floor").quat)[:, 2]
    found = {"mjcf": text, "step": STEP, "states": []}
    while len(found["states"]) < STATES:
        mujoco.mj_resetData(model, data)
        base = rng.normal(size=4)
        data.qpos[3:7] = base / numpy.linalg.norm(base)
        data.qpos[7:] = rng.normal(size=model.nq - 7) * 0.3
        data.qvel[:] = rng.normal(size=model.nv)
        data.qpos[:3] = model.geom("floor").pos + normal * rng.uniform(0.0, 0.3)
        tau = [0.0] * 6 + [float(x) for x in rng.normal(size=model.nv - 6)]
        q, qd = to_modyn(data.qpos, data.qvel)
        data.qfrc_applied[:] = tau
        mujoco.mj_step(model, data)
        if data.ncon == 0:
            continue
        next_q, next_qd = to_modyn(data.qpos, data.qvel)
        found["states"].append({"q": q, "qd": qd, "tau": tau, "next_q": next_q, "next_qd": next_qd, "contacts": int(data.ncon),
                                "rows": int(data.nefc)})
    return found


def make(_root):
    rng = numpy.random.default_rng(11)
    return [robot(rng, k) for k in range(ROBOTS)]
