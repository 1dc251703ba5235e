"""Where a motion keeps its held values: places in their block, and the times at which they are sampled.

Like a run, held values are one array of reals. Behind the `HEADER` lie, where the header says, the values,
where each stands among the inputs, to which group of one sample time it belongs, the sample time of each
group and how many samples it has taken, and what the function of new values writes.
"""

from __future__ import annotations

from typing import Final

COUNT: Final = 0  # of values
GROUPS: Final = 1
SPEEDS: Final = 2
START: Final = 3  # when samples are counted from [s]
NEXT: Final = 4  # when the next sample is due [s]
RECORDED: Final = 5  # rows of the record: a time and all values
ROOM: Final = 6
FAULT: Final = 7  # status of the function
VALUES: Final = 8
SLOTS: Final = 9
GROUP_OF: Final = 10
STEPS: Final = 11  # sample times
TAKEN: Final = 12
NEW: Final = 13
HEADER: Final = 16
