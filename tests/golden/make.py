#!/usr/bin/env python3
"""Makes phasors.json: chains, their exact steady motion, and the coefficients that made it.

Independent of core: the equations of motion as one matrix, solved with 50 digits. With displacements
Y_k exp(jwt), Y_0 given, and the dynamic stiffness Z_k = c_k + jwr_k of element k between masses k-1 and k:

    -w^2 m_k Y_k = Z_k (Y_{k-1} - Y_k) - Z_{k+1} (Y_k - Y_{k+1})        k = 1 ... n

Clamped: Y_{n+1} = 0, and element n+1 exerts F = Z_{n+1} Y_n on the ground. Free: Z_{n+1} = 0.

usage: make.py [--check]      --check: exit 1 if phasors.json is not what this makes; exit 2 without mpmath
"""
import json
import pathlib
import random
import sys

try:
    import mpmath
except ModuleNotFoundError:
    print("make.py: python3-mpmath is needed", file=sys.stderr)
    sys.exit(2)

mpmath.mp.dps = 50
FILE = pathlib.Path(__file__).with_name("phasors.json")


def phasor(amplitude_name, value):
    return {amplitude_name: float(abs(value)), "phase_rad": float(mpmath.arg(value))}


def case(name, boundary, masses, stiffness, damping, frequency_hz, table, phase):
    n, w = len(masses), 2 * mpmath.pi * mpmath.mpf(frequency_hz)
    Z = [mpmath.mpc(c, w * mpmath.mpf(r)) for c, r in zip(stiffness, damping)]
    if boundary == "free":
        Z.append(mpmath.mpc(0))
    Y = [mpmath.mpf(table) * mpmath.expj(mpmath.mpf(phase))]
    if n:
        A, b = mpmath.zeros(n), mpmath.zeros(n, 1)
        for k in range(n):
            A[k, k] = Z[k] + Z[k + 1] - w**2 * mpmath.mpf(masses[k])
            if k > 0:
                A[k, k - 1] = -Z[k]
            if k < n - 1:
                A[k, k + 1] = -Z[k + 1]
        b[0] = Z[0] * Y[0]
        Y += list(mpmath.lu_solve(A, b))
    force = phasor("amplitude_n", Z[-1] * Y[-1]) if boundary == "clamped" else None
    return {
        "name": name, "boundary": boundary, "masses_kg": masses, "frequency_hz": frequency_hz,
        "displacement": [phasor("amplitude_m", y) for y in Y], "force_on_ground": force,
        "stiffness_n_per_m": stiffness, "damping_n_s_per_m": damping,
    }


def drawn(source, boundary, n):
    """A chain whose numbers are exact in the file: three to five digits."""
    def log_uniform(low, high, digits):
        return float(f"{low * (high / low) ** source.random():.{digits}g}")

    elements = n + (boundary == "clamped")
    return case(
        f"drawn {boundary} n={n}", boundary,
        [log_uniform(1, 30, 4) for _ in range(n)],
        [log_uniform(5e3, 2e5, 5) for _ in range(elements)],
        [log_uniform(20, 400, 4) for _ in range(elements)],
        log_uniform(2, 12, 3), 0.003, round(source.uniform(-3, 3), 4))


def text():
    suspension = ("free", [250.0, 40.0], [180000.0, 20000.0], [900.0, 1500.0])
    cases = [
        case("two-mass suspension", *suspension, 3.0, 0.005, 0.0),
        case("two-mass suspension above resonance", *suspension, 11.0, 0.001, 1.0),
        case("two-mass clamped", "clamped", [12.5, 8.0], [24000.0, 15000.0, 9000.0], [60.0, 45.0, 30.0], 4.0, 0.002, 0.0),
        case("no mass", "clamped", [], [50000.0], [30.0], 4.0, 0.002, 0.3),
    ]
    source = random.Random(1)
    cases += [drawn(source, boundary, n) for n in (1, 2, 3, 5, 8, 16, 32) for boundary in ("free", "clamped")]
    convention = "y = A sin(wt + phase); force_on_ground: exerted by element n+1 on the ground"
    return json.dumps({"convention": convention, "cases": cases}, indent=1) + "\n"


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(f"{sys.argv[1]}: unknown; usage: make.py [--check]")
    made = text()
    if sys.argv[1:]:
        sys.exit(0 if FILE.read_text() == made else f"{FILE.name} is not what {pathlib.Path(__file__).name} makes")
    FILE.write_text(made)
