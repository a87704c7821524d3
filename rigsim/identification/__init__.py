"""From a record to parameters: subspace, nonlinear identification, receptances, physical parameters."""
