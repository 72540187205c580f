"""Ways to spoil a text, for the fuzzer: numbers, fields, bytes, lines."""

import re

NUMBERS = (
    b"0 -0 1 -1 2 1e308 -1e308 1.7976931348623157e308 1.8e308 1e309 1E-320 5e-324 2e-324 1e-308 "
    b"2.2250738585072014e-308 0.5 0.5000001 0.49999999999999994 0.50000000000000011 -0.999999 -1.0 "
    b"NaN nan Infinity -Inf +inf 1e 1e+ 1d400 1q5 0x10 1,5 1.2.3 .e1 . + - 1e-400 1e999999999 "
    b"1e-999999999 1e99999999999999999999 2147483647 2147483648 -2147483648 9223372036854775807 "
    b"9223372036854775808 99999999999999999999 123456789012345678901234567890 "
    b"0.1234567890123456789012345 00000000000000000000000000001 1e75 7.2e75 7.3e75 5.4e-79 1e-79 "
    b"3.4e38 3.5e38 1e-38 1e-45 1e-46 4e-46 1e150 1e-150 1e100 1e-100 1e15 1e-15 1e16 16777217 "
    b"999999 1000001 2000000000 3*1 0*1 999999999*1 2147483647*1 -1*2 4*0.42 "
    b"6.283185307179586 1e5 1e-5 0.3 2.54").split()
FIELDS = (b"1E70 9E99 1E-9 1E-70 -.001 0.000 99999 -9999 1+30 1-30 1D5 NAN INF 1E999 9E9 1E9 1. "
          b".4999 .5001 .5 -1. -.99 1E-79 7E75 E5 +-1 0 -0 -0. 1E+").split()
ODD_BYTES = [b"\0", b"\x1b[31m", b"\x7f", b"\xff\xfe", b"\xc3\xa9", b"\xc2\x9b", b"\xe2\x80\xae",
             b"\xef\xbb\xbf", b"\t", b"\r", b"\r\n", b"\n\n\n", b"'", b'"', b"!", b"&", b"/", b"=",
             b",", b",,", b"*", b"(", b")", b"%", b"\\", b" ", b"\x0b", b"\x0c", b"\x1a", b"\x80",
             b"\xed\xa0\x80", b"\xf5"]
TOKEN = re.compile(rb"[^\s,=/&']+")
NUMBER = re.compile(rb"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?(?![\w.])")


def pick_span(rng, pattern, text):
    spans = [match.span() for match in pattern.finditer(text)]
    return rng.choice(spans) if spans else (0, 0)


def replace(text, span, piece):
    return text[:span[0]] + piece + text[span[1]:]


def change_number(rng, text):
    return replace(text, pick_span(rng, NUMBER, text), rng.choice(NUMBERS))


def change_field(rng, text):
    """A number in its columns of a card."""
    first, last = pick_span(rng, NUMBER, text)
    width = last - first
    return replace(text, (first, last), rng.choice(FIELDS)[:width].rjust(width))


def nudge_number(rng, text):
    first, last = pick_span(rng, NUMBER, text)
    try:
        value = float(text[first:last].lower().replace(b"d", b"e") or b"0")
    except ValueError:
        return text
    value *= rng.choice([2.0, 0.5, -1.0, 1 + 1e-15, 1e3, 1e-3, 10 ** rng.uniform(-30, 30), 0.999])
    return replace(text, (first, last), (b"%.17g" if rng.random() < 0.5 else b"%.3g") % value)


def swap_tokens(rng, text):
    one, two = sorted([pick_span(rng, TOKEN, text), pick_span(rng, TOKEN, text)])
    if one[1] > two[0]:
        return text
    return (text[:one[0]] + text[two[0]:two[1]] + text[one[1]:two[0]] + text[one[0]:one[1]]
            + text[two[1]:])


def copy_token(rng, text):
    first, last = pick_span(rng, TOKEN, text)
    at = rng.randint(0, len(text))
    return text[:at] + text[first:last] + rng.choice([b" ", b"", b", "]) + text[at:]


def drop_token(rng, text):
    return replace(text, pick_span(rng, TOKEN, text), b"")


def flip_bit(rng, text):
    if not text:
        return text
    at = rng.randrange(len(text))
    return text[:at] + bytes([text[at] ^ (1 << rng.randrange(8))]) + text[at + 1:]


def odd_bytes(rng, text):
    at = rng.randint(0, len(text))
    return text[:at] + rng.choice(ODD_BYTES) * rng.choice([1, 1, 1, 3]) + text[at:]


def drop_bytes(rng, text):
    at = rng.randint(0, len(text))
    return text[:at] + text[at + rng.choice([1, 1, 2, 7, 80]):]


def truncate(rng, text):
    return text[:rng.randint(0, len(text))]


def lines_about(rng, text):
    lines = text.split(b"\n")
    one, two = rng.randrange(len(lines)), rng.randrange(len(lines))
    what = rng.randrange(6)
    if what == 0:
        del lines[one]
    elif what == 1:
        lines.insert(one, lines[two])
    elif what == 2:
        lines[one], lines[two] = lines[two], lines[one]
    elif what == 3:
        lines[one] = lines[one][:rng.randint(0, len(lines[one]))]
    elif what == 4:
        lines[one] += rng.choice([b" ", b"x", b"1,"]) * rng.choice([10, 1000, 100000])
    else:
        lines.insert(one, b"")
    return b"\n".join(lines)


def line_ends(rng, text):
    return text.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b" ", b"\n\r", b""]))


def much(rng, text):
    """A great many of something."""
    n = rng.choice([100, 1000])
    piece = rng.choice([
        b"&motion x_first = 1 /\n", b"&x /\n", b"& ", b"&a b = (", b"'", b'"', b"!\n", b"=", b",",
        b"&surfaces deck = ", b"\n", b"\xff", b"1*", b"a=1 ", b"/", b"positions = 3, ", b" " * 100])
    at = rng.choice([0, len(text), rng.randint(0, len(text))])
    return text[:at] + piece * n + text[at:]


def noise(rng, _text):
    return rng.randbytes(rng.choice([1, 10, 1000, 20000]))


def empty(rng, _text):
    return rng.choice([b"", b"\n", b" ", b"\n\n\n\n", b"\0", b"\xef\xbb\xbf", b"&", b"!", b"/"])


GENTLE = [change_number, change_field, nudge_number, nudge_number]
ROUGH = [swap_tokens, copy_token, drop_token, flip_bit, odd_bytes, drop_bytes, truncate,
         lines_about, line_ends, much, noise, empty]


def mutate(rng, text):
    # Half of the texts keep their form and get other numbers: they reach the solvers.
    gentle = rng.choice([0.3, 1.0])
    for _ in range(rng.choice([1, 1, 1, 2, 2, 3, 5])):
        text = rng.choice(GENTLE if rng.random() < gentle else ROUGH)(rng, text)
    return text
