"""A robot in ROS 1, moved by an actionlib client."""

import tool0

GOAL = {"shoulder_lift_joint": -1.2, "elbow_joint": 1.4}  # [rad]


def move() -> None:
    """Send a goal with rospy only."""
    import actionlib
    import rospy
    from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
    from sensor_msgs.msg import JointState
    from trajectory_msgs.msg import JointTrajectoryPoint

    controller = "/eff_joint_traj_controller"
    client = actionlib.SimpleActionClient(
        f"{controller}/follow_joint_trajectory", FollowJointTrajectoryAction
    )
    client.wait_for_server()
    state = rospy.wait_for_message("/joint_states", JointState)
    position = {**dict(zip(state.name, state.position, strict=True)), **GOAL}
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = rospy.get_param(f"{controller}/joints")
    goal.trajectory.points = [
        JointTrajectoryPoint(
            positions=[position[joint] for joint in goal.trajectory.joint_names],
            time_from_start=rospy.Duration(1.5),
        )
    ]
    client.send_goal_and_wait(goal)
    print("error_code:", client.get_result().error_code)
    state = rospy.wait_for_message("/joint_states", JointState)
    print("elbow_joint:", round(state.position[state.name.index("elbow_joint")], 1))


with tool0.bringup() as robot:
    try:
        # rospy allows one node per process.  This process is both the robot and the
        # client.
        with tool0.Ros1Bridge(robot, tool0.Ros1Options(roscore=True)):
            move()
    except tool0.RosUnavailableError as error:
        # The error says: "… `tool0 ros1 install` installs it …"
        print("ROS 1 is not available:", error)
