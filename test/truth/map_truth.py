"""Summits of a height map and its statistics by numpy, written from the definitions.

A map is an array of rows (along y) by columns (along x); a missing pixel is NaN.
"""

import numpy as np

RADII = ("neighbours", "geometric", "paraboloid")


def levelled(heights, how="plane"):
    """Heights above the plane of least squares, above the mean, or as they are."""
    if how == "none":
        return heights
    good = np.isfinite(heights)
    v, u = np.indices(heights.shape)
    columns = [np.ones(good.sum())]
    if how == "plane":
        columns += [u[good] - u[good].mean(), v[good] - v[good].mean()]
    known = np.stack(columns, axis=1)
    # A number first: differences keep their digits.
    left = heights - heights[good].mean()
    for _ in range(2):
        left[good] -= known @ np.linalg.lstsq(known, left[good], rcond=None)[0]
    return left


def surroundings(h, mirror):
    """near[1 + dy, 1 + dx, row, column]: a pixel and its eight neighbours. Beyond the edge, and
    for what is missing, NaN, or by the mirror what stands on the other side."""
    padded = np.pad(h, 1, mode="reflect") if mirror else np.pad(h, 1, constant_values=np.nan)
    rows, columns = h.shape
    near = np.array([[padded[i:i + rows, j:j + columns] for j in range(3)] for i in range(3)])
    if mirror:
        near = np.where(np.isnan(near), near[::-1, ::-1], near)
    return near


def higher_or_equal(near):
    """How many of the eight neighbours are not lower; a missing one is."""
    with np.errstate(invalid="ignore"):
        return (near >= near[1, 1]).sum(axis=(0, 1)) - 1


def ridge_samples(h, near, plain):
    """Pixels with one or two neighbours that are not lower, the highest first, each at
    least 2.5 pixels from every summit and from each other."""
    taken = np.pad(plain, 2)
    disk = np.hypot(*np.mgrid[-2:3, -2:3]) < 2.5
    ridges = np.argwhere(np.isin(higher_or_equal(near), (1, 2)) & np.isfinite(h))
    chosen = []
    for row, column in ridges[np.argsort(-h[tuple(ridges.T)], kind="stable")]:
        if not (taken[row:row + 5, column:column + 5] & disk).any():
            taken[row + 2, column + 2] = True
            chosen.append((row, column))
    return chosen


def curvature(near, dx, dy, rule):
    """By second differences; NaN in one direction takes the other."""
    lines_x = 2 * near[:, 1] - near[:, 0] - near[:, 2]
    lines_y = 2 * near[1, :] - near[0, :] - near[2, :]
    if rule == "paraboloid":
        with np.errstate(invalid="ignore"):
            kx, ky = (np.nansum(lines, axis=0) / np.isfinite(lines).sum(axis=0)
                      for lines in (lines_x, lines_y))
    else:
        kx, ky = lines_x[1], lines_y[1]
    kx, ky = kx / dx ** 2, ky / dy ** 2
    kx, ky = np.where(np.isnan(lines_x[1]), ky, kx), np.where(np.isnan(lines_y[1]), kx, ky)
    if rule == "geometric":
        return np.where((kx > 0) & (ky > 0), np.sqrt(np.abs(kx)) * np.sqrt(np.abs(ky)), 0.0)
    return (kx + ky) / 2


def vertex(before, middle, behind, most=np.inf):
    """Step in pixels and rise of the vertex of the parabola through three pixels; one that is
    bent more than `most` rises as one that is bent so much."""
    bend, difference = 2 * middle - before - behind, behind - before
    if not abs(difference) <= bend or bend <= 0:
        return 0.0, 0.0
    return difference / bend / 2, difference ** 2 / bend / 8 * min(1.0, most / bend)


def summits(heights, dx, dy, rule="eight", radius=None, level="plane"):
    """x, y, height and radius of all summits, a row each, and how many of them fill ridges."""
    h = levelled(heights, level)
    contact = rule == "contact"
    near = surroundings(h, contact)
    radius = radius or ("geometric" if contact else "neighbours")
    # A plane has no curvature, but for its mirror: heights as they are have it to all digits.
    raw = surroundings(heights, False)
    if contact:
        raw = np.where(np.isfinite(raw).all(axis=(0, 1)), raw, near)
    bends = curvature(raw, dx, dy, radius)
    usual = curvature(raw, dx, dy, "neighbours")
    if contact:
        plain = (higher_or_equal(near) == 0) & np.isfinite(h)
    else:
        with np.errstate(invalid="ignore"):
            plain = (near < near[1, 1]).sum(axis=(0, 1)) == 8
    found = []
    for row, column in np.argwhere(plain & (usual > 0)):
        # A paraboloid that is no cap leaves it to the neighbours.
        bend = bends[row, column]
        found.append((row, column, 1 / (bend if bend > 1e-9 * usual[row, column] else
                                        usual[row, column])))
    number = len(found)
    if contact:
        most = 4 * np.median([r for _, _, r in found]) if found else np.inf
        for row, column in ridge_samples(h, near, plain):
            bend = max(usual[row, column], 1 / most)
            if bend > 0:
                found.append((row, column, 1 / bend))
    sharpest = 4 / np.median([r for _, _, r in found[:number]]) if number else np.inf
    rows = []
    for row, column, r in found:
        step_x = step_y = rise_x = rise_y = 0.0
        if contact:
            step_x, rise_x = vertex(*near[1, :, row, column], sharpest * dx ** 2)
            step_y, rise_y = vertex(*near[:, 1, row, column], sharpest * dy ** 2)
        rows.append(((column + step_x) * dx, (row + step_y) * dy,
                     h[row, column] + rise_x + rise_y, r))
    return np.array(rows).reshape(-1, 4), len(found) - number


def mean_square(h, axis, spacing, order):
    """Of the differences over the spacing. Beside missing pixels a difference counts by the share
    of its neighbouring lines on which the same pixels are there."""
    h = h if axis else h.T
    there = np.isfinite(h)
    whole = np.lib.stride_tricks.sliding_window_view(there, order + 1, axis=1).all(axis=-1)
    beside = np.pad(whole.astype(float), ((1, 1), (0, 0)))
    lines = np.pad(np.ones(len(h)), 1)
    share = (beside[:-2] + beside[2:]) / (lines[:-2] + lines[2:])[:, None]
    values = np.diff(h, order, axis=1)[whole] / spacing ** order
    return (share[whole] * values ** 2).sum() / share[whole].sum()


def statistics(heights, dx, dy, level="plane"):
    """Moments by differences and Nayak's expectations of them."""
    h = levelled(heights, level)
    found = {"m0": np.nanvar(h),
             "m2 along x": mean_square(h, 1, dx, 1),
             "m2 along y": mean_square(h, 0, dy, 1),
             "m4 along x": mean_square(h, 1, dx, 2),
             "m4 along y": mean_square(h, 0, dy, 2)}
    m0 = found["m0"]
    m2, m4 = ((found[f"m{n} along x"] + found[f"m{n} along y"]) / 2 for n in (2, 4))
    found["rms height"] = np.sqrt(m0)
    found["rms slope"] = np.sqrt(2 * m2)
    found["Nayak's alpha"] = m0 * m4 / m2 ** 2
    return found


def nayak(m0, m2, m4):
    """Density, mean height, deviation of heights and mean curvature of the summits of an isotropic
    Gaussian surface (Nayak 1971; Bush, Gibson and Keogh 1976)."""
    alpha = m0 * m4 / m2 ** 2
    return (m4 / (6 * np.pi * np.sqrt(3) * m2), 4 * np.sqrt(m0 / (np.pi * alpha)),
            np.sqrt((1 - 0.8968 / alpha) * m0), 8 / 3 * np.sqrt(m4 / np.pi))
