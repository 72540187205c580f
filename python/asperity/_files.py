"""Files of results: JSON and VTI of the program; a zip archive of `results.json`, a CSV file for
each table, and an array of numpy's format (`.npy`) for each field, which other programs read."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import os
import re
import shutil
import struct
import sys
import zipfile
import zlib
from array import array
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from . import _arguments as _a
from ._columns import Table, column, in_rows
from ._errors import ComputeError, refused
from ._fields import FLAGS, NAMES, SLIP_NAMES, Fields

FORMAT = "asperity results 1"  #: what `results.json` states
EXPECTED = "a file that Results.save or asperity solve --json wrote"
TABLES = ("positions", "states", "contacts")
TEXTS = ("summary", "warnings", "notes")
# What the readers of the standard library raise for damaged files.
FAULTS = (zipfile.BadZipFile, zlib.error, csv.Error, struct.error, ArithmeticError, AttributeError,
          EOFError, LookupError, RuntimeError, TypeError, ValueError)
# Endings of other formats than that of `Results.save`.
OTHERS = (".csv", ".h5", ".hdf5", ".html", ".json", ".mat", ".nc", ".npy", ".npz", ".pickle",
          ".pkl", ".vti", ".xlsx")
# Attributes of fields beside the arrays, and those that JSON has as lists.
FACTS = ("shape", "spacing", "origin", "periodic", "unit", "units", "position", "step",
         "boundary_contacts", "hertz_contacts")
PAIRS = ("shape", "spacing", "origin", "periodic")


def write_results(path: _a.Path, version: str, texts: Mapping[str, Any],
                  tables: Mapping[str, Table], fields: Iterable[Fields]) -> None:
    """Write texts, tables and fields to a file; one that exists is replaced when all is written."""
    name, kept = os.fsdecode(_a.path("path", path)), list(fields)
    if os.path.splitext(name)[1].lower() in OTHERS:
        raise _a.wrong("path", repr(name), "a name that ends with .zip, as that is what is written")
    facts = {"format": FORMAT, "version": version, **texts,
             "tables": {key: {"name": table.name, "units": table.units,
                              "types": {title: _type_of(cells) for title, cells in table.items()}}
                        for key, table in tables.items()},
             "fields": [{fact: getattr(one, fact) for fact in FACTS} for one in kept]}
    # A new file: a link in its place is not followed.
    part = os.path.join(os.path.dirname(name), f".asperity.{os.urandom(8).hex()}.part")
    try:
        with open(part, "xb") as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("results.json", json.dumps(facts, indent=1, ensure_ascii=False))
            for key, table in tables.items():
                archive.writestr(f"{key}.csv", _csv_of(table))
            for one in kept:
                for field in one:
                    archive.writestr(_member(one.position, one.step, field),
                                     _npy_of(one[field], one.shape, field in FLAGS))
        if os.path.exists(name):
            shutil.copymode(name, part)
        os.replace(part, name)
    except OSError as error:
        raise ComputeError(f"{name}: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            os.remove(part)


@contextlib.contextmanager
def _reading(name: str, expected: str = EXPECTED) -> Iterator[None]:
    """Refuse a file that cannot be opened, or whose content is not as expected."""
    try:
        yield
    except OSError as error:
        raise refused(name, error.strerror or str(error)) from None
    except FAULTS:
        raise refused(name, f"found another kind of file, expected {expected}") from None


def read_results(path: _a.Path) -> tuple[dict[str, Any], dict[str, Table], list[Fields] | None]:
    """The facts, tables and fields of a file; of one of `asperity solve --json` no fields."""
    name, fields = os.fsdecode(_a.path("path", path)), None
    with _reading(name):
        if zipfile.is_zipfile(name):
            with zipfile.ZipFile(name) as archive:
                facts = json.loads(archive.read("results.json"))
                tables = {key: _table_of(archive.read(f"{key}.csv").decode(), about)
                          for key, about in facts["tables"].items()}
                fields = [_fields_of(archive, about) for about in facts["fields"]]
        else:
            with open(name, encoding="utf-8") as file:
                facts = json.load(file)
            facts["scene"]["provenance"] = facts["provenance"]
            tables = {key: Table({title: _column_of(cells) for title, cells in facts[key].items()},
                                 facts["units"][key], key) for key in TABLES}
        if facts.get("format", FORMAT) != FORMAT or [type(facts[title]) for title in TEXTS] != [
                str, list, list]:
            raise KeyError("format")
    return facts, tables, fields


def _column_of(cells: list[Any], kind: str = "") -> Any:
    """A column of the values of JSON, or of texts of a kind; None and "" were not computed."""
    if kind == "str" or any(isinstance(cell, str) for cell in cells if not kind):
        return column(cells)
    if kind:
        cells = [(float if kind == "float" else int)(cell or "nan") for cell in cells]
    code = "i" if kind == "int" or cells and all(isinstance(cell, int) for cell in cells) else "d"
    return _numbers(code, [math.nan if cell is None else cell for cell in cells])


def _numbers(code: str, content: Any, is_swapped: bool = False) -> Any:
    """A column of numbers or of their bytes."""
    cells = array(code, content)
    if is_swapped:
        cells.byteswap()
    return column(memoryview(cells))


def read_vti(path: _a.Path, place: tuple[int, int], length: str, pressure: str) -> Fields:
    """The fields of a file of `asperity solve --fields`: one state, by position and step."""
    name = os.fsdecode(_a.path("fields", path))
    made = Fields.__new__(Fields)
    with _reading(name, "a file that asperity solve --fields wrote"):
        with open(name, "rb") as file:
            head, _, body = file.read().partition(b'<AppendedData encoding="raw">_')
        text = head.decode("ascii")
        numbers = {key: [float(word) for word in re.findall(rf' {key}="([^"]*)"', text)[0].split()]
                   for key in ("WholeExtent", "Origin", "Spacing")}
        made.shape = int(numbers["WholeExtent"][3]), int(numbers["WholeExtent"][1])
        made.spacing = numbers["Spacing"][0], numbers["Spacing"][1]
        made.origin = (numbers["Origin"][0] + made.spacing[0] / 2,
                       numbers["Origin"][1] + made.spacing[1] / 2)
        counts = re.findall(r'Name="(?:boundary_element|hertz)_contacts".*>(\d+)<', text)
        made.boundary_contacts, made.hertz_contacts = map(int, counts) if counts else (None, None)
        found = re.findall(r'type="(\w+)" Name="(\w+)" format="appended" offset="(\d+)"', text)
        made._names = tuple(field for _, field, _ in found)
        is_swapped = ("BigEndian" in text) == (sys.byteorder == "little")
        for kind, field, offset in found:
            code, start = ("d", 8) if kind == "Float64" else ("b", 1), int(offset) + 8
            setattr(made, field, in_rows(_numbers(code[0], body[start:start + code[1] * (
                made.shape[0] * made.shape[1])], is_swapped), made.shape, field in FLAGS))
    made.unit, (made.position, made.step) = length or None, place
    made.periodic = None
    made.units = {field: pressure if field.startswith(("pressure", "traction")) else
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
    titles, *rows = csv.reader(io.StringIO(text))
    if titles != list(about["types"]):
        raise KeyError("types")
    return Table({title: _column_of([row[number] for row in rows], kind)
                  for number, (title, kind) in enumerate(about["types"].items())},
                 dict(about["units"]), about["name"])


def _member(position: int, step: int, field: str) -> str:
    return f"fields/position_{position:04}_step_{step:04}/{field}.npy"


def _header(shape: tuple[int, int], is_flag: bool) -> bytes:
    """The beginning of an array in version 1.0 of the format of numpy, rows first."""
    header = repr({"descr": "|b1" if is_flag else "<f8", "fortran_order": False, "shape": shape})
    return b"\x93NUMPY\x01\x00\x76\x00" + header.encode().ljust(0x76 - 1) + b"\n"


def _npy_of(rows: Any, shape: tuple[int, int], is_flag: bool) -> bytes:
    cells = array("b" if is_flag else "d")
    for row in rows:
        cells.extend(array(cells.typecode, row.tolist()))
    if sys.byteorder == "big":
        cells.byteswap()
    return _header(shape, is_flag) + cells.tobytes()


def _fields_of(archive: zipfile.ZipFile, about: Mapping[str, Any]) -> Fields:
    made = Fields.__new__(Fields)
    for fact in FACTS:
        setattr(made, fact, tuple(about[fact]) if fact in PAIRS and about[fact] else about[fact])
    made._names = NAMES + tuple(field for field in SLIP_NAMES if _member(
        made.position, made.step, field) in archive.namelist())
    for field in made:
        raw, header = (archive.read(_member(made.position, made.step, field)),
                       _header(made.shape, field in FLAGS))
        if not raw.startswith(header):
            raise KeyError(field)
        cells = _numbers("b" if field in FLAGS else "d", raw[len(header):], sys.byteorder == "big")
        setattr(made, field, in_rows(cells, made.shape, field in FLAGS))
    return made
