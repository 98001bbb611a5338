"""The store of compiled programs: what it gives back, what it refuses, and that it never fails."""

import importlib
import os
import stat
import subprocess
import sys

import pytest

from lagrange_cli.native.compilation import cache as module
from lagrange_cli.native.compilation.cache import Cache, cache_folder, find_cache, name_of, pack, unpack
from tests.support.command import PATIENCE, environment


@pytest.fixture
def cache(tmp_path):
    return Cache(str(tmp_path / "a" / "cache"))


def entry(cache, key):
    return os.path.join(cache.folder, name_of(key))


def test_what_is_kept_is_found_again_under_its_key_only(cache):
    assert cache.load("key") is None
    cache.store("key", b"code")
    assert cache.load("key") == b"code"
    assert cache.load("another") is None
    cache.store("key", b"newer")
    assert cache.load("key") == b"newer"
    assert len(cache.entries()) == 1


def test_every_byte_comes_back(cache):
    payload = bytes(range(256)) * 1000 + b"\n\0"
    cache.store("κ" * 5000, payload)
    assert cache.load("κ" * 5000) == payload
    cache.store("empty", b"")
    assert cache.load("empty") == b""


def test_folder_and_entries_are_private(cache):
    cache.store("key", b"code")
    assert stat.S_IMODE(os.stat(cache.folder).st_mode) == 0o700
    assert stat.S_IMODE(os.stat(entry(cache, "key")).st_mode) == 0o600


@pytest.mark.parametrize("place", range(0, 90, 3))
def test_a_flipped_bit_is_noticed(place):
    content = bytearray(pack("key", b"some code"))
    place %= len(content)
    content[place] ^= 1
    assert unpack("key", bytes(content)) is None
    content[place] ^= 1
    assert unpack("key", bytes(content)) == b"some code"


@pytest.mark.parametrize("length", range(len(pack("key", b"some code"))))
def test_a_truncated_entry_is_noticed(length):
    assert unpack("key", pack("key", b"some code")[:length]) is None


def test_content_of_another_key_is_noticed(cache):
    cache.store("key", b"code")
    os.rename(entry(cache, "key"), entry(cache, "other"))
    assert cache.load("other") is None
    assert unpack("ke", pack("key", b"code")) is None


@pytest.mark.parametrize(
    "content", [b"", b"x", module.MAGIC, b"\0" * 1000], ids=["empty", "x", "magic", "zeros"]
)
def test_a_damaged_entry_is_replaced(cache, content):
    cache.store("key", b"code")
    with open(entry(cache, "key"), "wb") as file:
        file.write(content)
    assert cache.load("key") is None
    cache.store("key", b"code")
    assert cache.load("key") == b"code"


def test_a_directory_in_the_place_of_an_entry_does_no_harm(cache):
    os.makedirs(os.path.join(entry(cache, "key"), "inner"), mode=0o700)
    os.chmod(cache.folder, 0o700)
    assert cache.load("key") is None
    cache.store("key", b"code")
    assert cache.load("key") is None
    assert os.listdir(cache.folder) == [name_of("key")]
    assert cache.entries() == [] and cache.clear() == 0


def test_a_pipe_or_a_link_in_the_place_of_an_entry_is_not_followed(cache, tmp_path):
    cache.store("key", b"code")
    os.rename(entry(cache, "key"), tmp_path / "elsewhere")
    os.symlink(tmp_path / "elsewhere", entry(cache, "key"))
    assert cache.load("key") is None
    os.unlink(entry(cache, "key"))
    os.mkfifo(entry(cache, "key"), 0o600)
    assert cache.load("key") is None
    cache.store("key", b"code")
    assert cache.load("key") == b"code"


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o702])
def test_a_folder_that_others_may_write_to_is_not_used(cache, mode):
    cache.store("key", b"code")
    os.chmod(cache.folder, mode)
    assert cache.load("key") is None
    cache.store("other", b"code")
    assert len(os.listdir(cache.folder)) == 1
    with pytest.raises(OSError, match="other users may write"):
        cache.entries()
    os.chmod(cache.folder, 0o700)
    assert cache.load("key") == b"code"


@pytest.mark.parametrize("mode", [0o606, 0o660])
def test_an_entry_that_others_may_write_to_is_not_used(cache, mode):
    cache.store("key", b"code")
    os.chmod(entry(cache, "key"), mode)
    assert cache.load("key") is None
    cache.store("key", b"code")
    assert cache.load("key") == b"code"


def test_what_belongs_to_another_user_is_not_used(cache, monkeypatch):
    cache.store("key", b"code")
    me = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: me + 1)
    assert cache.load("key") is None
    cache.store("other", b"code")
    assert len(os.listdir(cache.folder)) == 1
    with pytest.raises(OSError, match="belongs to another user"):
        cache.clear()


def test_an_entry_of_another_user_in_a_folder_of_ones_own_is_not_used(cache, monkeypatch):
    cache.store("key", b"code")
    real = os.fstat

    def fstat(descriptor):
        status = list(real(descriptor))
        if stat.S_ISREG(status[0]):
            status[4] += 1
        return os.stat_result(status)

    monkeypatch.setattr(os, "fstat", fstat)
    assert cache.load("key") is None


def refuse(*arguments, **options):
    raise OSError(28, "No space left on device")


@pytest.mark.parametrize("function", ["open", "makedirs", "write", "replace", "scandir", "urandom"])
def test_a_full_or_read_only_disk_is_no_error_and_leaves_nothing_behind(cache, monkeypatch, function):
    os.makedirs(cache.folder, mode=0o700)
    with monkeypatch.context() as patched:
        patched.setattr(os, function, refuse)
        if function == "open":
            patched.setattr(os, "supports_dir_fd", {refuse})
        cache.store("key", b"code")
        cache.load("key")
    assert not [name for name in os.listdir(cache.folder) if name.endswith(module.UNFINISHED)]


def test_a_folder_that_cannot_be_made_is_no_error(tmp_path):
    (tmp_path / "file").write_text("")
    cache = Cache(str(tmp_path / "file" / "cache"))
    cache.store("key", b"code")
    assert cache.load("key") is None


def test_the_least_recently_used_make_room(cache):
    size = len(pack("0", b"x" * 1000))
    cache = Cache(cache.folder, largest=4 * size)
    for i in range(4):
        cache.store(str(i), b"x" * 1000)
        os.utime(entry(cache, str(i)), (i, i))
    assert cache.load("0") is not None  # used last from here on
    cache.store("4", b"x" * 1000)
    kept = {key for key in "01234" if os.path.exists(entry(cache, key))}
    assert kept == {"0", "3", "4"}
    assert sum(one.size for one in cache.entries()) <= 4 * size


def test_what_is_larger_than_the_cache_is_not_kept(cache):
    cache = Cache(cache.folder, largest=1000)
    cache.store("key", b"x" * 1000)
    assert not os.path.exists(cache.folder)


def test_unfinished_files_are_removed_once_they_are_old(cache):
    os.makedirs(cache.folder, mode=0o700)
    for name, age in (("old.part", 0), ("new.part", None)):
        path = os.path.join(cache.folder, name)
        with open(path, "w"):
            pass
        if age is not None:
            os.utime(path, (age, age))
    cache.store("key", b"code")
    assert sorted(os.listdir(cache.folder)) == sorted(["new.part", name_of("key")])


def test_clear_removes_entries_and_nothing_else(cache):
    for key in "abc":
        cache.store(key, b"code")
    with open(os.path.join(cache.folder, "mine.txt"), "w"):
        pass
    assert cache.clear() == 3
    assert os.listdir(cache.folder) == ["mine.txt"]


WRITER = """
import sys
from lagrange_cli.native.compilation.cache import Cache
cache, me = Cache(sys.argv[1], largest=20_000), sys.argv[2]
for i in range(100):
    key = str(i % 5)
    found = cache.load(key)
    assert found is None or found == key.encode() * 1000, found
    cache.store(key, key.encode() * 1000)
    cache.store(me + key, b"x" * 3000)
    if i == 50:
        cache.clear()
"""


def test_processes_share_the_folder_without_waiting_or_failing(cache):
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", WRITER, cache.folder, str(i)], env=environment(), stderr=subprocess.PIPE
        )
        for i in range(4)
    ]
    for process in processes:
        _, messages = process.communicate(timeout=PATIENCE)
        assert (process.returncode, messages) == (0, b"")
    assert not [name for name in os.listdir(cache.folder) if name.endswith(module.UNFINISHED)]


def test_the_environment_says_where_and_whether(monkeypatch, tmp_path):
    monkeypatch.setenv("LAGRANGE_CACHE_DIR", str(tmp_path / "x"))
    assert cache_folder() == str(tmp_path / "x")
    assert find_cache() == Cache(str(tmp_path / "x"))
    assert find_cache(wanted=False) is None
    for value, none in (("1", True), ("", False), ("0", False)):
        monkeypatch.setenv("LAGRANGE_NO_CACHE", value)
        assert (find_cache() is None) is none


@pytest.mark.parametrize(
    ("platform", "environment", "folder"),
    [
        ("linux", {"XDG_CACHE_HOME": "/x", "HOME": "/home/me"}, "/x/lagrange-cli"),
        ("linux", {"XDG_CACHE_HOME": "relative", "HOME": "/home/me"}, "/home/me/.cache/lagrange-cli"),
        ("linux", {"HOME": "/home/me"}, "/home/me/.cache/lagrange-cli"),
        ("darwin", {"HOME": "/Users/me"}, "/Users/me/Library/Caches/lagrange-cli"),
        ("win32", {"LOCALAPPDATA": "/local"}, "/local/lagrange-cli"),
        ("win32", {}, None),
    ],
)
def test_the_platform_says_where(monkeypatch, platform, environment, folder):
    for name in ("LAGRANGE_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "platform", platform)
    assert cache_folder() == folder


@pytest.mark.parametrize("missing", [0, 1, 2])
@pytest.mark.parametrize("loaded", [True, False])
def test_the_digest_is_sha_256_by_whatever_module(monkeypatch, missing, loaded):
    """OpenSSL's, which is fast, if it has been imported; and only if there is no other where it has not."""
    names, used = ("_sha2", "_sha256", "hashlib"), []
    known = dict.fromkeys(names[missing:], importlib.import_module("hashlib"))

    def import_module(name):
        if name not in known:
            raise ImportError
        used.append(name)
        return known[name]

    monkeypatch.setattr(module, "import_module", import_module)
    if not loaded:
        monkeypatch.delitem(sys.modules, "hashlib")
    expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert module.digest(b"abc").hex() == expected
    assert used == ["hashlib" if loaded else names[missing]]
