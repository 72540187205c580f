"""Runs short floating-point instructions on a System/370: Hercules executes a stand-alone program.

The program is assembled here by hand. For each kind of operation it is one loop: two words in, the
instructions of the kind, a result word, the condition code and the interruption code out. Storage
is loaded with `loadcore` and saved with `savecore`; nothing is read from or written to a device.

After a program interruption the handler keeps its code and goes on behind the instruction, so a
result is what the register holds then: an exponent that left its range is 128 off, a division by
zero is suppressed.
"""

import os
import re
import shutil
import struct
import subprocess
import tempfile
from pathlib import Path

HERCULES = "hercules"
MISSING = "the emulator Hercules is not installed (apt-get install hercules): nothing was compared"
# Low storage: restart new PSW, program old PSW with the interruption code, program new PSW.
RESTART, OLD_CODE, OLD, NEW = 0x0, 0x2A, 0x28, 0x68
HANDLER, START, TABLES, STORAGE = 0x180, 0x200, 0x10000, 0x1000000
# The exponent-underflow bit of the program mask; the significance bit stays off.
UNDERFLOW = 0x2
DONE = 0x0D0E00
OVERFLOW_CODE, UNDERFLOW_CODE, DIVIDE_CODE = 0xC, 0xD, 0xF
SECONDS = (1, 5, 60)  # for a program to end, tried one after the other

# Work area of a loop, behind its code: two double words that change, then constants.
WORK, WORK2 = 0, 8
CONSTANTS = ("4E00000000000000", "0000000000000000", "46000000", "00FFFFFF", "40000000", "411AE7D0",
             "41149FA2", "40D73F18", "40400000", "00000020")
LONG_UNIT, ZERO, SIX, FRACTION, NO_EXPONENT, C1, C2, C3, QUARTER, THIRTY_TWO = (
    16, 24, 32, 36, 40, 44, 48, 52, 56, 60)
ADDRESSES = 64

# Instructions of a kind: operands at 0 and 4 behind register 2, floating result in register 0 or,
# for those of WHOLE, fixed result in general register 7. {NAME} is a place of the work area, SKIP
# a branch (not minus, or zero) over what follows it.
SHORT = {"AE": "7A", "SE": "7B", "ME": "7C", "DE": "7D", "CE": "79"}
BODIES = {name: ["78002000", code + "002004"] for name, code in SHORT.items()}
BODIES |= {
    "LTER": ["78002000", "3200"],                  # LE 0,a; LTER 0,0
    "LCER": ["78002000", "3300"],                  # LE 0,a; LCER 0,0
    "HER": ["78002000", "3400"],                   # LE 0,a; HER 0,0
    # A whole number to a short one: LPR 1, ST, LD 0 with 4E, AD 0,zero, minus: LCDR.
    "FLOAT": ["58002000", "1010", "5010{WORK+4}", "6800{WORK}", "6A00{ZERO}", "1200", "NM2",
              "2300"],
    # And back: LE, AW 0,4E, STD, L 7, LTDR, minus: LCR 7.
    "FIX": ["2B00", "78002000", "6E00{LONG_UNIT}", "6000{WORK}", "5870{WORK+4}", "2200", "NM2",
            "1377"],
    # The same in six digits: LE, AU 0,46000000, STE, L 7, N 7, LTER, minus: LCR 7.
    "FIX-AU": ["78002000", "7E00{SIX}", "7000{WORK}", "5870{WORK}", "5470{FRACTION}", "3200", "NM2",
               "1377"],
    # The library's root. Exponents: p in 7, q in 8; m and m/16**q in the work area.
    "SQRT": ["58002000", "1810", "88100018", "41701001", "88700001", "1887", "89800001", "1B81",
             "5400{FRACTION}", "5600{NO_EXPONENT}", "5000{WORK}", "1898", "89900018", "1B09",
             "5000{WORK2}",
             # y = c1 - c2/(m + c3), a quarter of it for q = 1, in floating register 4.
             "7820{WORK}", "7A20{C3}", "7800{C2}", "3D02", "7840{C1}", "3B40", "1288", "Z4",
             "7C40{QUARTER}",
             # y = (y + x/y)/2, halved by HER.
             "7800{WORK2}", "3D04", "3A04", "3400",
             # Once more, the sum in long registers, halved by HDR and rounded by LRER.
             "3840", "2B22", "7820{WORK2}", "3D24", "2B00", "3804", "2A02", "2400", "3500",
             "7000{WORK}", "5B70{THIRTY_TWO}", "89700018", "5E70{WORK}"],
}
BODIES |= {f"{name} unnormalised": BODIES[name] for name in SHORT}
WHOLE = ("FIX", "FIX-AU", "SQRT")


def loop(kind, operands, results, count):
    """Machine code of one kind, with its work area; register 12 points behind the first BALR."""
    head = ["5820{OPERANDS}", "5830{RESULTS}", "5840{COUNT}"]
    body = ["1B55", *BODIES[kind], "0560", "5070" if kind in WHOLE else "7000"]
    body[-1] += "3000"
    # The code of the interruption, the byte with the condition code, the next pair.
    body += ["88600018", "40603004", "40503006", "41202008", "41303008", "BCT", "END"]
    code, begin = [*head, *body], sum(length(text) for text in head)
    size = sum(length(text) for text in code)
    work = size + (-size - 2) % 8
    places = {name: work + globals()[name] for name in
              ("WORK", "WORK2", "LONG_UNIT", "ZERO", "SIX", "FRACTION", "NO_EXPONENT", "C1", "C2",
               "C3", "QUARTER", "THIRTY_TWO")}
    places |= {"OPERANDS": work + ADDRESSES, "RESULTS": work + ADDRESSES + 4,
               "COUNT": work + ADDRESSES + 8}
    out, at = b"", 0
    for text in code:
        at += length(text)
        if text == "BCT":
            text = f"4640C{begin:03X}"
        elif text == "END":
            text = f"47F0C{work + ADDRESSES + 16:03X}"
        elif text[0] in "NZ":
            # BC behind so many bytes: not minus, or zero.
            text = f"47{'B0' if text[0] == 'N' else '80'}C{at + int(text[-1]):03X}"
        text = re.sub(r"{(\w+)(\+4)?}",
                      lambda m: f"C{places[m[1]] + (4 if m[2] else 0):03X}", text)
        out += bytes.fromhex(text)
    out = out.ljust(work, b"\0") + bytes.fromhex("4E00000000000000" + "00" * 8 + "".join(CONSTANTS))
    return b"\x05\xC0" + out + struct.pack(">4I", operands, results, count, 0)


def length(text):
    """Bytes of an instruction, a place or branch being part of four."""
    return 4 if "{" in text or text in ("BCT", "END") or text[0] in "NZ" else len(text) // 2


def image(work, mask):
    """Storage with program and operands, and where the results of each kind will be."""
    core = bytearray(TABLES)
    core[RESTART:RESTART + 8] = struct.pack(">II", 0, mask << 24 | START)
    core[NEW:NEW + 8] = struct.pack(">II", 0, mask << 24 | HANDLER)
    # LH 5,code; LPSW old.
    core[HANDLER:HANDLER + 8] = bytes.fromhex(f"4850{OLD_CODE:04X}8200{OLD:04X}")
    places, program = [], b""
    for kind, pairs in work:
        places.append((len(core) + 8 * len(pairs), len(pairs)))
        program += loop(kind, len(core), *places[-1])
        core += b"".join(struct.pack(">II", *pair) for pair in pairs) + bytes(8 * len(pairs))
    # LPSW: a disabled wait is the end.
    end = START + len(program)
    program += bytes.fromhex(f"8200{end + 8:04X}00000000") + struct.pack(">II", 0x00020000, DONE)
    if end + 16 > 0x1000 or len(core) > STORAGE:
        raise ValueError("program or tables are too large")
    core[START:START + len(program)] = program
    return core, places


def run(work, mask=0):
    """For each (kind, pairs of words): result word, condition code, interruption code of each.

    Raises RuntimeError when the program does not come to its end."""
    core, places = image(work, mask)
    for seconds in SECONDS:
        with tempfile.TemporaryDirectory() as folder:
            log = launch(Path(folder), core, seconds)
            saved = Path(folder, "saved").read_bytes() if Path(folder, "saved").exists() else b""
        if f"{DONE:06X}" in log and len(saved) == len(core):
            break
    else:
        raise RuntimeError(f"the program did not end:\n{log}")
    return [[(word, flags >> 4 & 3, code) for word, flags, code in
             struct.iter_unpack(">IHH", saved[at:at + 8 * count])] for at, count in places]


def launch(folder, core, seconds):
    """One run of the emulator; what it logged."""
    (folder / "core").write_bytes(core)
    # A configuration needs a device; this one does nothing.
    (folder / "s370.cnf").write_text(
        "ARCHMODE S/370\nCPUSERIAL 000001\nCPUMODEL 3033\nMAINSIZE 16\nXPNDSIZE 0\nNUMCPU 1\n"
        "CNSLPORT 0\nPANRATE FAST\n000E 1403 printer\n", encoding="ascii")
    (folder / "s370.rc").write_text(
        f"loadcore core 0\nrestart\npause {seconds}\nsavecore saved 0 {len(core) - 1:X}\nquit\n",
        encoding="ascii")
    done = subprocess.run(
        [HERCULES, "-d", "-f", "s370.cnf"], cwd=folder, stdin=subprocess.DEVNULL, timeout=120,
        env={**os.environ, "HERCULES_RC": "s370.rc"}, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def is_here():
    """Whether the emulator is installed."""
    return shutil.which(HERCULES) is not None


def version():
    """What the emulator calls itself."""
    done = subprocess.run([HERCULES, "--version"], capture_output=True, text=True, check=False,
                          timeout=100)
    return (done.stdout + done.stderr).splitlines()[0]
