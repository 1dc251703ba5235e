"""Forces, inertia and balance: from motion to the equations of motion."""
