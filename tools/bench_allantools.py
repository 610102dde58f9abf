"""The peer of `cargo bench -p sagnac-analysis --bench deviations`: allantools.oadev on 1e7 samples at the same 94 averaging factors.

Usage: bench_allantools.py   (needs numpy, allantools; prints the seconds of three runs)
"""

import math
import time

import allantools
import numpy as np

SAMPLES = 10_000_000


def factors(samples: int) -> list[int]:
    """The distinct smallest m with m^99 >= 2^(p k), k = 0…99, 2^p the largest power of two within half the samples."""
    p = int(math.log2(samples // 2))
    out = set()
    for k in range(100):
        m = max(1, int(2 ** (p * k / 99)) - 1)
        while m**99 < 2 ** (p * k):
            m += 1
        out.add(m)
    return sorted(out)


def main() -> None:
    rate = np.random.default_rng(1).standard_normal(SAMPLES)
    taus = np.array(factors(SAMPLES), dtype=float)
    print(len(taus), "averaging times")
    for _ in range(3):
        begin = time.perf_counter()
        allantools.oadev(rate, rate=1.0, data_type="freq", taus=taus)
        print(f"{time.perf_counter() - begin:.2f} s")


if __name__ == "__main__":
    main()
