"""Scene files: one module a format; ``load_scene`` tells them apart by what they say of themselves."""
