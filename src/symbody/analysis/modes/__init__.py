"""Which joints hold and which gaps are closed, decided by the kernel `find_modes`."""
