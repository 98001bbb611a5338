"""Write five series of random numbers to HDF5 as fast as h5py does, and have them on disk at the end; the
arguments are how many numbers each has, and the file."""

import os
import sys

import h5py
import numpy as np

SERIES = ("t", "q/theta", "v/theta", "diagnostics/p/theta", "diagnostics/h")
CHUNK = 65536

count, name = int(sys.argv[1]), sys.argv[2]
numbers = np.random.default_rng(0).random(16 * CHUNK)
with h5py.File(name, "w") as file:
    series = [file.create_dataset(path, shape=(count,), chunks=(CHUNK,), dtype="f8") for path in SERIES]
    for start in range(0, count, len(numbers)):
        stop = min(start + len(numbers), count)
        for each in series:
            each[start:stop] = numbers[: stop - start]
with open(name, "rb") as file:
    os.fsync(file.fileno())
