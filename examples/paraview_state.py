# State of ParaView for the frames of a run: File > Load State in the folder of the run, or pvpython paraview_state.py out/shot
import sys
from paraview.simple import *

folder = sys.argv[1] if len(sys.argv) > 1 else "."
frames = PVDReader(FileName=f"{folder}/frames.pvd")
view = GetActiveViewOrCreate("RenderView")
moved = WarpByVector(Input=frames, Vectors=["POINTS", "displacement_mm"])
fabric, projectile = (ExtractBlock(Input=moved, Selectors=[f"/Root/{name}"]) for name in ("fabric", "projectile"))
ColorBy(Show(fabric, view), ("CELLS", "warp_tension_n"))
Show(projectile, view).DiffuseColor = [0.75, 0.75, 0.75]
view.ViewTime = max(frames.TimestepValues)
view.ResetCamera()
Render()
