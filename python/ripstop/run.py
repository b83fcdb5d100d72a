"""Result of one shot."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from . import _ripstop
from .frames import Frames
from .table import Result, Table

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes


class Run(Result):
    """Result of one shot: attributes of `summary.json`, histories as arrays, frames, plots.

    The units stand in the names: `residual_velocity_m_s`, `stop_time_us`, `max_deflection_mm`, `absorbed_energy_j`, `peak_contact_force_n`.
    `outcome` is "perforated", "stopped", "rebounded" or "running". `trust["advice"]` says how far to trust them.
    """

    def __init__(self, handle: _ripstop.Run) -> None:
        super().__init__(handle.summary())
        self._handle = handle

    @property
    def verdict(self) -> str:
        """Verdict in a line, as `ripstop run` prints it."""
        return self._handle.verdict()

    @cached_property
    def history(self) -> Table:
        """Columns of `history.csv`: `time_us`, `projectile_velocity_m_s`, `contact_force_n`, energies in J, and more."""
        return Table.of_bytes(*self._handle.history())

    @cached_property
    def events(self) -> Table:
        """Yarn failures, columns of `events.csv`: `time_us`, `ply`, `i`, `j`, `yarn`, `strain`, `x_mm`, `y_mm`."""
        return Table.of_csv(self._handle.table("events"))

    @cached_property
    def plies(self) -> Table:
        """Every ply of a pack of several at the times of the history, columns of `plies.csv`."""
        return Table.of_csv(self._handle.table("plies"))

    @cached_property
    def profiles(self) -> Table:
        """Deflection along a yarn at /output/profile_times_us, columns of `profiles.csv`."""
        return Table.of_csv(self._handle.table("profiles"))

    @cached_property
    def frames(self) -> Frames:
        """Frames of the whole scene that `run(frames=)` asked for; empty without."""
        return Frames.of(self._handle)

    @cached_property
    def page(self) -> str:
        """The page `report.html`, without its playback: `run(out=)` writes it with that."""
        return self._handle.page()

    def to_pandas(self) -> pandas.DataFrame:
        """The history as a pandas DataFrame."""
        return self.history.to_pandas()

    def plot_velocity(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draws the projectile's velocity [m/s] over time [µs]."""
        from . import plot

        return plot.overlay([self], "projectile_velocity_m_s", ax=ax, **style)

    def plot_force(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draws the contact force [N] over time [µs]."""
        from . import plot

        return plot.overlay([self], "contact_force_n", ax=ax, **style)

    def plot_energies(self, ax: Axes | None = None) -> Axes:
        """Draws where the energy is [J] over time [µs]."""
        from . import plot

        return plot.energies(self, ax)

    def __repr__(self) -> str:
        return f"<Run {self.title}: {self.verdict}>"
