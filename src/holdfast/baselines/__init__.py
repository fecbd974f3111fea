"""Independent referees of engine ``compliant``: dynamic simulations that share its contact nodes and nothing else."""
