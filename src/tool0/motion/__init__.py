"""Planning of joint motions, lines, arcs and blends as time-parameterized paths."""
