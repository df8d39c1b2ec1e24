"""Robots, and how each is to walk."""

from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
#: The commands of an evaluation: the velocities forwards and to the left (m/s), and the turning rate (rad/s).
ASKED = [(0, 0, 0), (0.5, 0, 0), (0.7, 0, 0), (1.0, 0, 0), (-0.4, 0, 0), (0, 0.25, 0), (0, 0, 0.6), (0.5, 0, 0.6)]
#: The least and the largest commands of a training.
COMMANDS = [[-0.5, -0.3, -0.8], [1.0, 0.3, 0.8]]


@dataclass(frozen=True)
class Task:
    """A robot with a floor, position actuators and a keyframe `stand`, and how it is to walk."""

    robot: Path
    #: the link that carries a load, and the largest load, kg
    trunk: str
    load: float
    #: the links of the feet, and how far the soles are below their frames, m
    feet: tuple
    sole: float
    #: the weight of each joint's deviation from the posture, for the joints of the first actuators, which the policy moves; other
    #: actuators hold the posture
    posture: tuple
    #: the offset of the targets from the posture for an action of 1, rad
    action: float
    #: the height of the base that is rewarded, and below which the robot has fallen, m
    height: float
    fallen: float
    #: the steps of a foot per second, the part of the period in which it swings, and how high it is lifted (m)
    frequency: float
    swing: float
    lift: float
    #: the part of the period at which each foot begins to swing
    phases: tuple
    #: the offset of the targets of a leg in the middle of its swing, before any action, rad
    lifted: tuple
    #: the offsets of the targets of a leg that is ahead, per unit of each number of a command, (3, joints of a leg): rad s/m and s
    stride: tuple
    #: the share of the narrow kernel in the rewards for velocities, which only small errors get
    exact: float
    #: what each reward counts, per second
    rewards: dict


QUADRUPED = Task(
    robot=HERE / "quadruped.xml",
    trunk="trunk",
    load=0.4,
    feet=tuple(f"{end}_{side}_foot" for end in ("front", "hind") for side in ("left", "right")),
    sole=0.016,
    posture=(1.0, 0.3, 0.3) * 4,
    action=0.4,
    height=0.24,
    fallen=0.12,
    frequency=2.5,
    swing=0.5,
    lift=0.045,
    phases=(0.0, 0.5, 0.5, 0.0),
    lifted=(0.0, 0.0, 0.0),
    stride=((0.0, 0.0, 0.0),) * 3,
    exact=0.8,
    rewards={
        "tracking_lin_vel": 3.0,
        "tracking_ang_vel": 1.2,
        "gait": 2.0,
        "feet_clearance": 0.8,
        "alive": 0.3,
        "lin_vel_z": -1.0,
        "ang_vel_xy": -0.05,
        "orientation": -4.0,
        "base_height": -100.0,
        "torques": -0.02,
        "action_rate": -0.03,
        "pose": -0.8,
        "feet_slip": -0.3,
    },
)

HUMANOID = Task(
    robot=HERE / "humanoid.xml",
    trunk="torso_link",
    load=3.0,
    feet=("left_ankle_roll_link", "right_ankle_roll_link"),
    sole=0.035,
    #: of each leg: the hip's pitch, roll and yaw, the knee, the ankle's pitch and roll
    posture=(0.1, 0.5, 0.5, 0.1, 0.1, 0.3) * 2,
    action=0.3,
    height=0.76,
    fallen=0.5,
    frequency=1.5,
    swing=0.45,
    lift=0.08,
    phases=(0.0, 0.5),
    lifted=(-0.35, 0.0, 0.0, 0.7, -0.35, 0.0),
    stride=((-0.26, 0.0, 0.0, 0.0, 0.26, 0.0), (0.0, 0.26, 0.0, 0.0, 0.0, -0.26), (0.0, 0.0, 0.25, 0.0, 0.0, 0.0)),
    exact=0.6,
    rewards=QUADRUPED.rewards
    | {
        "tracking_lin_vel": 5.0,
        "tracking_ang_vel": 3.0,
        "feet_clearance": 1.5,
        "alive": 0.5,
        "lin_vel_z": -0.5,
        "base_height": -20.0,
        "torques": -0.0001,
        "action_rate": -0.02,
    },
)

TASKS = {"quadruped": QUADRUPED, "humanoid": HUMANOID}
