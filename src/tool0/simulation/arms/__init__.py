"""The arms of a robot: power, stops, control box, and motion under program control."""
