"""Prints modyn-runtime/src/scalar/near_pi.rs: sines of the numbers nearest to multiples of pi.

    python3 -m venv VENV && VENV/bin/pip install mpmath==1.4.1 numpy==2.4.6
    VENV/bin/python tools/sine/table.py > modyn-runtime/src/scalar/near_pi.rs
"""

import mpmath
import numpy

mpmath.mp.prec = 300
#: Rows of a precision: so many that are nearest to a multiple, and so many spread over the range.
NEAREST, SPREAD = 24, 16


def rows(kind, limit):
    """The number next to each multiple of pi below the limit."""
    found = []
    for k in range(1, int(limit / mpmath.pi) + 1):
        x = kind(float(k * mpmath.pi)) if kind is numpy.float32 else float(k * mpmath.pi)
        if x < limit:
            found.append((abs(mpmath.sin(mpmath.mpf(float(x)))), k, float(x)))
    found.sort()
    nearest, rest = found[:NEAREST], sorted(found[NEAREST:], key=lambda row: row[1])
    spread = [rest[i * (len(rest) - 1) // (SPREAD - 1)] for i in range(SPREAD)]
    return sorted((x, float(mpmath.sin(mpmath.mpf(x)))) for _, _, x in nearest + spread)


def main():
    print("//! Numbers next to multiples of pi, and their sines, within the fast reduction.")
    print("//!")
    print("//! Made with mpmath by `tools/sine/table.py`.")
    for name, kind, limit in (("F64", float, 262_144), ("F32", numpy.float32, 4096)):
        table = rows(kind, limit)
        print(f"\n/// Angles that `{name.lower()}` holds exactly, and their sines rounded to double precision.")
        print("#[rustfmt::skip]")
        print("#[allow(clippy::unreadable_literal, clippy::approx_constant)]")
        print(f"pub(crate) const {name}: [(f64, f64); {len(table)}] = [")
        for x, sine in table:
            print(f"    ({x!r}, {sine!r}),")
        print("];")


if __name__ == "__main__":
    main()
