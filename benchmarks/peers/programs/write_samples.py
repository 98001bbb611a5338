"""Write five series of random numbers to an HDF5 file with h5py, and wait until they are on disk.

The arguments are the length of each series, and the file.
"""

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
