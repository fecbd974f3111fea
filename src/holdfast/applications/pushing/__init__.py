"""Find where a body can be pushed so that nothing moves, or so that it moves alone."""
