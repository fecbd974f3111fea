"""Find where an object can be put down so that everything stands and withstands large pushes.

The way through: ``conditions`` say what is asked; ``support`` proposes poses above points of the scene and ``lowering``
lets the object down from there; ``checks`` judge where it comes to rest, by ``margins`` and by what stands; stable
poses are rated and shifted by ``comparing``; ``planner`` leads through all that, and ``result`` tells it. ``several``
puts objects one after the other, each at one of its ``level_places``.
"""
