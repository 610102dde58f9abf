"""Deviations by allantools for the tests of sagnac-analysis.

Writes testdata/reference/allantools_deviations.csv: series, deviation, m, value, number of terms.
The series come from the generator of NIST SP 1065, so that a test makes the same numbers:
  white  n_i/2147483647, 1500 values from n_0 on
  walk   the cumulative sum of (white - 1/2)
  phase  first differences of white (white phase noise)
Run: python tools/allantools_reference.py
"""

import csv
import pathlib

import allantools
import numpy as np

COUNT = 1500
RATE_HZ = 4.0
TABLE = pathlib.Path(__file__).parent.parent / "testdata/reference/allantools_deviations.csv"


def generator(count):
    n, values = 1234567890, []
    for _ in range(count):
        values.append(n / 2147483647)
        n = 16807 * n % 2147483647
    return np.array(values)


def main():
    white = generator(COUNT)
    series = {
        "white": white,
        "walk": np.cumsum(white - 0.5),
        "phase": np.diff(white, prepend=0.0),
    }
    functions = {
        "adev": (allantools.adev, 2),
        "oadev": (allantools.oadev, 2),
        "mdev": (allantools.mdev, 3),
        "tdev": (allantools.tdev, 3),
        "hdev": (allantools.ohdev, 3),
        "totdev": (allantools.totdev, 2),
        "theo1": (allantools.theo1, 1),
    }
    with open(TABLE, "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["series", "deviation", "m", "value", "terms"])
        for name, values in series.items():
            for kind, (function, share) in functions.items():
                factors = [1, 2, 3, 5, 8, 10, 17, 30, 64, 100, 123, 257, 400, 499, 500, 749, 750]
                if kind == "theo1":
                    factors = [10, 12, 30, 64, 100, 122, 256, 400, 600, 750, 1100, 1498]
                factors = [m for m in factors if share * m < COUNT]
                taus, got, _, terms = function(
                    values, rate=RATE_HZ, data_type="freq", taus=np.array(factors) / RATE_HZ
                )
                for tau, value, count in zip(taus, got, terms):
                    m = round(tau * RATE_HZ)
                    table.writerow([name, kind, m, repr(float(value)), int(count)])


if __name__ == "__main__":
    main()
