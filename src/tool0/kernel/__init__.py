"""The control kernel: C sources, their compilation, and the memory of their structs."""
