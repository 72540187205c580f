"""Reads VTK image data with values of cells as raw appended bytes (.vti), and PNG images with a
palette, by the rules of the formats alone."""

import re
from pathlib import Path

import numpy as np

TYPES = {"Float64": "f8", "UInt8": "u1"}


def read_vti(path):
    """Origin, spacing, and the arrays by name, indexed [x, y]."""
    head, _, body = Path(path).read_bytes().partition(b'<AppendedData encoding="raw">_')
    head = head.decode("ascii")
    assert body.endswith(b"\n</AppendedData>\n</VTKFile>\n")
    assert '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"' in head
    assert 'header_type="UInt64">' in head
    origin, spacing = (np.array([float(v) for v in re.search(f'{name}="([^"]*)"', head)[1].split()])
                       for name in ("Origin", "Spacing"))
    extent = [int(v) for v in re.search('WholeExtent="([^"]*)"', head)[1].split()]
    assert head.count(f'Extent="{" ".join(map(str, extent))}"') == 2
    assert extent[::2] == [0, 0, 0] and extent[5] == 0
    found, end = {}, 0
    for kind, name, offset in re.findall(
            r'<DataArray type="(\w+)" Name="(\w+)" format="appended" offset="(\d+)"/>', head):
        start = int(offset)
        assert start == end
        size = int.from_bytes(body[start:start + 8], "little")
        end = start + 8 + size
        values = np.frombuffer(body[start + 8:end], "<" + TYPES[kind])
        found[name] = values.reshape(extent[3], extent[1]).T
    assert body[end:] == b"\n</AppendedData>\n</VTKFile>\n"
    return origin, spacing, found
