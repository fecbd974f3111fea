"""Push a body so that no other one moves, and move bodies to where only larger pushes move something."""
