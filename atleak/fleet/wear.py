"""Say how the wear of every land grows with mileage."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from atleak.fleet.lands import Lands
from atleak.fleet.summed import LandOverMileage, MileageClass
from atleak.fleet.visits import Visits
from atleak.spreads import spread

_WIDTHS = (5_000.0, 10_000.0, 20_000.0, 25_000.0, 50_000.0, 100_000.0)  # [km] of a class of mileage
_CLASSES, _MOST_UNITS = 8, 0.95  # of which so many hold so great a part of the visits: choices of this project


def class_width(mileages: np.ndarray) -> float:
    """Return the width of the classes of mileage [km]: the narrowest round one by which there are few of them."""
    known = mileages[~np.isnan(mileages)]
    wanted = float(np.quantile(known, _MOST_UNITS)) / _CLASSES if known.size else 0.0
    return next((width for width in _WIDTHS if width >= wanted), _WIDTHS[-1])


def classes_of(mileages: np.ndarray, width: float) -> np.ndarray:
    """Return the number of the class of each mileage; NaN without one."""
    return np.floor(mileages / width)


def wear_over_mileage(visits: Visits, lands: Lands) -> tuple[LandOverMileage, ...]:
    """Return the wear of every land of a valve body over mileage; all visits count."""
    mileage, unit = visits.rows["mileage_km"].to_numpy(float), visits.rows["unit"].to_numpy()
    width = class_width(mileage)
    number = classes_of(mileage, width)
    latest = lands.at(visits.rows["counts"].to_numpy())
    measured, repaired = ~np.isnan(lands.wear), (lands.measured & lands.repaired).sum(axis=0)
    found = []
    for place, key in enumerate(lands.keys):
        there = np.flatnonzero(measured[:, place] & ~np.isnan(number))
        found.append(
            LandOverMileage(
                key=key,
                classes=tuple(_classes(lands.wear[there, place], unit[there], number[there], width)),
                without_mileage=int(measured[:, place].sum()) - len(there),
                repaired=int(repaired[place]),
                latest_percent=spread(latest.wear[:, place]),
            )
        )
    return tuple(found)


def _classes(wear: np.ndarray, unit: np.ndarray, number: np.ndarray, width: float) -> Iterator[MileageClass]:
    """Yield the classes of one land, from its measurements in the order of time; of a unit the last counts."""
    for each in np.unique(number):
        within = np.flatnonzero(number == each)[::-1]
        _, last = np.unique(unit[within], return_index=True)
        percent = spread(wear[within[last]])
        if percent is not None:
            yield MileageClass(float(each * width), float((each + 1.0) * width), percent)
