"""Physics engines behind the Engine port."""
