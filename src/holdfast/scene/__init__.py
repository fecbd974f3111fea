"""The description of a scene: bodies with shape, mass and pose, the friction between them, and gravity."""
