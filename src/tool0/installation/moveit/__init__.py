"""MoveIt 1 configuration packages for robots from the catalogue."""
