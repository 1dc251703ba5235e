"""Which expressions are equal: values at random points of a finite field, and what is merged by them."""
