"""Implicit methods: generalized alpha, CVODE and IDA."""
