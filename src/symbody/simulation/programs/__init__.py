"""Programs of whole simulations in other languages: functions, the integrator and its numbers in one text."""
