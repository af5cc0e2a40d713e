"""Where an arm's joints must be for its tool to be somewhere, in closed form."""
