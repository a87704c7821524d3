"""Which motion a start leads to: attractors, basins, taps, and how safe a motion is."""
