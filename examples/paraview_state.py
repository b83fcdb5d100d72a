# State of ParaView for the frames of a run: File > Load State in the folder of the run, or pvpython paraview_state.py out/shot
import sys
from paraview.simple import *

folder = sys.argv[1] if len(sys.argv) > 1 else "."
frames = PVDReader(FileName=f"{folder}/frames.pvd")
view = GetActiveViewOrCreate("RenderView")
view.ViewTime = max(frames.TimestepValues)
moved = WarpByVector(Input=frames, Vectors=["POINTS", "displacement_mm"])
fabric, projectile = (ExtractBlock(Input=moved, Selectors=[f"/Root/{name}"]) for name in ("fabric", "projectile"))
shown = Show(fabric, view)
ColorBy(shown, ("CELLS", "warp_tension_n"))
shown.RescaleTransferFunctionToDataRangeOverTime()
shown.SetScalarBarVisibility(view, True)
Show(projectile, view).DiffuseColor = [0.75, 0.75, 0.75]
# From the strike side, weft away from the eye.
view.CameraViewUp, view.CameraPosition, view.CameraFocalPoint = [0, 0, -1], [0.3, -1, -0.7], [0, 0, 0]
view.ResetCamera()
Render()
