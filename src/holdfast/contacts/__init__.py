"""Where bodies touch: interfaces made of flat patches, and the nodes that stand for them."""
