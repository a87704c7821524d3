"""What moves: wires (a new force law goes here), oscillator, multi-body rig, and what shakes it; the door to pymunk."""
