"""Card decks for tests: written in the original's columns from plain numbers."""

import random


def number(value, width, decimals):
    text = f"{value:{width}.{decimals}f}"
    if len(text) > width:
        text = text.replace("0.", ".", 1)
    if len(text) != width:
        raise ValueError(f"{value} does not fit F{width}.{decimals}")
    return text


def write_deck(path, upper, lower, width=3.455, angles=(0.0, 0.0), displacement=(0.0, 0.0)):
    """A model is a dict of radius, height_max, modulus, ratio, stress, asperities [(x, y, z)]."""
    lines = ["NO  YES "]
    for model in (upper, lower):
        lines.append(f"{len(model['asperities']):5d}" + number(model["radius"], 5, 3)
                     + number(model["height_max"], 5, 3) + f"{model['modulus']:9.0f}."
                     + number(model["ratio"], 5, 3) + f"{model['stress']:9.0f}.")
    lines[-1] += number(width, 7, 4)
    lines.append(number(angles[0], 8, 4) + number(angles[1], 8, 4)
                 + number(displacement[0], 7, 3) + number(displacement[1], 7, 3))
    for model in (upper, lower):
        lines += [number(x, 6, 3) + number(y, 6, 3) + number(z, 7, 4)
                  for x, y, z in model["asperities"]]
    path.write_text("\n".join(lines) + "\n")
    return path


def random_model(rng, count, length, width, radius, height_max, modulus, ratio):
    asperities = [(round(rng.uniform(0.0, length), 3), round(rng.uniform(0.0, width), 3),
                   round(rng.uniform(0.3, 1.0) * height_max, 4)) for _ in range(count)]
    return {"radius": radius, "height_max": height_max, "modulus": modulus, "ratio": ratio,
            "stress": 11200.0, "asperities": asperities}


def random_deck(seed):
    """Keyword arguments of write_deck. The lower model reaches 4 in beyond the upper one."""
    rng = random.Random(seed)
    sizes = [(37, 75), (60, 200), (5, 300), (120, 40), (300, 500), (1, 400), (45, 1)]
    upper_count, lower_count = sizes[seed % len(sizes)]
    radii = [round(rng.uniform(0.3, 0.9), 3) for _ in range(2)]
    if min(upper_count, lower_count) == 1:
        radii = [9.0, 9.5]  # wide enough for one pair to stay a candidate over the whole sweep
    heights = [round(rng.uniform(0.05, 0.09), 3) for _ in range(2)]
    if min(upper_count, lower_count) == 1:
        heights = [0.9, 0.8]
    moduli = [float(rng.randrange(350000, 900000, 1000)) for _ in range(2)]
    ratios = [round(rng.uniform(0.2, 0.49), 3) for _ in range(2)]
    upper = random_model(rng, upper_count, 4.0, 3.0, radii[0], heights[0], moduli[0], ratios[0])
    lower = random_model(rng, lower_count, 8.0, 3.0, radii[1], heights[1], moduli[1], ratios[1])
    if lower_count == 1:
        lower["asperities"] = [(4.0, 1.5, 0.75)]
    angle = (round(rng.uniform(-0.02, 0.02), 4), round(rng.uniform(-0.02, 0.02), 4))
    offset = (round(rng.uniform(-1.0, 1.0), 3), round(rng.uniform(-1.0, 1.0), 3))
    return {"upper": upper, "lower": lower, "width": round(rng.uniform(3.0, 3.6), 4),
            "angles": angle, "displacement": offset}
