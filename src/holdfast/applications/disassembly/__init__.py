"""Find which bodies can be taken out of an assembly, and in which order, while the others stand."""
