"""ROS 2: finding one, installing one of PyPI's wheels, and its environment."""
