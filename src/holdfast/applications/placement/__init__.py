"""Where an object can be put down so that everything stands, and withstands as much as possible."""
