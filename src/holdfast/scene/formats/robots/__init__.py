"""Descriptions of robots and of things: URDF, SDF as Gazebo loads it, and model directives of Drake (.dmd.yaml)."""
