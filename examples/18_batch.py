"""A batch in which 16 copies lift cubes of different masses with different forces."""

import numpy as np

import tool0

masses = np.repeat([0.05, 0.2, 1.0, 3.0], 4)  # [kg]
forces = np.tile([25.0, 50.0, 100.0, 200.0], 4)  # [N]

ready = tool0.ControlConfig(initial_pose="ready")
with tool0.Batch(16, control=ready, scene="table_and_cubes") as batch:
    batch.set_mass("red cube", masses)
    batch.set_friction("red cube", 0.3)
    cube = batch.object_names.index("red cube")
    low = batch.object_position[:, cube, 2]

    # Close the grippers around the cubes.  Each copy uses its own force.
    batch.move_gripper(0.02, speed=0.1, force=forces)
    batch.run(1.0)
    print(f"forces on the pads of copy 5: {batch.pad_forces()[5].round(0)} N")

    # Lift the cubes.  Each arm gets one target, in the order of batch.arm_joints.
    columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
    target = batch.position[:, columns]
    target[:, batch.arm_joints.index("shoulder_lift_joint")] -= 0.4
    batch.command(target, velocities=np.zeros_like(target), duration=1.0)
    batch.run(1.5)

    lifted = batch.object_position[:, cube, 2] - low > 0.05
    for mass in np.unique(masses):
        held = forces[(masses == mass) & lifted]
        print(f"{mass:4.2f} kg lifted with", *(f"{force:.0f} N" for force in held))
    position, quat_wxyz = batch.tcp_pose()
    print("shapes:", batch.position.shape, position.shape, quat_wxyz.shape)

    # Every copy has its own time.  Reset only the copies that dropped the cube.
    batch.reset(~lifted)
    print("times after the reset:", np.unique(batch.time), "s")
