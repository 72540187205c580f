"""Mutated height maps: `asperity summits` reads them or states what is wrong, and where.

Status is 0 or 2, within seconds; with 2 every line on standard error names the file and a place,
and no file is left behind; with 0 the numbers are finite. The same seed gives the same map
everywhere.

    python test/support/fuzz_maps.py --exe PATH --runs 5000
"""

import io
import random
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from programs import run_program

COUNTS = {b"ISO-1.0": 2, b"ISO-2.0": 4, b"BCR-1.0": 2}
TYPES = ["<u1", "<u2", "<u4", "<f4", "<i1", "<i2", "<i4", "<f8"]
FIELDS = ("ManufacID", "CreateDate", "ModDate", "NumPoints", "NumProfiles", "Xscale", "Yscale",
          "Zscale", "Zresolution", "Compression", "DataType", "CheckType")
WORDS = (b"BAD", b"NaN", b"*", b"=", b";", b"#", b",", b"\n", b"\r", b"\x00", b"-", b"1e400",
         b"inf", b"1e-400", b"99999999999", b"\xff\xff\xff\xff", b"\x00\x00\x80\x7f",
         b"\xef\xbb\xbf", b"0", b"ISO-2.0", b"NumPoints = 3\n", b" ", b"1d5", b"+", b".",
         b"\x93NUMPY\x01\x00", b"(9, 3)", b"'<f4'", b"True", b"{", b"}", b"'", b"3")
PLACE = re.compile(r"m\.map(?::\d+:\d+|: byte \d+(?:, record [12])?|: header|: found|: heights|"
                   r": all pixels|: and \d+ more|: --spacing)")
CRASH = re.compile(r"Error termination|runtime error|Backtrace|Segmentation|Aborted|At line \d+|"
                   r"IEEE_")


def heights(rng, rows, columns, kind):
    values = [[rng.randrange(1, 100) for _ in range(columns)] for _ in range(rows)]
    values[rng.randrange(rows)][rng.randrange(columns)] = 1
    return np.array(values).astype(kind)


def binary(rng, rows, columns):
    revision = rng.choice(sorted(COUNTS))
    kind = rng.randrange({b"ISO-1.0": 5, b"ISO-2.0": 3, b"BCR-1.0": 0}[revision], 8)
    wide = COUNTS[revision]
    scales = np.array([1e-6, 2e-6, 1e-9, -1.0]).tobytes()
    return (b"b" + revision + b"fuzz      010120261200010120261200" +
            columns.to_bytes(wide, "little") + rows.to_bytes(wide, "little") + scales +
            bytes([0, kind, 0]) + heights(rng, rows, columns, TYPES[kind]).tobytes() + b"end\r\n")


def text(rng, rows, columns):
    revision = rng.choice(sorted(COUNTS)).decode()
    values = dict(zip(FIELDS, ("fuzz", "0", "0", columns, rows, "1e-6", "2.0E-6", "1e-9", "-1", 0,
                               rng.choice((5, 6, 7)), 0)))
    lines = [f"a{revision}", *(f"{name} = {values[name]}" for name in FIELDS), "*"]
    lines += [" ".join(map(str, row)) for row in heights(rng, rows, columns, "<i2")]
    return (rng.choice(("\n", "\r\n", "\r")).join([*lines, "*", "*", ""])).encode()


def matrix(rng, rows, columns):
    separator = rng.choice((" ", ",", ";"))
    return "\n".join(separator.join(map(str, row))
                     for row in heights(rng, rows, columns, "<f8")).encode()


def points(rng, rows, columns):
    grid = heights(rng, rows, columns, "<f8")
    lines = [f"{0.1 * j:.3g},{i},{grid[i, j]}" for i in range(rows) for j in range(columns)]
    if rng.random() < 0.3:
        rng.shuffle(lines)
    return "\n".join(rng.choice(([], ["x,y,z"])) + lines).encode()


def array(rng, rows, columns):
    kind = rng.choice(("<f8", "<f8", ">f8", "<f4", ">f4", "|i1", "|u1", ">i2", "<u4", ">i8", "<u8"))
    file = io.BytesIO()
    np.lib.format.write_array(file, np.array(heights(rng, rows, columns, kind),
                                             order=rng.choice("CF")),
                              version=(rng.choice((1, 2, 3)), 0))
    return file.getvalue()


def mutate(rng, data):
    """Flip, change, cut out, double and put in, anywhere, more often in the first hundred bytes."""
    data = bytearray(data)
    for _ in range(rng.choice((0, 1, 1, 1, 2, 3, 8))):
        at = rng.randrange(min(len(data), 120) if rng.random() < 0.6 else max(1, len(data)))
        kind = rng.randrange(7)
        if kind == 0 and data:
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 1 and data:
            data[at] = rng.randrange(256)
        elif kind == 2:
            del data[at:at + rng.choice((1, 1, 2, 4, 30))]
        elif kind == 3:
            data[at:at] = data[at:at + rng.choice((1, 4, 30))]
        elif kind == 4:
            data[at:at] = rng.choice(WORDS)
        elif kind == 5:
            word = rng.choice(WORDS)
            data[at:at + len(word)] = word
        else:
            del data[rng.randrange(len(data) + 1):]
        if not data:
            break
    return bytes(data)


def case(seed):
    rng = random.Random(seed)
    rows, columns = rng.randrange(3, 9), rng.randrange(3, 9)
    kind = rng.choice((binary, binary, text, text, matrix, points, array, array))
    options = [option for option in ("--despike", "--rule=contact", "--radius=paraboloid",
                                     "--radius=geometric", "--level=none", "--level=mean")
               if rng.random() < 0.25]
    # An option given twice is refused before the file is read: the last one stays.
    options = list({option.split("=")[0]: option for option in options}.values())
    if kind in (matrix, array) or rng.random() < 0.02:
        options.append("--spacing=0.5,2")
    return mutate(rng, kind(rng, rows, columns)), options


def run(exe, folder, seed):
    """What is wrong with a run, or nothing, and its status."""
    data, options = case(seed)
    (folder / "m.map").write_bytes(data)
    try:
        done = run_program(exe, "summits", "m.map", "--output", "s.csv", *options, status=None,
                           cwd=folder, text=False, timeout=100)
    except subprocess.TimeoutExpired:
        return "does not end", None
    err, out = (stream.decode("utf-8", errors="replace") for stream in (done.stderr, done.stdout))
    left = sorted(path.name for path in folder.iterdir())
    wrong = ""
    if done.returncode not in (0, 2):
        wrong = f"status {done.returncode}: {err}"
    elif CRASH.search(err):
        wrong = err
    elif done.returncode == 2 and (not err or not all(map(PLACE.match, err.splitlines()))):
        wrong = f"no place: {err}"
    elif left != (["m.map"] if done.returncode else ["m.map", "s.csv"]):
        wrong = f"files {left}"
    elif re.search(r"(?i)\b(?:nan|inf(?:inity)?)\b|\*{3}", out.partition("\n")[2]):
        wrong = f"not finite: {out}"
    elif done.returncode == 0:
        rows = (folder / "s.csv").read_text(encoding="ascii").splitlines()[1:]
        table = np.array([row.split(",") for row in rows], float).reshape(-1, 4)
        if not np.isfinite(table).all() or not (table[:, 3] > 0).all():
            wrong = "a surface with numbers that are none"
    for name in left:
        (folder / name).unlink()
    return wrong, done.returncode


def campaign(exe, seeds):
    """How many ended with which status, and the faults by seed."""
    ended, faults = {}, {}
    with tempfile.TemporaryDirectory(prefix="maps") as place:
        for seed in seeds:
            wrong, status = run(exe, Path(place), seed)
            ended[status] = ended.get(status, 0) + 1
            if wrong:
                faults[seed] = wrong
    return ended, faults
