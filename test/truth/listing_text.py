"""SECTIONS I to V of the program of 1976, read from Appendix 4 of the thesis a second time.

The first text is `src/original`. This one was written without it, in the numbers of
`short_numbers`, with the names and the order of operations of the listing. The readings of the
scan are those of reference_output/faults/listing_port_scan.md: `.5 + RU` in the height of an upper
centre (deviation a), one computation of SEP before the loop over the list (d), and SEPMIN, MNU, MNL
and the upper model with as many places as NU needs (h). Where the listing reads beyond its list or
takes the root of a negative number, `StoppedError` has the position.
"""

import re
from dataclasses import dataclass, field
from decimal import ROUND_HALF_UP, Decimal
from fractions import Fraction

from mpmath import mp
from short_numbers import Short, cut, of_angle, power_three_halves, square_root

ZERO, ONE, TWO, HUNDRED = (cut(n) for n in (0, 1, 2, 100))
POSITIONS, NAPMX, PLACES = 100, 25, 37
# Columns of the fields of cards 2 and 3 (FORMAT 3), 4 (FORMAT 4) and of an asperity (FORMAT 10):
# width and places behind an implied point.
MODEL_CARD = ((5, 0), (5, 3), (5, 3), (10, 0), (5, 3), (10, 0), (7, 4))
ANGLES_CARD = ((8, 4), (8, 4), (7, 3), (7, 3))
ASPERITY_CARD = ((6, 3), (6, 3), (7, 4))


class StoppedError(Exception):
    """The listing leaves its arrays, or the numbers that exist, at a position (from 1)."""

    def __init__(self, position):
        super().__init__(position)
        self.position = position


@dataclass
class Printed:
    """Contacts with a load or a touch, step after step, and the columns of Table VI."""

    contacts: list = field(default_factory=list)
    table_vi: dict = field(default_factory=dict)
    stopped: int = 0


def fields(card, widths):
    """Numbers of a card: blanks are zeros, and a field without a point has an implied one."""
    at = 0
    for width, places in widths:
        text = card.ljust(at + width)[at:at + width].lstrip().replace(" ", "0")
        at += width
        digits = re.fullmatch(r"([-+]?)(\d*)(\.?)(\d*)", text)
        whole = int((digits[1] + digits[2] + digits[4]) if digits[2] + digits[4] else 0)
        yield Fraction(whole, 10 ** (len(digits[4]) if digits[3] else places))


def run(text):
    """The program on the text of a deck."""
    printed = Printed()
    try:
        sections(text.splitlines(), printed)
    except StoppedError as stopped:
        printed.stopped = stopped.position
    return printed


def sections(cards, printed):
    # SECTION I
    cfl, cfp = cut("2.54"), cut("0.6894")
    xuslop, yuslop, xlslop, ylslop = map(cut, ("0.00400", "-0.00058", "-0.00067", "-0.00045"))
    wlimit = cut(65) * cut("9.8") / cut("2.205")
    dxdisp, dydisp = cut("0.10"), ZERO
    thousandth = cut("0.0010")
    difa, difc, tlod, tar, appr_, slop = (
        [ZERO, cut(n)] for n in (100, 100, 10000, 100, 100, 100))
    pt = [0, 100]
    cp = sumlod = sumar = sumapp = sumpos = sumdfa = sumdfc = sumslo = ZERO
    isumpt = 0

    # SECTION II
    card = [list(fields(cards[i], w)) for i, w in ((1, MODEL_CARD), (2, MODEL_CARD),
                                                   (3, ANGLES_CARD))]
    nu, nl = int(card[0][0]), int(card[1][0])
    ru, zumax, eu, muu = map(cut, card[0][1:5])
    rl, zlmax, el, mul = map(cut, card[1][1:5])
    widthl = cut(card[1][6])
    thetau, thetal, xdispl, ydispl = map(cut, card[2])
    asperities = [list(map(cut, fields(c, ASPERITY_CARD))) for c in cards[4:4 + nu + nl]]

    def turned(x, y, theta):
        sine, cosine = of_angle(mp.sin, theta), of_angle(mp.cos, theta)
        return x * cosine - y * sine, x * sine + y * cosine

    upper, lower = [], []
    for x, y, z in asperities[:nu]:
        xs, ys = turned(x, y, thetau)
        zs = cut("0.5") + ru - z + xs * xuslop + ys * yuslop
        upper.append([xs * cfl, ys * cfl, zs * cfl])
    for x, y, z in asperities[nu:]:
        xs, ys = turned(x, y, thetal)
        ys = widthl - ys
        zs = z - rl + xs * xlslop + ys * ylslop
        lower.append([xs * cfl, ys * cfl, zs * cfl])
    xdispl, ydispl, ru, rl = xdispl * cfl, ydispl * cfl, ru * cfl, rl * cfl
    zumax, zlmax, eu, el = zumax * cfl, zlmax * cfl, eu * cfp, el * cfp

    # SECTION III
    q = ru / (ru + rl)
    ep = ONE / ((ONE - mul * mul) / el + (ONE - muu * muu) / eu)
    r = rl * ru / (ru + rl)
    appr = cut("0.5") * cfl
    zmax = zlmax if zumax < zlmax else zumax
    ofstmx = TWO * square_root(ru * zmax)

    # SECTION IV
    for m in range(1, POSITIONS + 1):
        # A
        places = max(nu, PLACES)
        sepmin, mnu, mnl = [HUNDRED] * places, [0] * places, [0] * places
        for centre in upper:
            centre[0] = centre[0] + dxdisp
            centre[1] = centre[1] + dydisp
        xdispl, ydispl = xdispl + dxdisp, ydispl + dydisp

        # B
        for j, k, dist in near(upper, lower, ofstmx):
            distq, distl = dist * q, dist * (ONE - q)
            du2, dl2 = ru * ru - distq * distq, rl * rl - distl * distl
            if du2 < ZERO or dl2 < ZERO:
                raise StoppedError(m)
            sep = (upper[j][2] - square_root(du2)) - (lower[k][2] + square_root(dl2))
            for at in range(nu):
                if sep < sepmin[at]:
                    for line, entry in ((sepmin, sep), (mnu, j + 1), (mnl, k + 1)):
                        line[at:nu] = [entry] + line[at:nu - 1]
                    break
        if mnu[0] == 0:
            raise StoppedError(m)
        dappr = sepmin[0]

        # D
        flag = False
        for nap in range(1, NAPMX + 1):
            if flag:
                break
            appr = appr - dappr
            for centre in upper:
                centre[2] = centre[2] - dappr
            nctpt = 0
            tarea = tload = tareap = ZERO
            for at in range(nu):
                sepmin[at] = sepmin[at] - dappr
                if ZERO < sepmin[at]:
                    continue
                if mnu[at] == 0:
                    raise StoppedError(m)
                u, s = upper[mnu[at] - 1], lower[mnl[at] - 1]
                dx, dy = u[0] - s[0], u[1] - s[1]
                dist = square_root(dx * dx + dy * dy)
                z = u[2] - s[2]
                slope = dist / z
                xca, yca = u[0] + q * (s[0] - u[0]), u[1] + q * (s[1] - u[1])
                nctpt += 1
                duma = appr
                carea = careap = cload = ctavpr = ctmxpr = ZERO
                if sepmin[at] < ZERO:
                    w = rl + ru - square_root(dist * dist + z * z)
                    if w < ZERO:
                        raise StoppedError(m)
                    carea = cut("3.1416") * w * r
                    cload = cut(4) / cut(3) * ep * square_root(r) * power_three_halves(w)
                    ctavpr = cload / carea
                    ctmxpr = cut("1.5") * ctavpr
                    cf = ONE / square_root(ONE + slope * slope)
                    careap = cf * carea
                    flag = flag or wlimit <= cload
                    tarea, tareap, tload = tarea + carea, tareap + careap, tload + cload
                    if flag:
                        difca = HUNDRED * (carea - careap) / carea
                        extremes(slop, slope)
                        extremes(difc, difca)
                        sumdfc, cp, sumslo = sumdfc + difca, cp + ONE, sumslo + slope
                printed.contacts.append((m, *map(float, (xdispl, ydispl)), nap, float(duma), nctpt,
                                         *map(float, (xca, yca)), mnu[at], mnl[at],
                                         *map(float, (carea, careap, slope, cload, ctavpr, ctmxpr)),
                                         int(wlimit <= cload)))
            if nctpt == places:
                raise StoppedError(m)
            dappr = sepmin[nctpt] if sepmin[nctpt] < thousandth else thousandth

        # E
        difa_ = HUNDRED * (tarea - tareap) / tarea
        for kept, value in ((tlod, tload), (tar, tarea), (pt, nctpt), (appr_, duma), (difa, difa_)):
            extremes(kept, value)
        sumlod, sumar, sumapp = sumlod + tload, sumar + tarea, sumapp + duma
        sumpos, sumdfa, isumpt = sumpos + ONE, sumdfa + difa_, isumpt + nctpt

    # SECTION V
    average = int(float(Short(isumpt) / sumpos))
    printed.table_vi = {
        "TOTAL LOAD": columns(tlod, sumlod, sumpos, 0),
        "TOTAL CONTACT AREA": columns(tar, sumar, sumpos, 4),
        "POINTS": [Decimal(n) for n in (*pt, average)],
        "APPROACH": columns(appr_, sumapp, sumpos, 4),
        "AREAS": columns(slop, sumslo, cp, 3),
        "JECTED CONTACT AREA": columns(difa, sumdfa, cp, 1),
        "CONTACT AREAS": columns(difc, sumdfc, cp, 1),
    }


def near(upper, lower, ofstmx):
    """Pairs with DIST below OFSTMX in the order of the listing, DIST beside them.

    Doubles leave out pairs far away: short numbers have a relative error below 16**-5 an operation.
    """
    safe = float(ofstmx) ** 2 * 1.001
    places = [[(float(x), float(y)) for x, y, _ in model] for model in (upper, lower)]
    for j, (x, y) in enumerate(places[0]):
        for k, (s, t) in enumerate(places[1]):
            if (x - s) ** 2 + (y - t) ** 2 < safe:
                dx, dy = upper[j][0] - lower[k][0], upper[j][1] - lower[k][1]
                dist = square_root(dx * dx + dy * dy)
                if dist < ofstmx:
                    yield j, k, dist


def extremes(kept, value):
    """The greatest and the least value, beside the start values."""
    if kept[0] < value:
        kept[0] = value
    if value < kept[1]:
        kept[1] = value


def columns(kept, total, count, decimals):
    """Maximum, minimum and average as a field F prints them: rounded to the nearest.

    An average over no contact is infinite where its sum is not zero (deviation k).
    """
    unit = Decimal(1).scaleb(-decimals)
    if count.fraction == 0 != total.fraction:
        average = float("inf")
    else:
        average = total / count
    return [Decimal(value).quantize(unit, ROUND_HALF_UP) if value < float("inf") else value
            for value in map(float, (*kept, average))]
