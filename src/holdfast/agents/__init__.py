"""Answers for agents, over the Model Context Protocol: what they may ask, what they may read, and the server."""
