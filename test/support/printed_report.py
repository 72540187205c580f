"""Reads the printed report by its columns, as a reader with a ruler would."""

import re

# Columns of a contact row after carriage control is dropped: name, first, last (from 0, half open).
CONTACT_COLUMNS = {
    "approach": (12, 19), "area_no": (19, 22), "x": (22, 30), "y": (30, 38),
    "upper": (38, 41), "lower": (41, 45), "area": (46, 54), "projected_area": (54, 62),
    "slope": (62, 68), "load": (68, 74), "average_pressure": (74, 82),
    "maximum_pressure": (82, 90), "limit_exceeded": (93, 97),
}
TOTAL_COLUMNS = {"area": (46, 54), "projected_area": (54, 62), "load": (62, 74)}
ASPERITY_COLUMNS = {"index": (30, 35), "x": (38, 47), "y": (47, 56), "height": (56, 66)}


class NotFound(AssertionError):
    """A table or row that is not in the report."""


def cut(line, columns):
    line = line.ljust(132)
    return {name: line[a:b].strip() for name, (a, b) in columns.items()}


class Report:
    """A printed report, split into pages and tables."""

    def __init__(self, text):
        self.pages = [page.split("\n") for page in text.split("\f")]

    def table(self, title):
        """All lines of the pages whose title is `title`, continued pages included."""
        lines = []
        for page in self.pages:
            for number, line in enumerate(page):
                if line.strip() in (title, title + " (CONTINUED)"):
                    lines += page[number + 1:]
                    break
        if not lines:
            raise NotFound(f"{title} is not in the report")
        return lines

    def asperities(self, title):
        rows = [line for line in self.table(title) if re.match(r"\s{30,35}\d+\s+\d", line)]
        return [cut(line, ASPERITY_COLUMNS) for line in rows]

    def contacts(self, title):
        rows = []
        for line in self.table(title):
            if line.rstrip().endswith("TOTAL"):
                rows.append({"kind": "total", **cut(line, TOTAL_COLUMNS)})
            elif re.match(r"\s{10,14}-?\d*\.\d{4}\s", line):
                rows.append({"kind": "contact", **cut(line, CONTACT_COLUMNS)})
        return rows

    def displacement(self, title):
        for line in self.table(title):
            found = re.search(r"UPPER MODEL\s+X\s+([-0-9.]+)\s+CM\s+Y\s+([-0-9.]+)\s+CM", line)
            if found:
                return found.groups()
        raise NotFound(f"{title} names no displacement")
