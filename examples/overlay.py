# Two runs and a measured curve in one figure: python overlay.py out/a out/b measured.csv velocity.png
import sys
import matplotlib.pyplot as plt
import pandas as pd
*folders, measured, picture = sys.argv[1:]
figure, axes = plt.subplots()
for folder in folders:
    pd.read_csv(f"{folder}/history.csv").plot(x="time_us", y="projectile_velocity_m_s", label=folder, ax=axes)
pd.read_csv(measured).plot.scatter(x="time_us", y="projectile_velocity_m_s", label="measured", color="black", ax=axes)
axes.set(xlabel="time [µs]", ylabel="projectile velocity [m/s]")
figure.savefig(picture, dpi=200)
