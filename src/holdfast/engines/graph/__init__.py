"""The method of Nadeau & Kelly: slip from maximum flow, toppling from cuts of the contact interface graph."""
