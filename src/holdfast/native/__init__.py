"""The compiled core: plain arrays in, plain arrays out. It is C++, beside this file; ``core`` is what Python calls."""
