"""Find where an object can be put down so that everything stands and resists pushes as well as possible."""
