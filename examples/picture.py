# Picture of a run with --frames at a time [µs], cut open along the warp: python picture.py out/shot 60 shot.png
import sys
import pyvista as pv
frames = pv.get_reader(f"{sys.argv[1]}/frames.pvd")
frames.set_active_time_value(min(frames.time_values, key=lambda time: abs(time - float(sys.argv[2]))))
plotter = pv.Plotter(off_screen=True, window_size=(1400, 460))
for name, part in zip(("fabric", "projectile"), frames.read()):
    part = part.warp_by_vector("displacement_mm")
    look = {"scalars": "warp_tension_n", "cmap": "YlOrRd"} if name == "fabric" else {"color": "silver"}
    plotter.add_mesh(part.clip("-y", origin=(0, 0.01, 0)) if name == "fabric" else part, show_scalar_bar=False, **look)
plotter.camera_position, plotter.camera.elevation = "xz", 16
plotter.camera.zoom(2.9)
plotter.screenshot(sys.argv[3])
