"""Independent closed-form wave references (the verification table "Waves"), by mpmath root finding at 40 digits.

    python closed_forms.py            # rewrite closed_forms.json
    python closed_forms.py --check    # also compare with the numbers printed in the verification table

smith            yarn struck transversely, linear: c = sqrt(E/rho),
                 V^2 = c^2 [2 e sqrt(e(1+e)) - e^2],  U = c (sqrt(e(1+e)) - e)
strip_uncrimped  strip struck by a bar, no crimp, transverse displacement fixed: the same with c_f = sqrt(C/Ad), C = EA count
strip_crimped    the same with the rigid unit cell, published law, membrane force = tension, crossing stretch held at 1:
                 V^2 = (N(e)/Ad) [2 sqrt(e(1+e)) - e],  c_s = sqrt(N/(e Ad)),  U = sqrt(N(1+e)/Ad) - c_s e,
                 N(e) = T1(1 + e, 1)/(2 w02). One shock is admissible where c(0) < c_s < c(e), the wave speeds
                 ahead of and behind it (Lax); both are stored.
"e" is the fabric strain behind the shock (stretch - 1); U is the kink speed in space. `running` is the struck yarn family.
yarn_strain is the running yarn's own strain T1/EA (failure: 0.035).
"""

import json
import sys
from pathlib import Path

import mpmath as mp
from mpmath import mpf

from unit_cell import FABRICS, Equilibrium, bracketed_root, number

OUTPUT = Path(__file__).with_suffix(".json")
AREAL_DENSITY = {"S-720": 0.2552, "S-728": 0.2311}  # kg/m2, Table I


def linear(c, speed):
    """(strain, kink speed) of a linear yarn or strip of wave speed c."""
    strain = bracketed_root(lambda e: c * c * (2 * e * mp.sqrt(e * (1 + e)) - e * e) - speed ** 2, mpf(0), mpf(1))
    return strain, c * (mp.sqrt(strain * (1 + strain)) - strain)


def crimped(running, crossing, areal_density, speed):
    """Shock state of the crimped strip."""
    density = mpf(areal_density)
    count = 1000 / (2 * mpf(crossing["w0_mm"]))  # running yarns per metre across the strip

    def force(strain):
        return count * Equilibrium("published", (running, crossing), (1 + strain, mpf(1))).tensions[0]

    def misfit(strain):
        return force(strain) / density * (2 * mp.sqrt(strain * (1 + strain)) - strain) - mpf(speed) ** 2

    def wave_speed(strain, step):  # one-sided at rest: the slack side has no stiffness
        low = max(strain - step, mpf(0))
        return mp.sqrt((force(strain + step) - force(low)) / (strain + step - low) / density)

    strain = bracketed_root(misfit, mpf(0), mpf("0.08"))
    membrane = force(strain)
    shock = mp.sqrt(membrane / (strain * density))
    return {
        "strain": strain,
        "membrane_force_n_m": membrane,
        "shock_speed_m_s": shock,
        "kink_speed_m_s": mp.sqrt(membrane * (1 + strain) / density) - shock * strain,
        "wave_speed_ahead_m_s": wave_speed(mpf(0), mpf(10) ** -18),
        "wave_speed_behind_m_s": wave_speed(strain, mpf(10) ** -12),
        "yarn_strain": membrane / count / mpf(running["ea_n"]),
    }


def references():
    out = {"smith": [], "strip_uncrimped": [], "strip_crimped": []}
    c = mp.sqrt(mpf(96e9) / 1440)
    for speed in (50.0, 155.0, 400.0):
        strain, kink = linear(c, speed)
        out["smith"].append({"youngs_modulus_pa": 96e9, "fibre_density_kg_m3": 1440.0, "speed_m_s": speed,
                             "wave_speed_m_s": c, "strain": strain, "kink_speed_m_s": kink})
    yarn = FABRICS["S-720"][0]
    stiffness = mpf(yarn["ea_n"]) * 1000 / (2 * mpf(yarn["w0_mm"]))
    c_f = mp.sqrt(stiffness / mpf(AREAL_DENSITY["S-720"]))
    for speed in (50.0, 155.0, 400.0):
        strain, kink = linear(c_f, speed)
        out["strip_uncrimped"].append({"fabric": "S-720", "areal_density_kg_m2": AREAL_DENSITY["S-720"], "speed_m_s": speed,
                                       "stiffness_n_m": stiffness, "wave_speed_m_s": c_f, "strain": strain,
                                       "membrane_force_n_m": stiffness * strain, "kink_speed_m_s": kink})
    cases = [("S-720", "warp", v) for v in (100.0, 155.0, 250.0)]
    cases += [("S-720", "weft", v) for v in (100.0, 155.0, 250.0)] + [("S-728", "warp", 155.0), ("S-728", "weft", 155.0)]
    for fabric, side, speed in cases:
        warp, weft = FABRICS[fabric]
        running, crossing = (warp, weft) if side == "warp" else (weft, warp)
        out["strip_crimped"].append({"fabric": fabric, "running": side, "running_yarn": running, "crossing_yarn": crossing,
                                     "areal_density_kg_m2": AREAL_DENSITY[fabric], "speed_m_s": speed,
                                     **crimped(running, crossing, AREAL_DENSITY[fabric], speed)})
    return out


def text(value):
    return number(value) if isinstance(value, mpf) else json.dumps(value)


def write(groups):
    blocks = []
    for name, rows in groups.items():
        lines = ["    {" + ", ".join(f'"{key}": {text(value)}' for key, value in row.items()) + "}" for row in rows]
        blocks.append(f'  "{name}": [\n' + ",\n".join(lines) + "\n  ]")
    OUTPUT.write_text("{\n" + ",\n".join(blocks) + "\n}\n")


def check(groups):
    """Compare with the verification table, digit by digit; check that each crimped shock is admissible."""
    from unit_cell_check import digits, failures, report
    smith, plain, crimp = (groups[name][1] for name in ("smith", "strip_uncrimped", "strip_crimped"))
    digits("Kevlar 129 wave speed", smith["wave_speed_m_s"], "8164.97")
    digits("Smith 155 strain", smith["strain"], "0.0032487")
    digits("Smith 155 U", smith["kink_speed_m_s"], "439.61")
    digits("S-720 straight-yarn wave speed", plain["wave_speed_m_s"], "5697")
    digits("uncrimped strip 155 strain", plain["strain"], "0.0052743")
    digits("uncrimped strip 155 U", plain["kink_speed_m_s"], "384.77")
    digits("crimped strip 155 strain", crimp["strain"], "0.008837")
    digits("crimped strip 155 N", crimp["membrane_force_n_m"], "34062")
    digits("crimped strip 155 c_s", crimp["shock_speed_m_s"], "3886.3")
    digits("crimped strip 155 U", crimp["kink_speed_m_s"], "332.60")
    for row in groups["strip_crimped"]:
        ahead, shock, behind = row["wave_speed_ahead_m_s"], row["shock_speed_m_s"], row["wave_speed_behind_m_s"]
        label = f"{row['fabric']} {row['running']} {row['speed_m_s']:g} m/s"
        report(ahead < shock < behind, f"{label}: {mp.nstr(ahead, 6)} < c_s {mp.nstr(shock, 6)} < {mp.nstr(behind, 6)}, "
               f"strain {mp.nstr(row['strain'], 6)}, U {mp.nstr(row['kink_speed_m_s'], 6)}, yarn strain {mp.nstr(row['yarn_strain'], 4)}")
    stored = json.loads(OUTPUT.read_text())
    same = all(abs(old[key] - float(new[key])) <= 1e-15 * abs(old[key])
               for name, rows in groups.items() for old, new in zip(stored[name], rows, strict=True)
               for key in new if isinstance(new[key], mpf))
    report(same, f"{OUTPUT.name} is what this script computes")
    return 1 if failures else 0


if __name__ == "__main__":
    groups = references()
    if "--check" in sys.argv:
        sys.exit(check(groups))
    write(groups)
