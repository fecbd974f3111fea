"""LDraw models: toy bricks that hold by their studs."""
