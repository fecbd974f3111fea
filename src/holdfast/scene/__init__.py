"""What is there: bodies with shape, mass and pose, friction between them, gravity."""
