"""What an earlier run differs in, where it cannot be continued."""

import pytest

from lagrange_cli.errors import FileError
from lagrange_cli.store.resume import check_same

RUN = {"generator": "lagrange", "run": "a", "sweep": "3 l", "parameters": "m", "further": 1}


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"run": "b", "sweep": "4 l"}, "with other members"),
        ({"run": "b"}, "with another initial state"),
        ({"parameters": "M", "run": "b"}, "with other parameters"),
        ({"further": 2, "run": "b"}, "with another initial state"),
        ({"further": 2}, "with another further"),
    ],
)
def test_what_says_more_is_told(changed, said):
    check_same("out.h5", RUN, dict(RUN))
    with pytest.raises(FileError, match=f"it was made {said}"):
        check_same("out.h5", {**RUN, **changed}, RUN)
