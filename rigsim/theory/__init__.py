"""The response with one harmonic, in closed form: amplitudes, folds, detached curves, and when they come and go."""
