"""Mesh files: one module for each format, each of which takes the whole content of a file and trusts none of it."""
