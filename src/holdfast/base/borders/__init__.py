"""The borders to what is not ours: foreign parsers and libraries, and processes with limits of memory and time."""
