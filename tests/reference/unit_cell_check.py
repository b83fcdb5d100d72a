"""What stands behind unit_cell.json. Run by `python unit_cell.py --check`; exit status 1 if anything fails.

1. every digit of the unit-cell rows of the published verification table and of the derived values;
2. the quadrature against mpmath's adaptive quadrature of (13) as printed, against E(m), and its derivatives;
3. energy: heights by direct minimisation of U, and dU/d(2w_i) = N_i by differences (variational, kawabata);
4. every record of unit_cell.json put back into the physical conditions, with S, F/T and N/T from E(m) and K(m), not from the quadrature.
"""

import json

import mpmath as mp
from mpmath import mpf

from unit_cell import FABRICS, LAWS, OUTPUT, Equilibrium, Yarn, bracketed_root, compression, jobs, length, press, pull
from unit_cell import compression_energy, slope

failures = []


def report(ok, text):
    failures.extend([] if ok else [text])
    print(f"{'ok  ' if ok else 'FAIL'}  {text}")


def digits(label, got, printed):
    """`printed` (a string) must be `got` rounded to its last digit."""
    places = len(printed.partition(".")[2])
    ok = abs(got - mpf(printed)) <= mpf(10) ** -places * mpf("0.5000001")
    report(ok, f"{label:44s} {mp.nstr(got, 12):>18s}  spec {printed}")


# ---------------------------------------------------------------- 1. the spec

B_ROW = 0.192585679
SPEC_ROWS = [  # law, warp stretch, a, b, then printed h1 h2 T1 T2 F (None: not printed)
    ("published", 1.010, 0.0, 0.0, ("0.105521", "0.110638", "50.0251", "47.4183", "25.0347")),
    ("published", 1.040, 0.0, 0.0, ("0.077421", "0.138739", "277.5448", "154.8446", "100.5288")),
    ("variational", 1.010, 0.0, 0.0, (None, None, "50.0444", "47.3978", "19.8285")),
    ("kawabata", 1.010, 0.0, 0.0, ("0.116967", "0.122588", "50.0246", "47.3498", "17.9505")),
    ("published", 1.010, 0.10, B_ROW, ("0.0944415", "0.1007695", "16.2322", "15.1238", "7.3160")),
]


def check_spec():
    fabric = FABRICS["S-720"]
    for law, stretch, a, b, row in SPEC_ROWS:
        eq = Equilibrium(law, fabric, (stretch, 1.0), a, b)
        for name, got, printed in zip(("h1", "h2", "T1", "T2", "F"), [*eq.heights, *eq.tensions, eq.force], row):
            if printed:
                digits(f"S-720 {law} a={a} {stretch:.3f} {name}", got, printed)
    derived = {"S-720": ("10518.5", "0.63500", "0.120343", "0.095816"), "S-728": ("11111.1", "0.74706", "0.127017", "0.092545")}
    for name, (ea, w0, h01, h02) in derived.items():
        one, two = (Yarn("published", y, 1.0) for y in FABRICS[name])
        for label, got, printed in (("EA", one.ea, ea), ("w0", one.w, w0), ("h01", one.h0, h01), ("h02", two.h0, h02)):
            digits(f"{name} {label}", got, printed)

    # Uniaxial, weft free: both yarns at their own length, h1 + h2 = h01 + h02.
    one = Yarn("published", fabric[0], 1.01)

    def height_left(weft_stretch):
        two = Yarn("published", fabric[1], weft_stretch)
        return one.h0 + two.h0 - one.h_slack - two.h_slack

    digits("S-720 weft stretch freed by warp 1.010", bracketed_root(height_left, mpf("0.97"), mpf(1)), "0.989216")
    digits("S-720 warp stretch at failure", mpf("1.0218") * mpf("1.035"), "1.057563")
    k1, k2 = (slope(y.w, y.h0) for y in (Yarn("published", y, 1.0) for y in fabric))
    digits("S-720 crimp interchange at rest dL2/dL1", -k2 / k1, "-0.8")
    eq = Equilibrium("published", fabric, (1 + 1e-12, 1.0))
    ratio = mp.sqrt(eq.tensions[0] / eq.yarns[0].ea / (mpf(1 + 1e-12) - 1))
    digits("S-720 small-strain wave / straight-yarn wave", ratio, "0.62")


# ---------------------------------------------------------------- 2. the quadrature

def check_quadrature():
    worst = mpf(0)
    for w, h in ((0.635, 0.001), (0.635, 0.12), (0.3175, 0.216), (0.5, 0.6)):
        w, h = mpf(w), mpf(h)
        k = slope(w, h)
        printed = 2 * mp.quad(lambda x: mp.sqrt(1 + (k * mp.sin(mp.pi * x / (2 * w))) ** 2), mp.linspace(0, w, 5))
        elliptic = 4 * w / mp.pi * mp.ellipe(-k * k)
        s_h = mp.diff(lambda x: length("variational", w, x), h)
        s_2w = mp.diff(lambda x: length("variational", x / 2, h), 2 * w)
        got = length("variational", w, h)
        worst = max(worst, abs(got - printed), abs(got - elliptic))
        worst = max(worst, (abs(press("variational", w, h) - s_h) + abs(pull("variational", w, h) - s_2w)) * mpf(10) ** -6)
    report(worst < mpf(10) ** -33, f"S against (13) and E(m); S_h, S_2w against differences: {mp.nstr(worst, 2)}")


# ---------------------------------------------------------------- 3. energy

def golden_minimum(f, low, high):
    ratio = (mp.sqrt(5) - 1) / 2
    x, y = high - ratio * (high - low), low + ratio * (high - low)
    fx, fy = f(x), f(y)
    for _ in range(90):
        if fx < fy:
            high, y, fy = y, x, fx
            x = high - ratio * (high - low)
            fx = f(x)
        else:
            low, x, fx = x, y, fy
            y = low + ratio * (high - low)
            fy = f(y)
    return (low + high) / 2


def minimise(eq):
    """Heights minimising U(h1, h2), d = h01 + h02 - gap - h1 - h2 >= 0, forces never used."""
    one, two = eq.yarns

    def best_second(h1):
        if eq.a == 0:
            return eq.top - h1
        floor = max(mpf(0), eq.top - h1 - eq.a * (1 - mpf(10) ** -6))
        return golden_minimum(lambda h2: stored(h1, h2), floor, eq.top - h1)

    def stored(h1, h2):
        d, total = eq.top - h1 - h2, one.energy(h1) + two.energy(h2)
        if eq.a > 0:
            total += eq.b ** 3 * ((eq.a - d) ** -2 / 2 - eq.a ** -2 / 2 - d * eq.a ** -3)
        return total

    h1 = golden_minimum(lambda h: stored(h, best_second(h)), mpf(0), eq.top)
    return h1, best_second(h1)


def check_energy():
    step = mpf(10) ** -10
    for law in ("variational", "kawabata"):
        for name, a, stretches in (("S-720", 0.0, (1.01, 1.0)), ("S-720", 0.1, (1.03, 1.02)), ("unbalanced", 0.1, (1.0, 1.03))):
            def cell(d1=mpf(0), d2=mpf(0)):
                return Equilibrium(law, FABRICS[name], (stretches[0] + d1, stretches[1] + d2), a, a)
            eq = cell()
            worst = mpf(0)
            for i, d in enumerate(((step, mpf(0)), (mpf(0), step))):
                span = 2 * mpf(FABRICS[name][i]["w0_mm"])
                difference = (cell(*d).energy() - cell(-d[0], -d[1]).energy()) / (2 * step * span)
                worst = max(worst, abs(difference / eq.in_plane[i] - 1))
            report(worst < mpf(10) ** -13, f"dU/d(2w) = N, {law} {name} a={a} {stretches}: {mp.nstr(worst, 2)}")
            if law == "kawabata" or a == 0:  # a nested golden section over quadratures is slow
                worst = max(abs(h - g) for h, g in zip(minimise(eq), eq.heights))
                report(worst < mpf(10) ** -14, f"  heights minimise U, mm: {mp.nstr(worst, 2)}")
    d = mpf("0.03")
    a = b = mpf("0.1")
    force = b ** 3 * ((a - d) ** -3 - a ** -3)
    work = mp.quad(lambda x: b ** 3 * ((a - x) ** -3 - a ** -3), [0, d])
    off = abs(compression(force, a, b) - d) + abs(compression_energy(force, a, b) - work)
    report(off < mpf(10) ** -35, f"d(F) inverts F(d); its energy is the integral of F dd: {mp.nstr(off, 2)}")


# ---------------------------------------------------------------- 4. the stored file

def elliptic_forms(law, w, h):
    """(S, F/T, N/T) with E(m) and K(m) where unit_cell.py integrates numerically."""
    k = slope(w, h)
    if law == "kawabata":
        half = mp.hypot(w, h)
        return 2 * half, 2 * h / half, w / half
    s = 4 * w / mp.pi * mp.ellipe(-k * k)
    if law == "published":
        return s, 2 * mp.sin(mp.atan(k)), mpf(1)
    s_h = 2 * (mp.ellipe(-k * k) - mp.ellipk(-k * k)) / k if h else mpf(0)
    return s, s_h, (s - h * s_h) / (2 * w)


def record_error(line):
    """Worst violation of the physical conditions, relative to EA (forces) and to h01 + h02 (heights)."""
    law, a, b = line["law"], mpf(line["a_mm"]), mpf(line["b_mm_n13"])
    yarns = [Yarn(law, line[side], float(line[f"{side}_stretch"])) for side in ("warp", "weft")]
    force, top = mpf(line["contact_force_n"]), sum(y.h0 for y in yarns) - mpf(line["gap_mm"])
    tensions = [mpf(line[f"{side}_tension_n"]) for side in ("warp", "weft")]
    in_plane = [mpf(line[f"{side}_in_plane_n"]) for side in ("warp", "weft")]
    assert force >= 0 and min(tensions) >= 0
    if line["warp_height_mm"] is None:
        assert force == 0 and tensions == in_plane == [0, 0]
        return max(mpf(0), top - sum(y.h_slack for y in yarns)) / top  # nothing taut at the heights that fit
    heights = [mpf(line[f"{side}_height_mm"]) for side in ("warp", "weft")]
    error = abs(sum(heights) + compression(force, a, b) - top) / top
    for side, y, h, t, n in zip(("warp", "weft"), yarns, heights, tensions, in_plane):
        assert h >= 0
        s, force_ratio, pull_ratio = elliptic_forms(law, y.w, h)
        expected = y.ea * max(mpf(0), s / y.s0 - 1)
        error = max(error, abs(t - expected) / y.ea, abs(t * force_ratio - force) / y.ea, abs(t * pull_ratio - n) / y.ea)
        if law == "published":
            error = max(error, abs(t * mp.cos(mp.atan(slope(y.w, h))) - mpf(line[f"{side}_projected_n"])) / y.ea)
    return error


def check_file():
    lines = json.loads(OUTPUT.read_text(), parse_float=str)
    expected = list(jobs())
    same = [(r["law"], r["fabric"], (float(r["warp_stretch"]), float(r["weft_stretch"]))) for r in lines] == [j[:3] for j in expected]
    report(same, f"{OUTPUT.name} holds the {len(expected)} jobs of the seed, in order")
    for law in LAWS:
        mine = [r for r in lines if r["law"] == law]
        worst = max(map(record_error, mine))
        slack = sum(r["warp_height_mm"] is None for r in mine)
        free = sum(r["warp_height_mm"] is not None and mpf(r["contact_force_n"]) == 0 for r in mine)
        text = f"{law}: {len(mine)} records ({slack} slack, {free} taut without contact), worst residual {mp.nstr(worst, 2)}"
        report(worst < mpf(10) ** -16, text)


def run():
    check_spec()
    check_quadrature()
    check_energy()
    check_file()
    print(f"{len(failures)} failed" if failures else "all passed")
    return 1 if failures else 0
