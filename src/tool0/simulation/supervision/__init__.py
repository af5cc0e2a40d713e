"""Whether joints follow and arms touch only what they may, and why not."""
