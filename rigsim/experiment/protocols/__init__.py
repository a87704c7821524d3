"""Whole tests as on a bench, on the multi-body rig: one state, carried over from the first point to the last.

An operator (a generator) says what force comes next and is told the motion, and `bench` moves the rig. Each rig is a
chunk of work by itself: nobody's motion depends on a neighbour, nor on the sensors that look at it.
"""
