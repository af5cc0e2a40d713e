"""Motion of an arm for programs that plan externally: paths, streams and forces."""
