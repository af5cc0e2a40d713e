"""MoveIt 1 configuration packages for robots of the catalogue."""
