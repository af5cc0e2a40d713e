"""A robot in ROS 2, moved by an action client of rclpy.

The client runs in a separate process, under the Python of ROS 2, without tool0.
"""

import subprocess
import sys

GOAL = {"shoulder_lift_joint": -1.2, "elbow_joint": 1.4}  # [rad]


def move() -> None:
    """Send a goal with rclpy only."""
    import rclpy
    from builtin_interfaces.msg import Duration
    from control_msgs.action import FollowJointTrajectory
    from rclpy.action import ActionClient
    from sensor_msgs.msg import JointState
    from trajectory_msgs.msg import JointTrajectoryPoint

    rclpy.init()
    node, states = rclpy.create_node("client"), []
    node.create_subscription(JointState, "/joint_states", states.append, 10)
    action = "/joint_trajectory_controller/follow_joint_trajectory"
    client = ActionClient(node, FollowJointTrajectory, action)
    client.wait_for_server()
    while not states:
        rclpy.spin_once(node)
    position = dict(zip(states[0].name, states[0].position, strict=True))
    goal = FollowJointTrajectory.Goal()
    arm = ("shoulder", "elbow", "wrist")
    goal.trajectory.joint_names = [name for name in position if name.startswith(arm)]
    position |= GOAL
    point = JointTrajectoryPoint(time_from_start=Duration(sec=1, nanosec=500_000_000))
    point.positions = [position[name] for name in goal.trajectory.joint_names]
    goal.trajectory.points = [point]
    sent = client.send_goal_async(goal)
    rclpy.spin_until_future_complete(node, sent)
    ended = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, ended)
    print(ended.result().result.error_string)
    rclpy.shutdown()


if sys.argv[1:] == ["move"]:
    move()
else:
    import tool0

    with tool0.bringup(ros2_control=True) as robot:
        try:
            with tool0.Ros2Node(robot) as node:
                node.wait()
                command = [str(node.ros2.python), __file__, "move"]
                subprocess.run(command, env=node.ros2.environment, check=True)
                elbow = robot.joint_state.position["elbow_joint"]
                print("elbow_joint:", round(elbow, 1))
        except tool0.RosUnavailableError as error:  # "… `tool0 ros2 install` …"
            print("ROS 2 is not available:", error)
