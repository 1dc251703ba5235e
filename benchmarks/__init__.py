"""Benchmarks: symbody beside its peers, in one run, on one machine.

    python -m benchmarks                  all, ten minutes with all peers
    python -m benchmarks expressions      one
    python -m benchmarks derivation       equations of motion, beside sympy.physics.mechanics
    python -m benchmarks growth           up to 2000 bodies: to the first call, first and later motions
    python -m benchmarks evaluation       compile times, and batches on one core
    python -m benchmarks motion           the compiled loop, beside SciPy's DOP853
    python -m benchmarks trajectories     motions of equal accuracy, beside SUNDIALS, MuJoCo and PyDy
    python -m benchmarks robots           robots beside code that others generate, and beside libraries
    python -m benchmarks record           what README and pages show beside others, into record.json and them
    python -m benchmarks render           the tables of README and pages, from record.json
    python -m benchmarks overhead         what stands around the loop: first, repeated and short motions
    python -m benchmarks second_calls     what simulate costs when it is called again, and how many files run
    python -m benchmarks sweep            many motions, by one thread and by two
    python -m benchmarks --help           sizes, time limit, number of rounds

How to read the tables
----------------------
Ratios are the point. In brackets, with a cross, stands the figure divided by symbody's of the same run:
"(4.1x)" needs 4.1 times as long, or as many operations. Absolute times belong to the machine and to what
else ran on it; they are shown so that a reader sees whether a ratio is about microseconds or minutes.

Every figure is a median over rounds, and in each round all engines take their turn one after the other, so
that a slow minute of the machine slows all of them. An engine whose round takes long is asked less often.
"derivation" shows the shortest time instead, because its rounds are few and long; see `derivation.py` for
what is compared there.

Each engine works in a process of its own. What does not finish within the time limit is ended: the column
it was in says "not done", the total "> 60 s", and later columns stay empty. What fails says so below.
Peers are optional: what is not installed is left out, with a line saying so. `pip install symbody[peers]`
brings those on the package index.

All engines are given the same problem, written once in `problems.py` for any algebra, and are used as their
documentation advises for speed: SymPy with common subexpressions and NumPy, SymEngine with its LLVM backend,
CasADi with matrix products in C++, buffers instead of conversions, and a C compiler where there is one.
"One call" is a call from Python for one point, with what the way from Python into the engine costs; "in a
loop" is one point of many in the engine's own loop. The numbers returned are compared: "difference" is the
largest deviation from symbody's, relative to the largest result at the same point.

Operations are counted alike for all: + - * / and functions 1, signs 0, whole powers by squaring, a fused
multiply-add 2.

Adding one
----------
A benchmark is one file here with ``tables(settings) -> Iterator[Table]``, and its name in `__main__.py`.
`table.py` prints, `timing.py` measures in turns, `process.py` runs what may have to be ended.
"""
