"""Planning of collision-free motions: collision world, search and timing."""
