"""Rows of CSV files, read and written with the standard library alone."""

import csv
from dataclasses import astuple, fields


def records(path):
    """Rows of a CSV file, each a dict."""
    with open(path, encoding="ascii", newline="") as file:
        return list(csv.DictReader(file))


def write_records(path, results):
    """Dataclasses of one kind as rows: what `records` reads."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(f.name for f in fields(results[0]))
        writer.writerows(map(astuple, results))
