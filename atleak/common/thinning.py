"""Thin a long series for a sheet, a page or a picture without losing a spike of one sample."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

BREAKS = 400  # edges of stretches without values that are kept of each series at most


def thinned(series: Sequence[np.ndarray], points: int, keep: Sequence[int] = ()) -> np.ndarray:
    """Choose about ``points`` samples that show the course of several series of equal length.

    Every stretch keeps its lowest and highest value, so that a spike of one sample stays; so do both ends and the edges
    of stretches without values. Nothing is averaged.

    Parameters
    ----------
    series
        arrays of shape (n,) on one time base; NaN where a value is missing.
    points
        how many samples are wanted; a series that has no more is taken whole.
    keep
        indices that stay in any case.

    Returns
    -------
    numpy.ndarray
        rising indices into the series.
    """
    from tsdownsample import MinMaxDownsampler  # most runs draw no series

    size = len(series[0])
    if size <= points:
        return np.arange(size)
    each = max(points // len(series) // 2 * 2, 4)
    chosen = [np.array([0, size - 1, *keep])]
    for values in series:
        known = np.isfinite(values)
        usable = np.flatnonzero(known)
        if len(usable) > each:
            extremes = MinMaxDownsampler().downsample(np.ascontiguousarray(values[usable], dtype=float), n_out=each)
            usable = usable[np.asarray(extremes, dtype=int)]
        edges = np.flatnonzero(known[1:] != known[:-1])[:BREAKS]
        chosen += [usable, edges, edges + 1]
    return np.unique(np.concatenate(chosen))
