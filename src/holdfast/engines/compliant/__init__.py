"""Engine ``compliant``: elastic contacts with Coulomb friction, the assumptions of the graph method solved directly."""
