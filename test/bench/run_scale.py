"""Large surfaces: phases of the solver; one and two threads; interaction.

    python test/bench/run_scale.py [--most N] [--rounds R] [--parts NAMES] [--small] [--save]
        [--beside EXE]

The least time of runs that take turns counts. Ratios come first: they carry over to another
machine, seconds do not.
"""

import argparse
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

from scale_interaction import interaction_part
from scale_solve import solve_part
from scale_sweeps import threads_part
from whole_runs import Failed, machine, release_build, save

PARTS = ("solve", "threads", "interaction")
# Asperities and positions of the sweeps.
SIZES = {False: (100_000, 10_000), True: (10_000, 1000)}


def heading(flags, options):
    """The lines without which the numbers below mean nothing."""
    return "\n".join([
        *machine(flags), f"rounds    {options.rounds}, the least time counts",
        f"busy      {os.getloadavg()[0]:.1f} processes in the minute before the start"])


def whole_number(text):
    """1000000 or 1e6."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 1.0 <= number <= 1e9 or number != int(number):
        raise argparse.ArgumentTypeError("expected a whole number, 1 or more")
    return int(number)


def names_of_parts(text):
    names = text.split(",")
    if not set(names) <= set(PARTS):
        raise argparse.ArgumentTypeError(f"expected some of {','.join(PARTS)}")
    return names


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=whole_number, default=1_000_000,
                        help="largest N (default 1e6)")
    parser.add_argument("--rounds", type=whole_number, default=3, help="turns of all (default 3)")
    parser.add_argument("--parts", type=names_of_parts, default=PARTS,
                        help=f"some of {','.join(PARTS)} (default all)")
    parser.add_argument("--small", action="store_true", help="small sweeps, to try the bench")
    parser.add_argument("--beside", help="another executable, for the part 'interaction'")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    options = parser.parse_args()

    asperity, flags = release_build()
    n, positions = SIZES[options.small]
    sizes = [10**k for k in range(3, 9) if 10**k <= options.most]
    parts = {
        "solve": lambda: solve_part(asperity, sizes, options.rounds),
        "threads": lambda: threads_part(asperity, n, positions, options.rounds),
        "interaction": lambda: interaction_part(asperity, options.most, options.rounds,
                                                options.beside)}
    blocks = [heading(flags, options)]
    print(blocks[0])
    for name in options.parts:
        try:
            blocks.append(parts[name]())
        except Failed as failure:
            raise SystemExit(f"bench: a run of the part '{name}' {failure}")
        print("\n" + blocks[-1], flush=True)
    if options.save:
        save("scale.txt", "\n\n".join(blocks) + "\n")


if __name__ == "__main__":
    main()
