"""glTF: scenes from its files, and files from scenes; ``extras`` is the data that holdfast adds to the meshes."""
