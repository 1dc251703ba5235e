"""Processes forked while threads form, compile and simulate; exits with the number of those that did not compute.

A forked process has the thread that forked and no other. Locks that others held then are free in it; one that hangs
is ended by its alarm.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
import time

import symbody as sb
from tests.threads.every_call import CALLS, loop

PATIENCE = 120  # seconds, of a process that takes one


def answer(eqs: sb.EquationSet) -> str:
    return repr([CALLS[name](eqs) for name in ("simulate", "point")])


def main(children: int) -> int:
    stop = threading.Event()
    shared = loop()
    expected = answer(loop())

    def work(place: int) -> None:
        while not stop.is_set():
            eqs = shared if place % 2 else loop()
            answer(eqs)
            sb.compile(eqs, f"theta + {time.monotonic_ns()}/10^20")  # never on the disk

    workers = [threading.Thread(target=work, args=(place,)) for place in range(4)]
    for worker in workers:
        worker.start()
    failed = 0
    for child in range(children):
        time.sleep(0.05 + 0.037 * child)
        process = os.fork()
        if not process:
            signal.alarm(PATIENCE)
            ok = answer(shared if child % 2 else loop()) == expected
            os._exit(0 if ok else 1)
        status = os.waitpid(process, 0)[1]
        if status:
            print(f"process {child}: status {status}")
            failed += 1
    stop.set()
    for worker in workers:
        worker.join()
    return failed


if __name__ == "__main__":
    faulthandler.enable()
    sys.exit(main(int(sys.argv[1])))
