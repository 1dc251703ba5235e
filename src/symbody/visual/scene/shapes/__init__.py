"""The shapes of a mechanism: bodies, joints, connectors, wheels, surfaces, from its model in numbers."""
