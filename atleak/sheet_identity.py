"""Hold what the head of a measuring sheet says about the job: whose unit it is, and who measured it with what."""

from __future__ import annotations

from dataclasses import astuple, dataclass


@dataclass(frozen=True)
class SheetIdentity:
    """Whose unit was measured, by whom and with what, as the sheet's head says it; empty where it does not."""

    job: str = ""  # number of the job
    vehicle: str = ""  # in the words of whoever wrote it
    vin: str = ""
    serial: str = ""  # of the transmission
    technician: str = ""  # who measured
    instruments: tuple[str, ...] = ()  # where the head names two, that for spools and then that for bores
    mileage: float | None = None  # [km]

    @property
    def empty(self) -> bool:
        """Tell whether the head says nothing of this."""
        return not any(value not in ("", (), None) for value in astuple(self))
