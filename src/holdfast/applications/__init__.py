"""Applications of the answers in robotics: placing, transporting and taking apart."""
