"""Whole tests as on a bench, on the multi-body rig: one state, carried over from the first point to the last.

An operator (a generator, one a rig) says what force comes next and is told the motion; `bench` runs many of them side
by side. Nobody's motion depends on a neighbour, nor on the sensors that look at it.
"""
