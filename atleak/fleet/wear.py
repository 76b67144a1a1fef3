"""Say how the wear of every land grows with mileage."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from atleak.fleet.lands import Lands
from atleak.fleet.spreading import spread
from atleak.fleet.summed import LandOverMileage, MileageClass
from atleak.fleet.visits import Visits

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
    rows = visits.rows
    mileage = rows["mileage_km"].to_numpy(float)
    width = class_width(mileage)
    of_visits = pd.DataFrame({"unit": rows["unit"], "class": classes_of(mileage, width)})
    latest = lands.at(rows["counts"].to_numpy())
    repaired = (lands.measured & lands.repaired).sum(axis=0)
    found = []
    for place, key in enumerate(lands.keys):
        measured = of_visits.assign(wear=lands.wear[:, place]).dropna(subset="wear")
        found.append(
            LandOverMileage(
                key=key,
                classes=tuple(_classes(measured, width)),
                without_mileage=int(measured["class"].isna().sum()),
                repaired=int(repaired[place]),
                latest_percent=spread(latest.wear[:, place]),
            )
        )
    return tuple(found)


def _classes(measured: pd.DataFrame, width: float) -> Iterator[MileageClass]:
    """Yield the classes of one land, from its measurements in the order of time; of a unit the last counts."""
    once = measured.dropna(subset="class").drop_duplicates(["unit", "class"], keep="last")
    classes, wear = once["class"].to_numpy(), once["wear"].to_numpy()
    for number in np.unique(classes):
        percent = spread(wear[classes == number])
        if percent is not None:
            yield MileageClass(float(number * width), float((number + 1) * width), percent)
