"""Which rig shows a detached curve, and how well it must be built: charts, margins, tolerances, the best force."""
