"""Philox4x32-10 in numpy, written from the paper (Salmon and others, SC11, 2011, section 3.3)."""

import numpy as np

LOW = np.uint64(0xFFFFFFFF)
SHIFT = np.uint64(32)
MULTIPLIERS = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
WEYL = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)


def philox(counters, key):
    """Words of N counters: arrays of shape (4, N)."""
    words = np.array(np.broadcast_arrays(*counters), dtype=np.uint64)
    keys = [np.uint64(part) for part in key]
    for _ in range(10):
        first = words[0] * MULTIPLIERS[0]
        second = words[2] * MULTIPLIERS[1]
        words = np.array([(second >> SHIFT) ^ words[1] ^ keys[0], second & LOW,
                          (first >> SHIFT) ^ words[3] ^ keys[1], first & LOW])
        keys = [(old + step) & LOW for old, step in zip(keys, WEYL)]
    return words


def whole_number(upper, lower, count):
    """floor(u * count / 2**62), u made of the upper 31 bits of two words, in Python's integers."""
    return ((int(upper) >> 1 << 31 | int(lower) >> 1) * count) >> 62
