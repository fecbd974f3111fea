"""Find where an object can be put down so that everything stands and withstands large pushes."""
