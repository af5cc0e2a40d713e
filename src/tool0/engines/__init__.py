"""Physics engines that implement the ``Engine`` protocol."""
