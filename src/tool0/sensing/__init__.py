"""What is measured: snapshots, cameras, wrench, grasps."""
