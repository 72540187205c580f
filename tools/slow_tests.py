"""Writes test/slow_tests.txt, the tests that `make test` leaves to `make test-all`.

    ASPERITY_TEST_TIMES=times.csv bash .ci/test          (all tests; appends a line for each)
    python tools/slow_tests.py times.csv [SECONDS]

The slowest functions are listed until the others take SECONDS (default 240) of processor time in
all. A function is listed with all its parameters.
"""

import csv
import sys
from collections import Counter
from pathlib import Path

LISTED = Path(__file__).resolve().parents[1] / "test/slow_tests.txt"


def main(times, seconds=240.0):
    total, number = Counter(), Counter()
    with open(times, newline="", encoding="utf-8") as file:
        for name, cost in csv.reader(file):
            function = name.partition("[")[0]
            total[function] += float(cost)
            number[function] += 1
    rest, slow = sum(total.values()), []
    # What costs most a test goes first: many cheap tests of one function are worth their time.
    for function in sorted(total, key=lambda name: -total[name] / number[name]):
        if rest <= float(seconds):
            break
        slow.append(function)
        rest -= total[function]
    LISTED.write_text("".join(f"{name}\n" for name in sorted(slow)), encoding="ascii")
    print(f"{len(slow)} of {len(total)} functions are slow, {sum(total.values()):.0f} s in all; "
          f"the others take {rest:.0f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])
