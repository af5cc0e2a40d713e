"""The arms: power, stops, control box, and motion for programs."""
