"""The control kernel: C sources, their compilation, and what packs their structs."""
