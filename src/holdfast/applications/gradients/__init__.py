"""Derivatives of answers by poses, friction, masses and pushes."""
