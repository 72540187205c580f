"""Rows of CSV files, read with the standard library alone."""

import csv


def records(path):
    """Rows of a CSV file, each a dict."""
    with open(path, encoding="ascii", newline="") as file:
        return list(csv.DictReader(file))
