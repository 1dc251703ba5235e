"""Which joints hold and which ropes pull, decided by the kernel `find_modes`."""
