/** The joints of a UR5, as Universal Robots' numbers put them. */
const QUARTER = Math.PI / 2;

const JOINTS: readonly (readonly [string, string, string, string, string])[] = [
  ["shoulder_pan_joint", "base", "shoulder", "0 0 0.089159", "0 0 0"],
  ["shoulder_lift_joint", "shoulder", "upper_arm", "0 0 0", `${QUARTER} 0 0`],
  ["elbow_joint", "upper_arm", "forearm", "-0.425 0 0", "0 0 0"],
  ["wrist_1_joint", "forearm", "wrist_1", "-0.39225 0 0.10915", "0 0 0"],
  ["wrist_2_joint", "wrist_1", "wrist_2", "0 -0.09465 0", `${QUARTER} 0 0`],
  ["wrist_3_joint", "wrist_2", "wrist_3", "0 0.0823 0", `${-QUARTER} 0 0`],
];

export const UR5 = `<?xml version="1.0"?>
<robot name="ur5">
  <link name="base_link"/>
  <link name="base"/>
  <link name="shoulder"><inertial><mass value="3.7"/></inertial></link>
  ${["upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3", "flange", "tool0"]
    .map((name) => `<link name="${name}"/>`)
    .join("")}
  <joint name="turned" type="fixed">
    <origin rpy="0 0 ${Math.PI}"/><parent link="base_link"/><child link="base"/>
  </joint>
  ${JOINTS.map(
    ([name, parent, child, xyz, rpy]) => `
  <joint name="${name}" type="revolute">
    <origin xyz="${xyz}" rpy="${rpy}"/><axis xyz="0 0 1"/>
    <parent link="${parent}"/><child link="${child}"/>
    <limit lower="-3.14" upper="3.14" effort="150" velocity="3.15"/>
  </joint>`,
  ).join("")}
  <joint name="wrist_3-flange" type="fixed">
    <origin rpy="0 ${-QUARTER} ${-QUARTER}"/><parent link="wrist_3"/><child link="flange"/>
  </joint>
  <joint name="flange-tool0" type="fixed">
    <origin rpy="${QUARTER} 0 ${QUARTER}"/><parent link="flange"/><child link="tool0"/>
  </joint>
</robot>`;
