"""Send a goal of a generated action type to a server in the same process.

It runs in ROS 2's Python, and prints what went through.
"""

import json
import os
import threading

import rclpy
from control_msgs.action import FollowJointTrajectory
from control_msgs.srv import QueryTrajectoryState
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

TIMEOUT = 30.0

feedback = []
has_feedback = threading.Event()


def execute(handle):
    """Answer with what the goal asked for."""
    point = handle.request.trajectory.points[0]
    message = FollowJointTrajectory.Feedback(
        joint_names=handle.request.trajectory.joint_names, desired=point
    )
    handle.publish_feedback(message)
    has_feedback.wait(TIMEOUT)
    handle.succeed()
    return FollowJointTrajectory.Result(error_code=-5, error_string="é, at last")


def answer(request, response):
    """Answer with the time of the request."""
    response.name = ["a", "b"]
    response.position = [float(request.time.sec), 0.25]
    return response


def on_feedback(message):
    """Keep it."""
    feedback.append(message.feedback)
    has_feedback.set()


def wait(future):
    """Return the result of a request that this thread has sent.

    The thread that sends also receives: rclpy's ActionClient may drop a response that
    another thread receives (github.com/ros2/rclpy/issues/1123).
    """
    client_executor.spin_until_future_complete(future, TIMEOUT)
    return future.result()


rclpy.init()
node = Node("round_trip")
client_node = Node("client", namespace="round_trip")
server = ActionServer(node, FollowJointTrajectory, "~/follow", execute)
service = node.create_service(QueryTrajectoryState, "~/query", answer)
action = ActionClient(client_node, FollowJointTrajectory, "/round_trip/follow")
query = client_node.create_client(QueryTrajectoryState, "/round_trip/query")
executor, client_executor = SingleThreadedExecutor(), SingleThreadedExecutor()
executor.add_node(node)
client_executor.add_node(client_node)
threading.Thread(target=executor.spin, daemon=True).start()

action.wait_for_server(TIMEOUT)
query.wait_for_service(TIMEOUT)
goal = FollowJointTrajectory.Goal()
goal.trajectory.joint_names = ["a", "b"]
goal.trajectory.points = [JointTrajectoryPoint(positions=[0.5, -1.0])]
result = wait(wait(action.send_goal_async(goal, on_feedback)).get_result_async())
request = QueryTrajectoryState.Request()
request.time.sec = 7
response = wait(query.call_async(request))
print(
    json.dumps(
        {
            "status": result.status,
            "error_code": result.result.error_code,
            "error_string": result.result.error_string,
            "joint_names": list(feedback[0].joint_names),
            "desired": list(feedback[0].desired.positions),
            "position": list(response.position),
        }
    ),
    flush=True,
)
os._exit(0)
