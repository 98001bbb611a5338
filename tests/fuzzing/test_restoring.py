"""Leaving the compiled loop and entering it again changes no bit, wherever, in code of any level."""

import os
import random

import pytest

from tests.fuzzing import restoring


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("kind", ["wedges", "wall", "driven", "shipped"])
def test_a_motion_taken_to_pieces_anywhere_is_the_same_motion(kind):
    """Of new motions; ``python -m tests.fuzzing.restoring --runs 1 --seed N --kind KIND`` repeats one."""
    pieces = 0
    while pieces < 20:  # a short motion has few
        seed = int.from_bytes(os.urandom(4), "little")
        print(f"--seed {seed} --kind {kind}")
        found = restoring.attempt(seed, kind)
        assert found > 0
        pieces += found


@pytest.mark.exhaustive(keep=0.2)
def test_pieces_of_one_sample_and_one_step():
    """What once went wrong: the number of doubtful steps was lost at the end of a chunk of samples."""
    case = restoring.Case("driven_damped_pendulum", 60.0, 601, ("q", "v", "h", "ledger"))
    assert restoring.compare(case, random.Random(1), 1) > 1000
