"""What matters for one ply of S-720: crimp, friction, boundary, shape, plies, shear, one at a time: python s720_studies.py [FOLDER]

Each row changes one thing of the paper's shot and finds the ballistic limit. It matters where it moves the limit by more than both numerical errors,
though on one mesh much of them is common. FOLDER, by default out/s720-studies, gets table.csv. The same command goes on with what lies there.
"""

import sys
from math import hypot
from pathlib import Path

import ripstop

CASE = ripstop.Case(
    title="S-720, 1 ply", fabric="s-720", width_mm=203, height_mm=203, elements_per_crossover=1, mesh_grading={},
    shape="cylinder", diameter_mm=5.5, length_mm=42.1, mass_g=3.0, velocity_m_s=180,
)  # fmt: skip
BOTH_CRIMPS = "/fabric/warp/crimp /fabric/weft/crimp"
SIDES = {"left": "clamped", "right": "clamped", "bottom": "free", "top": "free"}
#: Changes by question and name. Ranges: Table I of the paper for crimp; what is not published from little to much.
STUDIES = {
    "": {"as in the paper": {}},
    "crimp": {
        "warp and weft exchanged": {"/fabric/warp/crimp": 0.0139, "/fabric/weft/crimp": 0.0218},
        "both the least, 1.39 %": {BOTH_CRIMPS: 0.0139},
        "both the largest, 2.18 %": {BOTH_CRIMPS: 0.0218},
        "none": {BOTH_CRIMPS: 0.0},
        "rigid crossover": {"/fabric/crossover/compression": "rigid"},
    },
    "friction": {"projectile 0": {"/projectile/friction": 0.0}, "projectile 0.5": {"/projectile/friction": 0.5}},
    "boundary": {
        "two sides clamped": {"/pack/edges": SIDES},
        "window of 203 mm": {"/pack/window": {"diameter_mm": 203}},
        "frame of 150 mm": {"/pack/width_mm /pack/height_mm": 150},
        "frame of 300 mm": {"/pack/width_mm /pack/height_mm": 300},
    },
    "shape": {
        "edge radius 0.5 mm": {"/projectile/edge_radius_mm": 0.5},
        "ball": {"/projectile": {"shape": "sphere", "diameter_mm": 5.5, "mass_g": 3.0, "velocity_m_s": 180}},
        "cylinder of 11 mm": {"/projectile/diameter_mm": 11.0},
    },
    "plies": {"two": {"/pack/plies": 2}, "four": {"/pack/plies": 4}, "four, no friction": {"/pack/plies": 4, "/pack/friction": 0.0}},
    "shear": {
        "none": {"/fabric/shear": "none"},
        "G1 of 1 MPa": {"/fabric/shear/g1_mpa": 1.0},
        "G1 of 100 MPa": {"/fabric/shear/g1_mpa": 100.0},
        "locks at half the angle": {"/fabric/shear/gamma1": 0.175, "/fabric/shear/gamma2": 0.3},
    },
}


def main(folder: Path) -> None:
    """Compute the limits, and print them beside that of the paper's shot."""
    names = [(study, name) for study, changes in STUDIES.items() for name in changes]
    changes = [STUDIES[study][name] for study, name in names]
    rows = {pointer: [change.get(pointer) for change in changes] for pointer in sorted(set().union(*changes))}
    plan = ripstop.Plan(CASE.document, rows, run="v50", options={"refined": 0, "precision": "f32"})
    found = ripstop.campaign(plan, folder).read()
    limits = [[float(row[name] or "nan") for name in ("v50_m_s", "low_m_s", "high_m_s")] for row in found]
    print(f"{'study':9} {'change':26} {'limit':>7} m/s  over that of the paper")
    for (study, name), row, (limit, low, high) in zip(names, found, limits):
        error = hypot(high - low, limits[0][2] - limits[0][1]) / 2
        verdict = row["reason"] or ("matters" if abs(limit - limits[0][0]) > error else "does not" if study else "")
        print(f"{study:9} {name:26} {limit:7.1f}     {limit / limits[0][0]:.3f} +- {error / limits[0][0]:.3f}   {verdict}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/s720-studies"))
