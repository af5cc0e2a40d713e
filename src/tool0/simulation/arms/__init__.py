"""The arms: power, stops and control box of each, and its motion for a program."""
