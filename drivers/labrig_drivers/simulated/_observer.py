"""Who looks: measurement noise, repeatability, and markers that are hidden from the cameras.

Noise of one frame, each axis of each marker on its own: normal, `noise_mm`. Repeatability: one normal offset
of `repeatability_mm` per axis and marker, drawn anew at every actuation and kept during the hold. So the
mean of n frames of one hold repeats to  floor = sqrt(repeatability_mm^2 + noise_mm^2 / n)  per axis.

Occlusion: at every actuation each marker is out of sight for the whole hold with a probability of its own
(0.2 to 2.5 times `occlusion`); besides, any marker in sight flickers away for about 50 ms now and then
(`occlusion` / 10 of the frames).
"""

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig_drivers._protocols import MarkerStatus


class Observer:
    """Turns true positions into what cameras report; deterministic by seed, whatever the polling."""

    def __init__(
        self, markers: int, seed: int, noise_mm: float, repeatability_mm: float, occlusion: float
    ) -> None:
        self.noise_mm, self.repeatability_mm, self.occlusion = noise_mm, repeatability_mm, occlusion
        self._markers = markers
        self._holds = np.random.default_rng([seed, 1])
        self._frames = np.random.default_rng([seed, 2])
        self._flicker = np.random.default_rng([seed, 3])
        share = np.exp(np.random.default_rng([seed, 4]).uniform(np.log(0.2), np.log(2.5), markers))
        self._chance = np.minimum(occlusion * share / share.mean(), 0.9)
        self._starts_s = [-np.inf]
        self._offsets = [np.zeros((markers, 3))]
        self._hidden = [np.zeros(markers, dtype=bool)]
        self._dark_frames = np.zeros(markers, dtype=int)
        self.next_hold(0.0)

    def capture_floor_mm(self, frames: int) -> float:
        """What means over `frames` frames of two equal holds differ from their true value by, mm rms per
        axis.
        """
        return float(np.hypot(self.repeatability_mm, self.noise_mm / np.sqrt(frames)))

    def next_hold(self, time_s: float) -> None:
        """Other set-points from `time_s` on: other markers out of sight, another offset."""
        offset = self.repeatability_mm * self._holds.normal(size=(self._markers, 3))
        hidden = self._holds.random(self._markers) < self._chance
        if self._starts_s[-1] >= time_s:
            self._offsets[-1], self._hidden[-1] = offset, hidden
            return
        self._starts_s.append(time_s)
        self._offsets.append(offset)
        self._hidden.append(hidden)
        if len(self._starts_s) > 20_000:
            for kept in (self._starts_s, self._offsets, self._hidden):
                del kept[:10_000]

    def look(self, time_s: Floats, position_mm: Floats) -> tuple[Floats, NDArray[np.int8]]:
        """Reported positions (F, M, 3), NaN unless seen, and status (F, M), for frames at times (F,)."""
        hold = np.searchsorted(self._starts_s, time_s, side="right") - 1
        first, which = np.unique(hold, return_inverse=True)
        offset = np.stack([self._offsets[k] for k in first])[which]
        dark = np.stack([self._hidden[k] for k in first])[which]
        seen = position_mm + offset + self.noise_mm * self._frames.normal(size=position_mm.shape)
        dark = dark | self._flickers(len(time_s))
        seen[dark] = np.nan
        return seen, np.where(dark, MarkerStatus.OCCLUDED, MarkerStatus.SEEN).astype(np.int8)

    def _flickers(self, frames: int, mean_frames: int = 5) -> NDArray[np.bool_]:
        start = self._flicker.random((frames, self._markers)) < 0.1 * self.occlusion / mean_frames
        dark = start.copy()
        for lag in range(1, mean_frames):
            dark[lag:] |= start[:-lag]
        head = np.arange(frames)[:, None] < self._dark_frames
        last = np.where(start.any(axis=0), frames - 1 - np.argmax(start[::-1], axis=0), -10 * mean_frames)
        self._dark_frames = np.maximum(np.maximum(last + mean_frames - frames, self._dark_frames - frames), 0)
        return dark | head
