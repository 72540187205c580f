"""The command line, the CSV files and the exit status, as the interface promises them."""

import ast
import csv
import itertools
import os
import re
import subprocess
from decimal import ROUND_HALF_UP, Decimal

import pytest

from decks import write_deck
from printed_report import NotFound, Report
from programs import run_program

CONTACTS = ("position,x_displacement,y_displacement,step,approach,area_no,x,y,upper,lower,area,"
            "projected_area,slope,load,average_pressure,maximum_pressure,limit_exceeded")
POSITIONS = ("position,x_displacement,y_displacement,steps,approach,contacts,load,area,"
             "projected_area,limit_reached")
WHOLE = ("position", "step", "steps", "contacts", "area_no", "upper", "lower", "limit_exceeded",
         "limit_reached")
THESIS_TABLES = {"TABLE VIIA": 13, "TABLE VIIB": 55, "TABLE VIIC": 56}
DECIMALS = {"approach": 4, "x": 3, "y": 3, "area": 5, "projected_area": 5, "slope": 3, "load": 0,
            "average_pressure": 0, "maximum_pressure": 0}


@pytest.fixture(scope="module")
def thesis(root):
    return root / "data" / "thesis.deck"


@pytest.fixture
def run(asperity, tmp_path):
    def start(*arguments, **options):
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
        return subprocess.run([asperity, *map(str, arguments)], cwd=tmp_path, text=True,
                              stdin=subprocess.DEVNULL, timeout=60, **options)
    return start


@pytest.mark.parametrize("words, option", [
    (("solve", "--curve", "a", "--curve", "b", "s"), "--curve"),
    (("solve", "--threads=1", "--threads", "2", "s"), "--threads"),
    (("solve", "--histogram", "a", "--histogram", "b", "s"), "--histogram"),
    (("summits", "--unit", "um", "--unit", "um", "m"), "--unit"),
    (("generate", "--surface", "1", "--surface", "2", "s"), "--surface"),
    (("--tables", "13", "--tables", "all", "d"), "--tables")])
def test_an_option_given_twice(run, words, option):
    """Its last value would win in silence. Two --keep name two files."""
    done = run(*words)
    assert done.returncode == 2 and f"option {option} is given twice, expected once" in done.stderr
    keep = run("solve", "--keep", "a", "--keep", "b", "--quiet", "--quiet", "s")
    assert "twice" not in keep.stderr


@pytest.fixture(scope="module")
def plain(asperity, thesis):
    """The report of the thesis deck without any option."""
    return run_program(asperity, thesis).stdout


def test_no_arguments_prints_commands_to_type(run):
    done = run()
    assert (done.returncode, done.stderr) == (0, "")
    assert "asperity data/thesis.deck" in done.stdout and "asperity --help" in done.stdout


COMMANDS = ("solve", "accuracy", "generate", "summits")


def words_of(path):
    """The words of all texts in a file of Python."""
    constants = (node.value for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
                 if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return {word.partition("=")[0] for text in constants for word in text.split()}


def test_help(run, root):
    """A help fits a screen, and a test that runs the command names each of its options."""
    files = [words_of(path) for path in root.glob("test/[!s]*/test_*.py")]
    for command in ("", *COMMANDS):
        done = run(*filter(None, [command]), "--help")
        assert (done.returncode, done.stderr) == (0, "")
        assert len(done.stdout.splitlines()) <= 60
        options = re.findall(r"^  (--[a-z-]+)", done.stdout, re.MULTILINE)
        assert len(options) > 3
        assert "Usage: " in done.stdout and "Exit status: 0 " in done.stdout
        tested = set().union(*(words for words in files if not command or command in words))
        assert not set(options) - tested, command
        assert run("help", *filter(None, [command])).stdout == done.stdout
        assert command or run("-h").stdout == done.stdout
    assert run("help", "solve", "loading").stdout == run("solve", "--help", "loading").stdout


@pytest.mark.parametrize("command", ("solve", "generate"))
def test_help_of_groups(command, run):
    """Each group that the help lists has its names there, and fits a screen."""
    groups = re.search(r"^Groups: (.+)$", run(command, "--help").stdout, re.MULTILINE)[1].split()
    assert {"surfaces", "effects" if command == "solve" else "map"} < set(groups)
    for group in groups:
        head, *names = run(command, "--help", group).stdout.splitlines()
        assert head == f"Names of group &{group}; [unit]:" and 2 < len(names) < 60
    assert run(command, "--help", "other").stdout == run(command, "--help").stdout


def test_version_is_the_package_s(run, root):
    version = re.search(r'^version = "(.+)"', (root / "fpm.toml").read_text(), re.MULTILINE)[1]
    done = run("--version")
    lines = done.stdout.splitlines()
    assert (done.returncode, lines[0], done.stderr) == (0, f"asperity {version}", "")
    assert re.match(r"built by \S.* with .*-O\d", lines[1]) and "/" not in lines[1]
    assert all(name in lines[2] for name in ("ibm370", "real32", "real64", "real128"))


@pytest.mark.parametrize("rank, number", [(0, 3), (1, 3), (0, 1)])
def test_copies_by_a_launcher_are_noted(rank, number, asperity, root, tmp_path):
    """Once, by the first of several copies that each solve the whole scene; the results stay."""
    words = asperity, "solve", root / "data/examples/one_pair.scene", "--quiet"
    alone = run_program(*words, "--positions", tmp_path / "alone.csv")
    done = run_program(*words, "--positions", tmp_path / "p.csv", variables={
        "OMPI_COMM_WORLD_RANK": str(rank), "OMPI_COMM_WORLD_SIZE": str(number)})
    noted = "a launcher has started this program 3 times" in done.stderr
    assert noted == (rank == 0 and number == 3) and "launcher" not in alone.stderr
    assert (tmp_path / "p.csv").read_bytes() == (tmp_path / "alone.csv").read_bytes()


def test_manual_and_completion_have_the_options_of_the_help(run, tmp_path):
    """One table serves all three."""
    manual = run("--man").stdout.replace("\\-", "-")
    completion = run("--completion").stdout
    for command in COMMANDS:
        options = re.findall(r"^  (--[a-z-]+)", run(command, "--help").stdout, re.MULTILINE)
        words = re.search(rf'^    {command}\) words="--help (.*)"', completion, re.MULTILINE)[1]
        assert words.split() == options and len(options) > 3
        section = manual.partition(f".SH {command}")[2].partition(".SH ")[0]
        assert re.findall(r"^\.B (--[a-z-]+)", section, re.MULTILINE) == options
    # The words of an option are those of its message; a file's name is one word.
    (tmp_path / "my map.sdf").touch()
    (tmp_path / "*").touch()
    script = completion + """
complete_words() { COMP_WORDS=(asperity "$@") COMP_CWORD=$#; _asperity
  printf '[%s]' "${COMPREPLY[@]}"; echo; }
complete_words sol; complete_words solve --k; complete_words summits my
complete_words summits --rule ''; complete_words solve --of l; complete_words '*'
complete_words --arithmetic r"""
    done = run_program("bash", "-c", script, cwd=tmp_path)
    assert done.stderr == "" and done.stdout.splitlines() == [
        "[solve]", "[--keep]", "[my map.sdf]", "[eight][contact]", "[load]", "[*]",
        "[real32][real64][real128]"]


@pytest.mark.parametrize("arguments, words", [
    (["DECK", "--bogus"], ["--bogus", "--arithmetic", "--tables", "--contacts", "--positions"]),
    (["DECK", "--table", "all"], ["unknown option", "--table"]),
    (["-t"], ["unknown option", "-t"]),
    (["DECK", "--arithmetic"], ["--arithmetic", "no value"]),
    (["DECK", "--positions"], ["--positions", "no value"]),
    (["--contacts", "--positions", "p.csv", "DECK"], ["--contacts", "no value"]),
    (["DECK", "--contacts="], ["--contacts", "empty value"]),
    (["DECK", "--arithmetic", "ibm360"], ["ibm360", "ibm370", "real32", "real64", "real128"]),
    (["solve", "DECK", "--arithmetic", "real64"],
     ["a scene is solved in real64 only", "--arithmetic NAME` runs the original program"]),
    (["DECK", "--tables", "some"], ["'some'", "none", "all", "1 to 100"]),
    (["DECK", "--tables", "101"], ["'101'"]),
    (["DECK", "--tables", "13,,55"], ["''"]),
    (["DECK", "--tables", "1-3"], ["'1-3'"]),
    (["DECK", "--tables", "1 2"], ["'1 2'"]),
    (["DECK", "--tables", "99999999999"], ["'99999999999'"]),
    (["DECK", "--variance", "DECK"], ["--variance", "DECK"]),
    (["DECK", "--carriage-control=no"], ["--carriage-control", "no value"]),
    (["DECK", "DECK"], ["DECK", "unexpected"]),
    (["--tables", "all"], ["no card deck"]),
    (["study", "DECK", "--quiet"], ["'study'", "solve, accuracy, generate or summits"]),
    (["sovle"], ["'sovle'", "did you mean 'solve'"]),
    ([""], ["deck", "empty"]),
    (["--threads", "2", "solve", "DECK"],
     ["found '--threads' before solve", "asperity solve [OPTIONS] SCENE"]),
    (["solve", "--", "DECK"], ["found '--'", "./-NAME", "Try: asperity solve --help"]),
    (["solve", "DECK", "--nothing"], ["'--nothing'", "Try: asperity solve --help"]),
    (["DECK", "--contacts", "one.csv", "--positions", "one.csv"], ["one.csv"]),
    (["DECK", "--contacts", "DECK"], ["--contacts", "DECK"]),
], ids=lambda value: "_".join(value) or "empty")
def test_bad_command_lines(arguments, words, run, thesis, tmp_path):
    own = tmp_path / "own.deck"
    own.write_bytes(thesis.read_bytes())
    done = run(*[word.replace("DECK", "own.deck") for word in arguments])
    assert (done.returncode, done.stdout) == (2, "")
    for word in words:
        assert word.replace("DECK", "own.deck") in done.stderr
    assert os.listdir(tmp_path) == ["own.deck"]
    assert own.read_bytes() == thesis.read_bytes()


def test_all_that_is_wrong_with_a_command_line(run, thesis):
    done = run(thesis, "--bogus", "--arithmetic", "x", "--tables", "0,55,200", "other.deck")
    assert done.returncode == 2
    words = ["--bogus", "found 'x'", "found '0'", "found '200'", "'other.deck'",
             "asperity --help"]
    complaints = done.stderr.splitlines()
    assert [sum(word in line for line in complaints) for word in words] == [1] * len(words)
    assert len(complaints) == len(words)


@pytest.mark.parametrize("arguments", [
    ("--arithmetic", "ibm370"), ("--arithmetic=ibm370",), ("--tables", "13,55,56"),
    ("--tables=56,13,55,13",), ("--contacts=c.csv",)])
def test_defaults_spelled_out(arguments, run, thesis, plain):
    for words in ((thesis, *arguments), (*arguments, thesis)):
        done = run(*words)
        assert (done.returncode, done.stdout) == (0, plain)


def contact_tables(text):
    """Names of the contact tables in the order printed, continued pages left out."""
    return re.findall(r"^ +TABLE (VII[A-Z]+)$", text, re.MULTILINE)


def letters():
    alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    yield from alphabet
    yield from map("".join, itertools.product(alphabet, repeat=2))


def names_in_order(text):
    seen = []
    for name in contact_tables(text):
        if name not in seen:
            seen.append(name)
    return seen


@pytest.mark.parametrize("choice, positions", [
    ("none", []), ("all", list(range(1, 101))), ("1,2,99,100", [1, 2, 99, 100]),
    ("56,13", [13, 56]), ("007", [7]), ("13,20,55,56", [13, 20, 55, 56])])
def test_tables(choice, positions, run, thesis):
    done = run(thesis, "--tables", choice)
    assert done.returncode == 0
    expected = ["VII" + name for name in itertools.islice(letters(), len(positions))]
    assert names_in_order(done.stdout) == expected
    report = Report(done.stdout)
    for name, position in zip(expected, positions):
        x, y = report.displacement("TABLE " + name)
        assert (x, y) == (f"{0.1 * position:.3f}", "0.0")
    for table in ("V", "IIIA", "IIIB", "VI"):
        assert report.table("TABLE " + table)


def test_a_table_does_not_depend_on_other_tables(run, thesis, plain):
    everything = Report(run(thesis, "--tables", "all").stdout)
    named = dict(zip(range(1, 101), letters()))
    for title, position in THESIS_TABLES.items():
        rows = Report(plain).contacts(title)
        assert rows == everything.contacts("TABLE VII" + named[position]) and rows
    with pytest.raises(NotFound):
        Report(run(thesis, "--tables", "none").stdout).contacts("TABLE VIIA")


def csv_rows(path, header):
    text = path.read_text(encoding="ascii")
    assert text.endswith("\n") and "\r" not in text
    assert text.split("\n", 1)[0] == header
    return list(csv.DictReader(text.splitlines()))


@pytest.fixture(scope="module", params=("ibm370", "real32", "real64", "real128"))
def outputs(request, asperity, thesis, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    done = run_program(asperity, thesis, "--arithmetic", request.param, "--contacts",
                       "contacts.csv", "--positions", "positions.csv", cwd=folder)
    assert sorted(os.listdir(folder)) == ["contacts.csv", "positions.csv"]
    return (Report(done.stdout), csv_rows(folder / "contacts.csv", CONTACTS),
            csv_rows(folder / "positions.csv", POSITIONS))


def test_csv_numbers_have_all_digits(outputs):
    _, contacts, positions = outputs
    for row in contacts + positions:
        for name, cell in row.items():
            pattern = r"\d+" if name in WHOLE else r"-?\d\.\d{16}E[+-]\d{3}"
            assert re.fullmatch(pattern, cell), (name, cell)
            # 17 significant digits are enough to give the double back.
            assert name in WHOLE or f"{float(cell):.16e}" == plain_exponent(cell)
    assert {row["limit_exceeded"] for row in contacts} == {"0", "1"}
    assert {row["limit_reached"] for row in positions} <= {"0", "1"}


def plain_exponent(cell):
    """1.5E+001 as Python writes it: 1.5e+01."""
    mantissa, exponent = cell.split("E")
    return f"{mantissa}e{exponent[0]}{int(exponent[1:]):02d}"


def printed(cell, decimals):
    """A CSV number as the report prints it; an exact zero keeps a single place."""
    value = Decimal(float(cell))
    if value == 0:
        return "0.0" if decimals else "0."
    text = str(value.quantize(Decimal(1).scaleb(-decimals), ROUND_HALF_UP))
    return text if decimals else text + "."


def test_contacts_csv_has_the_contacts_of_the_report(outputs):
    report, contacts, _ = outputs
    for title, position in THESIS_TABLES.items():
        rows = [row for row in report.contacts(title) if row["kind"] == "contact"]
        records = [row for row in contacts if row["position"] == str(position)]
        assert len(rows) == len(records) > 0
        for row, record in zip(rows, records):
            touching = float(record["load"]) == 0.0
            assert row["limit_exceeded"] == (
                "" if touching else "YES" if record["limit_exceeded"] == "1" else "NO")
            for name in ("area_no", "upper", "lower"):
                assert row[name] == record[name]
            for name, decimals in DECIMALS.items():
                if touching and name.endswith("pressure"):
                    assert row[name] == "" and float(record[name]) == 0.0
                else:
                    assert row[name] == printed(record[name], decimals), (name, record)


def test_positions_csv_is_the_last_approach_of_every_position(outputs):
    report, contacts, positions = outputs
    assert [row["position"] for row in positions] == [str(m) for m in range(1, 101)]
    steps = {}
    for row in contacts:
        steps.setdefault(row["position"], {}).setdefault(int(row["step"]), []).append(row)
    for record in positions:
        of_position = steps[record["position"]]
        assert sorted(of_position) == list(range(1, int(record["steps"]) + 1))
        last = of_position[int(record["steps"])]
        assert len(last) == int(record["contacts"])
        assert [row["area_no"] for row in last] == [str(i + 1) for i in range(len(last))]
        assert {row["approach"] for row in last} == {record["approach"]}
        for name in ("x_displacement", "y_displacement"):
            assert {row[name] for row in last} == {record[name]}
        reached = "1" if any(row["limit_exceeded"] == "1" for row in last) else "0"
        assert record["limit_reached"] == reached
        for name in ("load", "area", "projected_area"):
            total = sum(float(row[name]) for row in last)
            # The shorter arithmetics cut off up to 2**-20 a sum.
            assert float(record[name]) == pytest.approx(total, rel=len(last) * 2.0 ** -20)
    for title, position in THESIS_TABLES.items():
        total = [row for row in report.contacts(title) if row["kind"] == "total"][-1]
        record = positions[position - 1]
        for name in ("area", "projected_area", "load"):
            assert total[name] == printed(record[name], DECIMALS[name])


def feed_forms(text):
    """What a line printer does with column one, on paper with form feeds."""
    lines = []
    for line in text.split("\n")[:-1]:
        control, rest = line[:1], line[1:]
        assert control in ("", " ", "1", "0")
        lines += {"1": ["\f" + rest], "0": ["", rest]}.get(control, [rest])
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("tables", ("none", "13,55,56", "all"))
def test_carriage_control(tables, run, thesis):
    controlled = run(thesis, "--tables", tables, "--carriage-control").stdout
    forms = run(thesis, "--tables", tables).stdout
    assert controlled.startswith("1\n") and "\f" not in controlled
    assert feed_forms(controlled) == forms
    assert forms.count("\f") == sum(line.startswith("1") for line in controlled.split("\n")) > 3


def test_heights_above_the_stated_maximum_are_only_noted(run, thesis, tmp_path):
    done = run(thesis)
    assert done.returncode == 0
    (note,) = done.stderr.splitlines()
    assert "note" in note and "8 lower asperities" in note and "0.0732" in note
    cards = thesis.read_text().splitlines()
    cards[2] = cards[2].replace("0.070", "0.074", 1)
    (tmp_path / "high.deck").write_text("\n".join(cards) + "\n")
    done = run("high.deck")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("upper, lower, pages", [(38, 39, (1, 2)), (39, 77, (2, 2)),
                                                 (1, 78, (1, 3)), (77, 1, (2, 1))])
def test_pages_of_table_iii(upper, lower, pages, run, tmp_path):
    """38 asperities on the first page, 39 on each further one, and no page without any."""
    # Wide enough for the first pair to touch at every position; the others are far below it.
    wide = {"radius": 9.0, "height_max": 0.9}
    models = [{**model([(4.0, 1.5, 0.8)] + [(4.0, 1.5, 0.1)] * (number - 1)), **wide}
              for number in (upper, lower)]
    write_deck(tmp_path / "many.deck", *models)
    done = run("many.deck", "--tables", "none", "--arithmetic", "real64")
    assert done.returncode == 0, done.stderr
    for table, number, count in (("IIIA", upper, pages[0]), ("IIIB", lower, pages[1])):
        assert len(re.findall(rf"TABLE {table}\b", done.stdout)) == count
        rows = Report(done.stdout).asperities("TABLE " + table)
        assert [row["index"] for row in rows] == [str(i + 1) for i in range(number)]


def model(asperities):
    return {"radius": 0.5, "height_max": 0.07, "modulus": 400000.0, "ratio": 0.42,
            "stress": 11200.0, "asperities": asperities}


@pytest.mark.parametrize("position, x", [(1, 3.0), (10, 0.0)])
@pytest.mark.parametrize("arithmetic", ("ibm370", "real64"))
def test_no_candidate_pair_stops_the_run(position, x, arithmetic, run, tmp_path):
    """Pairs count within 2 sqrt(0.5 * 0.07) in = 0.950 cm; a position moves by 0.1 cm. The input
    stood on paper before."""
    write_deck(tmp_path / "apart.deck", model([(x, 1.0, 0.06)]), model([(0.0, 2.455, 0.06)]))
    done = run("apart.deck", "--arithmetic", arithmetic, "--contacts", "c.csv", "--positions",
               "p.csv")
    assert done.returncode == 1 and re.findall("TABLE [IVX]+[AB]?", done.stdout) == [
        "TABLE V", "TABLE IIIA", "TABLE IIIB"]
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"apart.deck: position {position}: no pair of asperities")
    assert os.listdir(tmp_path) == ["apart.deck"]
