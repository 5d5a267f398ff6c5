"""The summary of a run: data for programs, lines for people."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from comotion.run_record import RunRecord

if TYPE_CHECKING:
    from comotion_mock_cfd.heave import HeavePeriod

MOST_NAMES = 6
"""Names listed in one line of the summary; `summary.json` has all."""


@dataclass(frozen=True)
class Summary:
    """What a run tells at its end."""

    scene: str
    record: RunRecord
    wall_time: float  # of the exchange, without start-up and drawing [s]
    protocol_share: float | None  # of the time spent waiting for replies; None when the server could not be asked
    heave: "HeavePeriod | None"
    interrupted: bool = False

    @property
    def status(self) -> str:
        """In a word: "ok", "blocked" or "interrupted"."""
        if self.interrupted:
            return "interrupted"
        return "blocked" if self.record.blocked_at else "ok"

    @property
    def wall_per_simulated(self) -> float | None:
        """Wall time per simulated second; None before the first step."""
        return self.wall_time / self.record.simulated if self.record.steps else None

    def as_data(self) -> dict[str, Any]:
        """Plain data for JSON; units in the names."""
        record, heave = self.record, self.heave
        return {
            "scene": self.scene,
            "status": self.status,
            "steps": record.steps,
            "simulated_s": record.simulated,
            "wall_s": self.wall_time,
            "wall_per_simulated_second": self.wall_per_simulated,
            "protocol_share": self.protocol_share,
            "impacts": record.impacts,
            "momentum_error_max": record.momentum_error,
            "angular_momentum_error_max": record.angular_momentum_error,
            "energy_error_max": record.energy_error,
            "overlaps": record.overlaps,
            "overlap_max_m": record.overlap_max,
            "rest_energy_J": record.rest_energy,
            "shift_work_J": record.shift_work,
            "healings": record.healings,
            "worn_mass_kg": record.worn_mass,
            "budgets_exhausted": record.budgets_exhausted,
            "impacts_capped": record.capped,
            "fallback_steps": record.fallback_steps,
            "blocked_at_s": record.blocked_at,
            "blocked_bodies": sorted(record.blocked_bodies),
            "blocked_contacts": sorted(record.blocked_contacts),
            "heave": None
            if heave is None
            else {
                "body": heave.body,
                "period_s": heave.measured,
                "theory_s": heave.theory,
                "error": heave.error,
                "cycles": heave.cycles,
            },
        }

    def warnings(self) -> list[str]:
        """What a reader must not overlook, in whole sentences."""
        record, told = self.record, []
        if self.interrupted:
            told.append("The run was interrupted.")
        if record.blocked_at:
            told.append(f"{len(record.blocked_at)} steps were blocked, the first one at {record.blocked_at[0]:.6g} s.")
        if record.overlaps:
            told.append(f"Bodies overlapped {record.overlaps} times, by {record.overlap_max:.3g} m at most.")
        if record.budgets_exhausted:
            told.append(f"The budget of responses was used up in {record.budgets_exhausted} steps.")
        if record.capped:
            told.append(f"{record.capped} impacts did not end and were answered without rebound.")
        if record.fallback_steps:
            told.append(f"Contacts were held by time-stepping in {record.fallback_steps} steps.")
        return told

    def lines(self) -> list[str]:
        """Aligned text, one figure a line."""
        record, pace, share = self.record, self.wall_per_simulated, self.protocol_share
        errors = (record.momentum_error, record.angular_momentum_error, record.energy_error)
        rows = [
            ("scene", f"{self.scene}: {self.status}"),
            ("steps", f"{record.steps} ({record.simulated:.6g} s simulated)"),
            ("impacts", str(record.impacts)),
            (
                "wall time",
                "-" if pace is None else f"{pace:.3g} s per simulated second ({self.wall_time:.3g} s in all)",
            ),
            ("protocol share", "-" if share is None else f"{share:.1%} of the time spent waiting for replies"),
            ("worst error", "momentum {:.1e}, angular momentum {:.1e}, energy {:.1e} (relative)".format(*errors)),
            ("overlaps", f"{record.overlaps}, largest {record.overlap_max:.3g} m" if record.overlaps else "none"),
        ]
        if record.healings:
            rows.append(
                ("healings", f"{record.healings} scalings of pinched bodies, {record.worn_mass:.4g} kg worn off")
            )
        if record.overlaps:
            rows.append(("", "the paper's queue cannot exclude them: docs/method.md, P14 to P16"))
        if self.heave is not None:
            heave = self.heave
            found = f"{heave.measured:.5g} s over {heave.cycles} cycles; theory {heave.theory:.5g} s"
            rows.append(("heave period", f"{found}; error {heave.error:+.2%}"))
        if record.budgets_exhausted:
            rows.append(("budget", f"used up in {record.budgets_exhausted} steps; see `budget` in [collisions]"))
        if record.capped:
            rows.append(("capped", f"{record.capped} impacts did not end and were answered without rebound"))
        if record.fallback_steps:
            rows.append(("fallback", f"contacts were held by time-stepping in {record.fallback_steps} steps"))
        rows += _blocked_rows(record)
        width = max(len(name) for name, _ in rows)
        return [f"{name:<{width}}  {value}" for name, value in rows]


def _blocked_rows(record: RunRecord) -> list[tuple[str, str]]:
    """Since when, who was kept in place, and between whom there was no way."""
    if not record.blocked_at:
        return []
    rows = [("blocked", f"{len(record.blocked_at)} steps, first at {record.blocked_at[0]:.6g} s")]
    if record.blocked_bodies:
        rows.append(("", f"kept in place: {_listed(sorted(record.blocked_bodies))}"))
    if record.blocked_contacts:
        rows.append(("", f"no way between: {_listed([f'{a} and {b}' for a, b in sorted(record.blocked_contacts)])}"))
    return rows


def _listed(names: list[str]) -> str:
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
