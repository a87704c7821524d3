"""Many independent points: cut into chunks by the problem, run by any executor, kept in a checkpoint."""
