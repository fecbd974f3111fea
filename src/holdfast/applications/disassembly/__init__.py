"""Which bodies may be taken out, in which order, while the rest stands."""
