"""What is wrong in a robot: rules for URDF and xacro, as functions that yield findings.

Nothing here raises, whatever the XML: a rule that cannot read a value leaves it to the
rule whose subject the value is.
"""
