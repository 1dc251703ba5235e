"""Where everything is and how it moves: variables, frames, and what cut joints demand."""
