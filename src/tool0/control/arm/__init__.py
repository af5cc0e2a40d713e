"""Motion of an arm for programs that plan elsewhere: paths, streams, forces."""
