"""Files of results: JSON and VTI of the program; a zip archive of `results.json`, a CSV file for
each table, and an array of numpy's format (`.npy`) for each field, which other programs read."""

from __future__ import annotations

import ast
import contextlib
import csv
import io
import json
import math
import os
import re
import struct
import sys
import tempfile
import zipfile
import zlib
from array import array
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from . import _arguments as _a
from ._columns import Table, column
from ._errors import ComputeError, refused
from ._fields import FLAGS, NAMES, SLIP_NAMES, Fields, in_rows

FORMAT = "asperity results 1"  #: what `results.json` states
EXPECTED = "a file that Results.save or asperity solve --json wrote"
TEXTS = ("summary", "warnings", "notes")
# What the readers of the standard library raise for damaged files.
FAULTS = (zipfile.BadZipFile, zlib.error, csv.Error, ArithmeticError, AttributeError, EOFError,
          LookupError, NotImplementedError, RecursionError, SyntaxError, TypeError, ValueError,
          struct.error)
# Endings of other formats than that of `Results.save`.
OTHERS = (".csv", ".h5", ".hdf5", ".html", ".json", ".mat", ".nc", ".npy", ".npz", ".pickle",
          ".pkl", ".vti", ".xlsx")
# Of the Python types of a column: the code of the array, and how a cell is read.
CODES = {"float": "d", "int": "i", "str": ""}
# Attributes of fields beside the arrays, and those that JSON has as lists.
FACTS = ("shape", "spacing", "origin", "unit", "units", "position", "step", "boundary_contacts",
         "hertz_contacts")
PAIRS = ("shape", "spacing", "origin")


def write_results(path: _a.Path, version: str, texts: Mapping[str, Any],
                  tables: Mapping[str, Table], fields: Iterable[Fields]) -> None:
    """Write texts, tables and fields to a file; one that exists is replaced when all is written."""
    name = os.fsdecode(_a.path("path", path))
    kept = list(fields)
    facts = {"format": FORMAT, "version": version, **texts,
             "tables": {key: {"name": table.name, "units": table.units,
                              "types": {title: _type_of(cells) for title, cells in table.items()}}
                        for key, table in tables.items()},
             "fields": [{fact: getattr(one, fact) for fact in FACTS} for one in kept]}
    ending = os.path.splitext(name)[1].lower()
    if ending in OTHERS:
        raise _a.wrong("path", repr(name), "a name that ends with .zip, as that is what is written")
    part = ""
    try:
        # A new file, with the permissions of one: a link in its place is not followed.
        descriptor, part = tempfile.mkstemp(".part", ".asperity.", os.path.dirname(name) or ".")
        with open(descriptor, "wb") as file, \
                zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("results.json", json.dumps(facts, indent=1, ensure_ascii=False))
            for key, table in tables.items():
                archive.writestr(f"{key}.csv", _csv_of(table))
            for one in kept:
                for field in one:
                    archive.writestr(_member(one.position, one.step, field),
                                     _npy_of(one[field], one.shape, field in FLAGS))
        os.chmod(part, _permissions(name))
        os.replace(part, name)
        part = ""
    except OSError as error:
        raise ComputeError(f"{name}: {error.strerror}") from None
    finally:
        if part:
            os.remove(part)


def is_saved(path: _a.Path) -> bool:
    """Whether a file is an archive."""
    return zipfile.is_zipfile(os.fsdecode(_a.path("path", path)))


@contextlib.contextmanager
def _reading(name: str, expected: str) -> Iterator[None]:
    """Refuse a file that cannot be opened, or whose content is not as expected."""
    try:
        yield
    except OSError as error:
        raise refused(name, error.strerror or str(error)) from None
    except FAULTS:
        raise refused(name, f"found another kind of file, expected {expected}") from None


def _permissions(name: str) -> int:
    """Those of the file that is replaced, or of a new one."""
    if os.path.exists(name):
        return os.stat(name).st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def read_results(path: _a.Path) -> tuple[dict[str, Any], dict[str, Table], list[Fields]]:
    """The facts, tables and fields of a file."""
    name = os.fsdecode(_a.path("path", path))
    with _reading(name, EXPECTED):
        with zipfile.ZipFile(name) as archive:
            facts = json.loads(archive.read("results.json"))
            if facts["format"] != FORMAT or [type(facts.get(title)) for title in TEXTS] != [
                    str, list, list]:
                raise KeyError("format")
            tables = {key: _table_of(archive.read(f"{key}.csv").decode(), about)
                      for key, about in facts["tables"].items()}
            fields = [_fields_of(archive, about) for about in facts["fields"]]
    return facts, tables, fields


def read_json(path: _a.Path) -> tuple[dict[str, Any], dict[str, Table]]:
    """The facts and tables of a file of `asperity solve --json`."""
    name = os.fsdecode(_a.path("path", path))
    with _reading(name, EXPECTED):
        with open(name, encoding="utf-8") as file:
            facts = json.load(file)
        tables = {key: Table({title: _column_of(cells) for title, cells in facts[key].items()},
                             facts["units"][key], key)
                  for key in ("positions", "states", "contacts")}
        if not {"summary", "notes", "warnings", "scene", "provenance"} <= facts.keys():
            raise KeyError("summary")
    return facts, tables


def _column_of(cells: list[Any]) -> Any:
    """A column of a list; null is a value that was not computed."""
    if any(isinstance(cell, str) for cell in cells):
        return column(cells)
    kind = "i" if cells and all(isinstance(cell, int) for cell in cells) else "d"
    return column(memoryview(array(kind, [math.nan if cell is None else cell for cell in cells])))


def read_vti(path: _a.Path, step: int, length: str, pressure: str) -> Fields:
    """The fields of a file of `asperity solve --fields`: one state of position 1."""
    name = os.fsdecode(_a.path("fields", path))
    made = Fields.__new__(Fields)
    with _reading(name, "a file that asperity solve --fields wrote"):
        with open(name, "rb") as file:
            head, _, body = file.read().partition(b'<AppendedData encoding="raw">_')
        text = head.decode("ascii")
        numbers = {key: [float(word) for word in re.findall(rf' {key}="([^"]*)"', text)[0].split()]
                   for key in ("WholeExtent", "Origin", "Spacing", "NumberOfTuples")
                   if f" {key}=" in text}
        made.shape = int(numbers["WholeExtent"][3]), int(numbers["WholeExtent"][1])
        made.spacing = numbers["Spacing"][0], numbers["Spacing"][1]
        made.origin = (numbers["Origin"][0] + made.spacing[0] / 2,
                       numbers["Origin"][1] + made.spacing[1] / 2)
        counts = re.findall(r'Name="(?:boundary_element|hertz)_contacts".*>(\d+)<', text)
        made.boundary_contacts, made.hertz_contacts = map(int, counts) if counts else (None, None)
        found = re.findall(r'type="(\w+)" Name="(\w+)" format="appended" offset="(\d+)"', text)
        made._names = tuple(field for _, field, _ in found)
        for kind, field, offset in found:
            cells, start = array("d" if kind == "Float64" else "b"), int(offset) + 8
            cells.frombytes(body[start:start + cells.itemsize * made.shape[0] * made.shape[1]])
            if "BigEndian" in text and sys.byteorder == "little":
                cells.byteswap()
            setattr(made, field, in_rows(column(memoryview(cells)), made.shape, field in FLAGS))
    made.unit, made.position, made.step = length or None, 1, step
    made.units = {field: pressure if field in ("pressure", "traction") else
                  "" if field in FLAGS else length for field in made._names}
    return made


def _type_of(cells: Any) -> str:
    kind = getattr(getattr(cells, "dtype", None), "kind", None)
    if kind is None:
        kind = {float: "f", int: "i"}.get(type(next(iter(cells), "")), "U")
    return {"f": "float", "i": "int"}.get(kind, "str")


def _csv_of(table: Table) -> str:
    """Numbers in the shortest form that keeps their bits; one that was not computed is empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(table)
    for row in zip(*(cells.tolist() for cells in table.values())):
        writer.writerow(["" if isinstance(value, float) and math.isnan(value) else value
                         for value in row])
    return buffer.getvalue()


def _table_of(text: str, about: Mapping[str, Any]) -> Table:
    rows = list(csv.reader(io.StringIO(text)))
    columns: dict[str, Any] = {}
    for number, (title, kind) in enumerate(about["types"].items()):
        cells = [row[number] for row in rows[1:]]
        if rows[0][number] != title:
            raise KeyError(title)
        columns[title] = column(cells if kind == "str" else memoryview(array(
            CODES[kind], [(float if kind == "float" else int)(cell or "nan") for cell in cells])))
    return Table(columns, dict(about["units"]), about["name"])


def _member(position: int, step: int, field: str) -> str:
    return f"fields/position_{position:04}_step_{step:04}/{field}.npy"


def _npy_of(rows: Any, shape: tuple[int, int], is_flag: bool) -> bytes:
    """An array in version 1.0 of the format of numpy, rows first."""
    code, descr = ("b", "|b1") if is_flag else ("d", "<f8")
    cells = array(code)
    for row in rows:
        cells.extend(array(code, row.tolist()))
    if sys.byteorder == "big":
        cells.byteswap()
    header = repr({"descr": descr, "fortran_order": False, "shape": shape}).encode()
    header = header.ljust(118 - 1) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + cells.tobytes()


def _fields_of(archive: zipfile.ZipFile, about: Mapping[str, Any]) -> Fields:
    made = Fields.__new__(Fields)
    for fact in FACTS:
        setattr(made, fact, tuple(about[fact]) if fact in PAIRS else about[fact])
    made._names = NAMES + tuple(field for field in SLIP_NAMES if _member(
        made.position, made.step, field) in archive.namelist())
    for field in made:
        raw = archive.read(_member(made.position, made.step, field))
        length = int.from_bytes(raw[8:10], "little")
        header = ast.literal_eval(raw[10:10 + length].decode())
        code, descr = ("b", "|b1") if field in FLAGS else ("d", "<f8")
        if header != {"descr": descr, "fortran_order": False, "shape": made.shape}:
            raise KeyError(field)
        cells = array(code)
        cells.frombytes(raw[10 + length:])
        if sys.byteorder == "big":
            cells.byteswap()
        setattr(made, field, in_rows(column(memoryview(cells)), made.shape, field in FLAGS))
    return made
