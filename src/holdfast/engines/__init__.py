"""Engines: methods that answer, for an assembly, whether it stands and how large a load it carries."""
