"""Pictures that move in an exported page, offline: sliders over precomputed curves, and animations of the rig."""
