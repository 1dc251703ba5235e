"""A URDF file as data: XML read safely, links, joints, and where they stand."""
