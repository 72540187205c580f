"""`python -m asperity page RESULTS`: the page of a run of the program, or of saved results."""

import argparse
import os
import sys

from ._errors import ComputeError, InputError
from ._results import load


def main() -> int:
    """The command: 0 done, 1 not written, 2 bad command line or file."""
    parser = argparse.ArgumentParser(prog="python -m asperity", description=__doc__)
    page = parser.add_subparsers(required=True).add_parser(
        "page", help="write a page for a browser", description="write a page for a browser")
    page.add_argument("results", help="file of asperity solve --json, or of Results.save")
    page.add_argument("--fields", nargs="+", metavar="VTI",
                      help="files of asperity solve --fields: the last state, or all")
    page.add_argument("--output", metavar="HTML", help="default: RESULTS with the ending .html")
    page.add_argument("--title", help="title of the page; default: the name of the scene")
    given = parser.parse_args()
    output = given.output or os.path.splitext(given.results)[0] + ".html"
    try:
        print(load(given.results, fields=given.fields).to_html(output, title=given.title))
    except (InputError, ComputeError, ImportError) as error:
        print(error, file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
