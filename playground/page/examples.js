// The robots of the list, from the folder `robots` of the repository, with the options that they are read with.
const EXAMPLES = [
  { file: "arm7.urdf" },
  { file: "quadruped.urdf", base: "floating" },
  { file: "humanoid.urdf", base: "floating" },
  { file: "gripper.urdf" },
  { file: "double_pendulum.urdf" },
  { file: "four_bar.urdf" },
  { file: "mimic_gripper.urdf" },
  { file: "joint_zoo.urdf" },
  { file: "biped.urdf" },
];
