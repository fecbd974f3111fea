"""Contacts between bodies: interfaces that consist of flat patches, and the nodes that represent them."""
