"""All contacts together, for boundary_truth.py: Galerkin's equations and which contacts open."""

from dataclasses import replace

import numpy as np

from boundary_patch import Failed, basis, circles_that_overlap, hertz_patch

# Degree of F; chord directions and nodes a chord; radial and angular nodes of a contact; nodes
# in use where another contact is near.
LEVELS = {"4": (4, 12, 8, 8, 20, (24, 72)), "6": (6, 16, 10, 10, 28, (32, 96)),
          "8": (8, 20, 12, 12, 36, (40, 128)), "10": (10, 26, 16, 14, 44, (48, 160)),
          "12": (12, 32, 18, 16, 52, (56, 192)), "14": (14, 40, 22, 18, 64, (64, 240))}


def inverse_distance(points, others):
    x = points[:, None, 0] - others[None, :, 0]
    y = points[:, None, 1] - others[None, :, 1]
    return 1 / np.sqrt(x * x + y * y)


def assemble(contacts, patches, modulus, level):
    """Galerkin's residual and matrix, and the error of the gap they leave."""
    degree, directions, chord, radial, angular, fine = level
    factor = 1 / (np.pi * modulus)
    targets = [p.nodes(radial, angular) for p in patches]
    places = [p.centre + p.scale * t[0] for p, t in zip(patches, targets)]
    tests = [basis(t[0], p.degree) * (t[1] / (2 * t[2]))[:, None] * p.scale ** 2 * p.peak
             for p, t in zip(patches, targets)]
    residual = [c.gap(x) for c, x in zip(contacts, places)]
    size = tests[0].shape[1]
    matrix = np.empty((len(patches) * size, len(patches) * size))
    for j, source in enumerate(patches):
        there = {}
        for i, target in enumerate(patches):
            block = np.s_[i * size:(i + 1) * size, j * size:(j + 1) * size]
            if i == j:
                value, change = source.own_displacement(targets[i][0], directions, chord)
                residual[i] = residual[i] + factor * value
                matrix[block] = factor * tests[i].T @ change
                continue
            apart = np.hypot(*(target.centre - source.centre))
            near = apart < 1.6 * source.scale + target.scale
            if near not in there:
                points, weights, root = source.nodes(*(fine if near else (radial, angular)))
                there[near] = (source.centre + source.scale * points,
                               source.peak * source.scale ** 2 * weights * root,
                               basis(points, degree)
                               * (source.peak * source.scale ** 2 * weights / (2 * root))[:, None])
            points, pressure, change = there[near]
            inverse = inverse_distance(places[i], points)
            residual[i] = residual[i] + factor * inverse @ pressure
            matrix[block] = factor * tests[i].T @ (inverse @ change)
    vector = np.concatenate([t.T @ r for t, r in zip(tests, residual)])
    return vector, matrix, size


def newton(contacts, patches, modulus, level):
    """Patches in equilibrium at one level."""
    patches = [p.raised(level[0]) for p in patches]
    vector, matrix, size = assemble(contacts, patches, modulus, level)
    for _ in range(25):
        # Rows and columns are scaled: loads differ by powers of ten.
        d = 1 / np.sqrt(np.abs(np.diag(matrix)))
        step = -d * np.linalg.solve(matrix * d[:, None] * d[None], d * vector)
        most = np.abs(step).max()
        share = 1.0
        while True:
            try:
                trial = [replace(p, coefficients=p.coefficients
                                 + share * step[k * size:(k + 1) * size]).recentred()
                         for k, p in enumerate(patches)]
                vector, matrix, size = assemble(contacts, trial, modulus, level)
                break
            except Failed:
                share /= 2
                if share < 1e-3:
                    raise
        patches = trial
        if share > 0.99 and most < 1e-8:    # quadratic: what is left is at rounding
            return patches
    raise Failed(f"Newton's method stopped at a step of {most:.1e}")


def first_guess(contacts, modulus):
    """Discs whose neighbours act as P/(pi E* r) at their centre; None for one that opens."""
    places = np.array([c.place for c in contacts])
    given = np.array([c.penetration for c in contacts])
    radius = np.array([c.radius for c in contacts])
    difference = places[:, None] - places[None]
    distance = np.hypot(difference[..., 0], difference[..., 1])
    np.fill_diagonal(distance, np.inf)
    left = given.copy()
    for _ in range(200):
        load = 4 / 3 * modulus * np.sqrt(radius) * np.maximum(left, 0) ** 1.5
        left = 0.5 * left + 0.5 * (given - (load / (np.pi * modulus * distance)).sum(1))
    # A neighbour's slope moves the deepest point away from it.
    shift = radius[:, None] * (difference * (load / (np.pi * modulus * distance ** 3))[..., None]
                               ).sum(1)
    return [None if w <= 0 else hertz_patch(c, w, modulus, s)
            for c, w, s in zip(contacts, left, shift)]


def outside(points, patches, modulus):
    """Displacement at points outside the areas, not at an edge."""
    total = np.zeros(len(points))
    for p in patches:
        near = np.hypot(*(points - p.centre).T).min() < 2 * p.scale
        at, weights, root = p.nodes(*((40, 160) if near else (8, 24)))
        at = p.centre + p.scale * at
        pressure = p.peak * p.scale ** 2 * weights * root
        total += inverse_distance(points, at) @ pressure
    return total / (np.pi * modulus)


def is_inside(points, patch):
    """Inside the area widened by 3 %: sums are too coarse for points at its edge."""
    local = (points - patch.centre) / patch.scale
    r = np.hypot(local[:, 0], local[:, 1])
    theta = 2 * np.pi * np.arange(720) / 720
    direction = np.stack([np.cos(theta), np.sin(theta)], -1)
    edge = patch.roots(np.zeros_like(direction), direction)
    angle = np.mod(np.arctan2(local[:, 1], local[:, 0]), 2 * np.pi)
    return r < 1.03 * np.interp(angle, np.append(theta, 2 * np.pi), np.append(edge, edge[0]))


def clearance(contact, contacts, closed, modulus):
    """Where, in a contact's undeformed overlap and outside the areas, the gap left is least, and
    that gap; None when the areas cover the overlap."""
    axis = np.linspace(-1.6 * contact.circle, 1.6 * contact.circle, 40)
    points = contact.place + np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    gap = np.min([c.gap(points) for c in contacts], axis=0)
    points, gap = points[gap < 0], gap[gap < 0]
    for patch in closed:
        keep = ~is_inside(points, patch)
        points, gap = points[keep], gap[keep]
    if not len(points):
        return None
    left = gap + outside(points, closed, modulus)
    return points[left.argmin()], left.min()


def least_gap(contacts, patches, modulus):
    """The least gap left outside the areas over the largest penetration."""
    closed = [p for p in patches if p is not None]
    found = [clearance(c, contacts, closed, modulus) for c in contacts]
    return (min((f[1] for f in found if f is not None), default=0.0)
            / max(c.penetration for c in contacts))


def side(contacts, patches):
    """Least gap of the other pairs less the own gap, in the areas: positive when each area lies
    where its own pair is the nearest, as the polynomials take for granted."""
    least = np.inf
    for k, patch in enumerate(patches):
        if patch is not None and len(contacts) > 1:
            inner = patch.centre + patch.scale * patch.nodes(8, 64)[0]
            others = np.min([c.gap(inner) for c in contacts[:k] + contacts[k + 1:]], axis=0)
            least = min(least, (others - contacts[k].gap(inner)).min())
    return float(least)


def solve(contacts, modulus, level, start=None):
    """Patches of the contacts, None for those that stay open, through degrees 2, 4, ..."""
    patches = list(start or first_guess(contacts, modulus))
    top = LEVELS[level]
    for _ in range(4 + 2 * len(contacts)):
        shut = [k for k, p in enumerate(patches) if p is not None]
        group, now = [contacts[k] for k in shut], [patches[k] for k in shut]
        try:
            for degree in range(max(p.degree for p in now), top[0] + 1, 2):
                settings = (top if degree == top[0] else
                            LEVELS.get(str(degree), (2, 10, 6, 6, 16, (16, 48))))
                now = newton(group, now, modulus, settings)
        except Failed:
            # The weakest opens, and closes again below if that was wrong.
            if len(shut) == 1:
                raise
            patches[min(shut, key=lambda k: patches[k].scale)] = None
            continue
        reopened = False
        for k, c in enumerate(contacts):
            if patches[k] is None:
                found = clearance(c, contacts, now, modulus)
                if found is not None and found[1] < -1e-6 * c.penetration:
                    patches[k] = hertz_patch(c, -found[1], modulus, found[0] - c.place)
                    reopened = True
        if reopened:
            continue
        for k, p in zip(shut, now):
            patches[k] = p
        return patches
    raise Failed("which contacts stay open was not settled")


def evaluate(contacts, modulus, levels=("4", "6")):
    """Loads of contacts together and each alone, at rising levels; a dict, the last level's.

    contacts: list of `Contact`; modulus: E*; levels: names in LEVELS, the degree of F. `factor` is
    together over alone, `uncertainty` what the last level changed of it, `loads` and `loads_alone`
    by contact (zero: pushed open), `hertz` and `hertz_normal` sums of the independent model,
    `least_gap` and `side` as above: not negative. Raises `Failed`.
    """
    rows, together, alone = [], None, [None] * len(contacts)
    for level in levels:
        alone = [solve([c], modulus, level, a) for c, a in zip(contacts, alone)]
        together = alone[0] if len(contacts) == 1 else solve(contacts, modulus, level, together)
        rows.append(([0.0 if p is None else p.load() for p in together],
                     [a[0].load() for a in alone]))
    factors = [sum(r[0]) / sum(r[1]) for r in rows]
    own_side = side(contacts, together)
    if own_side <= 0:
        raise Failed("areas run into each other")
    return {"together": sum(rows[-1][0]), "alone": sum(rows[-1][1]), "factor": factors[-1],
            "uncertainty": abs(factors[-1] - factors[-2]) if len(factors) > 1 else np.nan,
            "factors": factors, "loads": rows[-1][0], "loads_alone": rows[-1][1],
            "hertz": sum(c.hertz(modulus) for c in contacts),
            "hertz_normal": sum(c.hertz_normal(modulus) for c in contacts),
            "least_gap": least_gap(contacts, together, modulus), "side": own_side,
            "overlapping_circles": circles_that_overlap(contacts), "patches": together}
