"""Writes test/slow_tests.txt, the tests that `make test` leaves to `make test-all`.

    ASPERITY_TEST_TIMES=times.csv bash .ci/test          (all tests; appends a line for each)
    python tools/slow_tests.py times.csv [SECONDS]

The slowest tests are listed until the others take SECONDS (default 120) of processor time in all.
A function whose tests are all slow is listed by its name. What times.csv does not have stays as it
was listed. KEPT tests are not listed.
"""

import csv
import sys
from pathlib import Path

LISTED = Path(__file__).resolve().parents[1] / "test/slow_tests.txt"
# The package as its pages show it: types, examples, notebooks.
KEPT = ("test/regression/test_python_docs.py::",
        "test/regression/test_python_maps.py::test_twelve_lines")


def main(times, seconds=120.0):
    with open(times, newline="", encoding="utf-8") as file:
        costs = {name: float(cost) for name, cost in csv.reader(file)}
    functions = {}
    for name in costs:
        functions.setdefault(name.partition("[")[0], set()).add(name)
    rest, slow = sum(costs.values()), set()
    for name in sorted(costs, key=costs.get, reverse=True):
        if rest <= float(seconds):
            break
        if not name.startswith(KEPT):
            slow.add(name)
            rest -= costs[name]
    listed = {line for line in LISTED.read_text(encoding="utf-8").splitlines()
              if line not in costs and line not in functions}
    for function, names in functions.items():
        listed |= {function} if names <= slow else names & slow
    LISTED.write_text("".join(f"{name}\n" for name in sorted(listed)), encoding="utf-8")
    print(f"{len(slow)} of {len(costs)} tests are slow, {sum(costs.values()):.0f} s in all; "
          f"the others take {rest:.0f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])
