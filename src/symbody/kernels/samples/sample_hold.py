"""`SampleHold`: values that are held between samples, and the times at which they are sampled."""

from symbody.kernels.language import Reals
from symbody.kernels.record import Record, stored


class SampleHold(Record):
    """Values that are held between samples.

    Attributes
    ----------
    count, groups, speeds : int
        Numbers of values, of sample times, and of speeds, which stand first in states.
    start, next : float
        When samples are counted from, and when the next one is due [s].
    recorded, room : int
        Rows of the record, each a time and all values, and how many there is room for.
    fault : int
        Status of the function of new values.
    values, slots, group_of : (count,) arrays
        The values, where each stands among the inputs, to which group of one sample time it belongs.
    steps, taken : (groups,) arrays
        The sample time of each group [s], and how many samples it has taken.
    new : (count,) array
        What the function of new values writes.
    """

    count: int
    groups: int
    speeds: int
    start: float
    next: float
    recorded: int
    room: int
    fault: int
    values: Reals = stored("count")
    slots: Reals = stored("count")
    group_of: Reals = stored("count")
    steps: Reals = stored("groups")
    taken: Reals = stored("groups")
    new: Reals = stored("count")
