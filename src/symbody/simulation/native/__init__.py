"""The Python side of the integrator: methods, blocks, records; the kernels are in `symbody.kernels`."""
