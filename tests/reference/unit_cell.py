"""Independent reference values for the plain-weave unit cell (paper, eqs 11-24).

    pip install mpmath scipy
    python unit_cell.py            # rewrite unit_cell.json beside this file (a few minutes, fixed seed)
    python unit_cell.py --check    # compare with the verification table, prove the solver, re-check unit_cell.json

Method, chosen to share nothing with a bracketed Newton on h1 with elliptic series:
  * 40-digit arithmetic (mpmath); every input is the exact value of the f64 written in the JSON;
  * arc length by quadrature of (13): with theta = pi x/(2w) the integrand has period pi and is analytic, so the
    trapezium rule converges geometrically (node count from its error bound). E(m) appears only in --check;
  * the unknown is the contact force F >= 0. Each yarn is inverted, h_i(F) from F_i(h_i) = F, and F follows from
    compatibility (22), h1(F) + h2(F) + d(F) = h01 + h02 - gap, whose left side increases with F. Both levels are
    derivative-free bracketing (Chandrupatla: bisection safeguarded inverse quadratic interpolation).

Units: mm and N throughout. Heights are null where both yarns are slack (they are not unique there).

Record fields beyond the obvious:
  rigid               a = b = 0, d(F) = 0
  *_in_plane_n        published: T (membrane_force "tension"); variational: T dS/d(2w); kawabata: T w/l
  *_projected_n       published only: T cos(alpha) (membrane_force "projected")
"""

import json
import random
import sys
from multiprocessing import Pool
from pathlib import Path

import mpmath as mp
from mpmath import mpf

mp.mp.dps = 40
SEED = 20060720
DIGITS = 18
LAWS = ("published", "variational", "kawabata")
OUTPUT = Path(__file__).with_suffix(".json")


# ---------------------------------------------------------------- fabrics (inputs are f64, as Rust will read them)

def table_fabric(denier, count_per_inch, warp_crimp, weft_crimp):
    """Both yarns from Table I: E = 96 GPa, rho = 1440 kg/m3, 2 w0 = 1/count."""
    ea_n = 96e9 * (denier / 9e6) / 1440.0
    w0_mm = 25.4 / count_per_inch / 2.0
    return tuple({"ea_n": ea_n, "w0_mm": w0_mm, "crimp": crimp} for crimp in (warp_crimp, weft_crimp))


FABRICS = {
    "S-720": table_fabric(1420.0, 20.0, 0.0218, 0.0139),
    "S-728": table_fabric(1500.0, 17.0, 0.0176, 0.0094),
    "high-crimp": ({"ea_n": 10000.0, "w0_mm": 0.635, "crimp": 0.25}, {"ea_n": 10000.0, "w0_mm": 0.635, "crimp": 0.12}),
    "unbalanced": ({"ea_n": 1e6, "w0_mm": 0.6, "crimp": 0.01}, {"ea_n": 1e3, "w0_mm": 0.9, "crimp": 0.03}),
}


# ---------------------------------------------------------------- one yarn

_SIN2 = {}


def sin2_nodes(n):
    """sin^2 at the n + 1 trapezium nodes of [0, pi/2]."""
    if n not in _SIN2:
        _SIN2[n] = [mp.sin(mp.pi * j / (2 * n)) ** 2 for j in range(n + 1)]
    return _SIN2[n]


def theta_mean(f, k):
    """(2/pi) * integral of f(sin^2 theta) over [0, pi/2]; singularities of f at sin^2 = -1/k^2.

    Trapezium error ~ exp(-4 n asinh(1/k)), pushed below 10^-(dps + 4).
    """
    n = 8
    rate = 4 * float(mp.asinh(1 / max(k, mpf("0.01"))))
    while n * rate < 2.302585 * (mp.mp.dps + 4):
        n += 4
    s = sin2_nodes(n)
    return ((f(s[0]) + f(s[n])) / 2 + mp.fsum(f(x) for x in s[1:n])) / n


def slope(w, h):
    return mp.pi * h / (2 * w)


def length(law, w, h):
    """S(w, h): sinusoid (13), or saw-tooth."""
    if law == "kawabata":
        return 2 * mp.sqrt(w * w + h * h)
    k = slope(w, h)
    return 2 * w * theta_mean(lambda s: mp.sqrt(1 + k * k * s), k)


def press(law, w, h):
    """F/T: contact force on the crossing yarn per unit tension."""
    if law == "kawabata":
        return 2 * h / mp.sqrt(w * w + h * h)
    k = slope(w, h)
    if law == "published":
        return 2 * k / mp.sqrt(1 + k * k)
    return mp.pi * k * theta_mean(lambda s: s / mp.sqrt(1 + k * k * s), k)  # dS/dh of (13)


def pull(law, w, h):
    """N/T: in-plane force per unit tension."""
    if law == "kawabata":
        return w / mp.sqrt(w * w + h * h)
    if law == "published":
        return mpf(1)
    k = slope(w, h)
    return theta_mean(lambda s: 1 / mp.sqrt(1 + k * k * s), k)  # dS/d(2w) of (13) at fixed h


def cos_alpha(w, h):
    return 1 / mp.sqrt(1 + slope(w, h) ** 2)


class Yarn:
    """One yarn at half-span w = stretch * w0 [mm]."""

    def __init__(self, law, given, stretch):
        self.law = law
        self.ea, w0, crimp = mpf(given["ea_n"]), mpf(given["w0_mm"]), mpf(given["crimp"])
        self.w = mpf(stretch) * w0
        self.s0 = 2 * w0 * (1 + crimp)
        self.h0 = self.height_of_length(w0)
        self.h_slack = self.height_of_length(self.w)  # height at which S = S0; 0 if straight is already longer

    def height_of_length(self, w):
        if 2 * w >= self.s0:
            return mpf(0)
        high = mp.sqrt((self.s0 / 2) ** 2 - w * w)  # the chord is shorter than the curve
        if self.law == "kawabata":
            return high
        return bracketed_root(lambda h: length(self.law, w, h) - self.s0, mpf(0), high)

    def tension(self, h):
        return self.ea * max(mpf(0), length(self.law, self.w, h) / self.s0 - 1)

    def force(self, h):
        return self.tension(h) * press(self.law, self.w, h)

    def height(self, force, h_max):
        """h with force(h) = F, for 0 <= F <= force(h_max)."""
        if force == 0:
            return self.h_slack
        return bracketed_root(lambda h: self.force(h) - force, self.h_slack, h_max)

    def energy(self, h):
        return self.tension(h) ** 2 * self.s0 / (2 * self.ea)  # N mm


# ---------------------------------------------------------------- the crossover

def compression(force, a, b):
    """d(F) [mm], regularised (21)."""
    return mpf(0) if a == 0 else a - b / mp.cbrt(force + (b / a) ** 3)


def compression_energy(force, a, b):
    """Integral of F dd with F = b^3 [(a - d)^-3 - a^-3] [N mm]."""
    if a == 0:
        return mpf(0)
    d = compression(force, a, b)
    return b ** 3 * ((a - d) ** -2 / 2 - a ** -2 / 2 - d * a ** -3)


class Equilibrium:
    def __init__(self, law, fabric, stretches, a_mm=0.0, b_mm_n13=0.0, gap_mm=0.0):
        self.a, self.b = mpf(a_mm), mpf(b_mm_n13)
        one, two = self.yarns = [Yarn(law, given, stretch) for given, stretch in zip(fabric, stretches)]
        top = self.top = one.h0 + two.h0 - mpf(gap_mm)  # greatest height available
        if one.h_slack + two.h_slack >= top * (1 - mpf(10) ** -32):
            self.force, self.heights = mpf(0), None  # F = 0; with a straight yarn the other lies slack at `top`
            if one.h_slack == 0:
                self.heights = [mpf(0), top]
            elif two.h_slack == 0:
                self.heights = [top, mpf(0)]
        else:
            high = min(one.force(top), two.force(top))
            self.force = bracketed_root(self.misfit, mpf(0), high)
            self.heights = [y.height(self.force, top) for y in self.yarns]
        if self.heights is None:
            self.tensions = [mpf(0), mpf(0)]
        elif self.force == 0:
            self.tensions = [y.tension(mpf(0)) if y.h_slack == 0 else mpf(0) for y in self.yarns]
            if self.tensions == [0, 0]:
                self.heights = None
        else:
            self.tensions = [y.tension(h) for y, h in zip(self.yarns, self.heights)]
        self.in_plane = [t * pull(law, y.w, h) for t, y, h in self.each()]
        self.projected = [t * cos_alpha(y.w, h) for t, y, h in self.each()]

    def each(self):
        return zip(self.tensions, self.yarns, self.heights or (mpf(0), mpf(0)))

    def misfit(self, force):
        """(22): h1(F) + h2(F) + d(F) - (h01 + h02 - gap), increasing in F."""
        heights = [y.height(force, self.top) for y in self.yarns]
        return sum(heights) + compression(force, self.a, self.b) - self.top

    def energy(self):
        if self.heights is None:
            return mpf(0)
        return sum(y.energy(h) for _, y, h in self.each()) + compression_energy(self.force, self.a, self.b)


def bracketed_root(f, low, high):
    """Chandrupatla's method at full working precision; f(low) <= 0 <= f(high)."""
    b, a = low, high
    fb, fa = f(b), f(a)
    if fb == 0:
        return b
    if fa == 0:
        return a
    if fa < 0 and -fa < mpf(10) ** -30 * max(1, abs(fb)):
        return a  # the bracket end is the root, to rounding
    assert fb < 0 < fa, (low, fb, high, fa)
    t = mpf(1) / 2
    for _ in range(1000):
        x = a + t * (b - a)
        fx = f(x)
        if (fx > 0) == (fa > 0):
            c, fc, a, fa = a, fa, x, fx
        else:
            c, fc, b, fb, a, fa = b, fb, a, fa, x, fx
        best, fbest = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        tol = 4 * mp.eps * abs(best)
        t_min = tol / abs(b - a) if b != a else mpf(1)
        if fbest == 0 or t_min > mpf(1) / 2:
            return best
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        t = mpf(1) / 2
        if phi ** 2 < xi and (1 - phi) ** 2 < 1 - xi:
            t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        t = min(max(t, t_min), 1 - t_min)
    raise ArithmeticError("no convergence")


# ---------------------------------------------------------------- the record list

def stretch_pairs(rng, count, warp_range, weft_range):
    return [(round(rng.uniform(*warp_range), 6), round(rng.uniform(*weft_range), 6)) for _ in range(count)]


EDGES = [
    (1.0, 1.0), (1.0218 * 1.01, 0.5), (1.2, 1.2), (0.5, 0.5),
    (1.0218, 1.0), (1.0, 1.0139), (1.0218, 1.0139), (1.0218, 0.5),  # exactly straight yarns
    (1.01, 1.0), (1.04, 1.0),                                        # the rows of the published verification table
    (1.01, 0.989216), (1.000001, 1.0), (1.0, 1.000001),              # just off the slack boundary
    (1.057563, 0.97), (1.2, 0.5), (0.5, 1.2),
]


def jobs():
    """(law, fabric name, (warp, weft) stretch, a, b, gap) in output order."""
    rng = random.Random(SEED)
    sets = {
        "S-720": stretch_pairs(rng, 60, (0.97, 1.045), (0.97, 1.045)) + EDGES,
        "S-728": stretch_pairs(rng, 15, (0.97, 1.045), (0.97, 1.045)),
        "high-crimp": stretch_pairs(rng, 15, (0.90, 1.28), (0.90, 1.15)),
        "unbalanced": stretch_pairs(rng, 15, (0.97, 1.045), (0.97, 1.045)),
    }
    for name, pairs in sets.items():
        for law in LAWS:
            for a in (0.0, 0.10):
                for index, pair in enumerate(pairs):
                    gap = 0.02 if name in ("high-crimp", "unbalanced") and index % 2 else 0.0
                    yield law, name, pair, a, a, gap


def number(x):
    return mp.nstr(x, DIGITS, min_fixed=-1, max_fixed=1, strip_zeros=True) if x else "0.0"


def record(job):
    """One JSON line; inputs as shortest f64, results with 18 significant digits."""
    law, name, stretches, a, b, gap = job
    eq = Equilibrium(law, FABRICS[name], stretches, a, b, gap)
    warp, weft = (json.dumps(y) for y in FABRICS[name])
    heights = ["null"] * 2 if eq.heights is None else [number(h) for h in eq.heights]
    fields = {
        "law": f'"{law}"', "fabric": f'"{name}"', "rigid": "true" if a == 0 else "false",
        "a_mm": repr(a), "b_mm_n13": repr(b), "gap_mm": repr(gap), "warp": warp, "weft": weft,
        "warp_stretch": repr(stretches[0]), "weft_stretch": repr(stretches[1]),
        "warp_tension_n": number(eq.tensions[0]), "weft_tension_n": number(eq.tensions[1]),
        "contact_force_n": number(eq.force),
        "warp_height_mm": heights[0], "weft_height_mm": heights[1],
        "warp_in_plane_n": number(eq.in_plane[0]), "weft_in_plane_n": number(eq.in_plane[1]),
    }
    if law == "published":
        fields["warp_projected_n"], fields["weft_projected_n"] = (number(n) for n in eq.projected)
    return "{" + ", ".join(f'"{key}": {value}' for key, value in fields.items()) + "}"


def main():
    with Pool() as pool:
        lines = pool.map(record, list(jobs()), chunksize=4)
    OUTPUT.write_text("[\n" + ",\n".join(lines) + "\n]\n")
    print(f"{len(lines)} records -> {OUTPUT}")


if __name__ == "__main__":
    if "--check" in sys.argv:
        import unit_cell_check
        sys.exit(unit_cell_check.run())
    main()
