"""Planning of motions: joints, lines, arcs and blends, as paths over time."""
