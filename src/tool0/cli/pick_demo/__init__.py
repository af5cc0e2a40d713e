"""What ``tool0 demo`` shows: whole tasks, done with the façade alone."""
