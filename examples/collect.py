# Table of the shots of a Slurm array, as `ripstop fit` reads it: python collect.py out/shots
import json, sys
from pathlib import Path
import pandas as pd
rows = []
for shot in sorted(Path(sys.argv[1]).glob("shot-*"), key=lambda path: int(path.name[5:])):
    case, result = (json.loads((shot / name).read_text()) for name in ("case.json", "summary.json"))
    passed = result["outcome"] == "perforated"
    rows.append({"velocity_m_s": case["projectile"]["velocity_m_s"], "perforated": int(passed),
                 "residual_velocity_m_s": result["residual_velocity_m_s"] if passed else None})
pd.DataFrame(rows).to_csv(Path(sys.argv[1]) / "all.csv", index=False)
