"""What plots show of outputs: the samples of the file, and what to ask for where they are missing."""

import weakref

import h5py
import numpy as np
import pytest

from lagrange_cli.errors import UsageError
from lagrange_cli.figures.panels import Band, Curve, Histogram, Map
from lagrange_cli.run.plot import PlotRequest, page_of
from lagrange_cli.run.plots import quantities as quantity_names
from lagrange_cli.run.plots import reading
from lagrange_cli.run.plots.motions import Run
from lagrange_cli.run.plots.quantities import Quantity, quantities, unit_text
from lagrange_cli.run.plots.sweeps import over_members
from lagrange_cli.store.result import Result
from tests.support.command import SYSTEMS, lagrange


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("plots")
    pendulum = SYSTEMS / "pendulum.yaml"
    outputs = "q,v,p,h,T,U,positions,reactions,ledger"
    lagrange("solve", pendulum, "--stop", "5", "--outputs", outputs, "-o", "run.h5", cwd=made)
    lagrange("solve", pendulum, "--stop", "5", "--outputs", "q", "-o", "few.h5", cwd=made)
    grid = ("--over", "l=1:2:3", "--over", "theta=0.1:0.2:2", "--stop", "2", "--outputs", "q,h")
    lagrange("sweep", pendulum, *grid, "-o", "grid.h5", cwd=made)
    lagrange("sweep", pendulum, "--over", "l=1:2:3", "--stop", "2", "-o", "line.h5", cwd=made)
    drawn = ("--random", "theta=normal(0,0.1)", "--members", "7", "--seed", "1", "--stop", "2")
    lagrange("sweep", pendulum, *drawn, "-o", "drawn.h5", cwd=made)
    henon = "section", SYSTEMS / "henon_heiles.yaml", "--where", "x", "--crossings"
    lagrange(*henon, "20", cwd=made)
    lagrange(*henon, "15", "--over", "y0=0:0.2:3", "--stop", "80", "-o", "sections.h5", cwd=made)
    return made


def panels(folder, name, *what, x=None, y=()):
    with Result(str(folder / name)) as result:
        return page_of([result], PlotRequest(what, x, y)).panels


@pytest.mark.exhaustive(keep=0.35)
def test_curves_are_the_samples_of_the_file(folder):
    (q,), (phase,) = panels(folder, "run.h5", "q"), panels(folder, "run.h5", "phase")
    with h5py.File(folder / "run.h5") as file:
        t, theta, v = file["t"][:], file["q/theta"][:], file["v/theta"][:]
    np.testing.assert_array_equal([q.items[0].x, q.items[0].y], [t, theta])
    np.testing.assert_array_equal([phase.items[0].x, phase.items[0].y], [theta, v])
    assert (q.x, q.y) == ("$t$ (s)", r"$\theta$ (rad)")
    assert (phase.x, phase.y) == (r"$\theta$ (rad)", r"$\dot{\theta}$ (rad/s)")


def test_drifts_of_members_are_points_where_some_are_0(folder):
    """A line would come down from each neighbour of such a member, as 0 is nowhere on a logarithmic scale."""
    with Result(str(folder / "line.h5")) as result:
        run = Run(result, quantities(result))
        for values, points in ([1e-15, 0.0, 2e-15], True), ([1e-15, 3e-15, 2e-15], False):
            (curve,) = over_members(run, np.array(values), "drift", "drift", logarithmic=True).items
            assert curve.points is points
            np.testing.assert_array_equal(curve.y, np.where(np.array(values) > 0, values, np.nan))


@pytest.mark.exhaustive(keep=0.35)
def test_drift_is_the_distance_from_the_first_value(folder):
    (drift,) = panels(folder, "run.h5", "drift")
    with h5py.File(folder / "run.h5") as file:
        h = file["diagnostics/h"][:]
        largest = max(abs(file[f"diagnostics/{name}"][:]).max() for name in "TU")
    band, curve = drift.items
    assert isinstance(band, Band) and band.high[0] == 2.0**-52 * max(largest, abs(h).max())
    np.testing.assert_array_equal(curve.y, h - h[0])


def test_the_usual_page_and_every_word(folder):
    assert [panel.title for panel in panels(folder, "run.h5")] == [
        "coordinates", r"phase portrait of $\theta$", "path in space", "drift of $h$",
    ]  # fmt: skip
    words = ("v", "p", "positions", "energy", "ledger", "spectrum", "reactions")
    found = panels(folder, "run.h5", *words)
    assert len(found) >= len(words) and all(panel.items for panel in found)


def test_a_long_name_has_room_beside_an_axis():
    short, long = (
        Quantity(name, f"q/{name}", (), "m").symbol for name in ("stretch", "a" * 50 + "_" + "b" * 50)
    )
    assert "stretch" in short and len(long) < 60 and "\N{HORIZONTAL ELLIPSIS}" in long


def test_what_rests_is_left_out_unless_it_is_asked_for(tmp_path):
    """A bead at the bottom of its wire: no phase portrait and no path, but a coordinate over time."""
    rest = "solve", SYSTEMS / "parabola_bead.yaml", "--set", "x=0", "--stop", "1"
    lagrange(*rest, "--outputs", "q,v,positions", "-o", "rest.h5", cwd=tmp_path)
    assert [panel.title for panel in panels(tmp_path, "rest.h5")] == ["coordinates"]
    asked = panels(tmp_path, "rest.h5", "phase", "path")
    assert [panel.title for panel in asked] == ["phase portrait of $x$", "path in space"]


def test_the_path_is_the_circle_of_the_pendulum(folder):
    (path,) = panels(folder, "run.h5", "path")
    curve = path.items[0]
    np.testing.assert_allclose(curve.x**2 + curve.y**2, 1, rtol=1e-12)
    assert path.equal


def test_the_spectrum_of_a_cosine(tmp_path):
    lagrange(
        "solve",
        SYSTEMS / "harmonic_oscillator.yaml",
        "--stop",
        "100",
        "--samples",
        "4001",
        "-o",
        "r.h5",
        cwd=tmp_path,
    )
    (spectrum,) = panels(tmp_path, "r.h5", "spectrum")
    (curve,) = spectrum.items
    peak = curve.x[np.nanargmax(curve.y)]
    assert peak == pytest.approx(2 / (2 * np.pi), abs=0.01)  # sqrt(k/m) = 2
    assert np.nanmax(curve.y) == pytest.approx(1, rel=0.2)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (PlotRequest(("phase",)), "solve again with --outputs q,v"),
        (PlotRequest(("path",)), "solve again with --outputs positions"),
        (PlotRequest(("error",)), "solve again with --certify"),
        (PlotRequest(("phaze",)), "did you mean phase?"),
        (PlotRequest(("final",)), "not for a motion"),
        (PlotRequest((), None, ("bob.x",)), "with --outputs positions"),
        (PlotRequest((), None, ("p_theta",)), "with --outputs p"),
        (PlotRequest((), None, ("thta",)), "did you mean theta?"),
        (PlotRequest((), "theta", ()), "--x needs --y"),
    ],
)
def test_what_is_missing_is_named_with_what_to_ask_for(folder, asked, message):
    with Result(str(folder / "few.h5")) as result, pytest.raises(UsageError) as caught:
        page_of([result], asked)
    assert message in str(caught.value)


def test_a_quantity_over_another(folder):
    (panel,) = panels(folder, "run.h5", x="bob.x", y=("T",))
    with h5py.File(folder / "run.h5") as file:
        np.testing.assert_array_equal(panel.items[0].x, file["positions/bob"][:, 0])
        np.testing.assert_array_equal(panel.items[0].y, file["diagnostics/T"][:])


def test_a_grid_becomes_families_and_maps(folder):
    family, final, drift = panels(folder, "grid.h5")
    assert len(family.items) == 6 and family.scale.label == "$l$ (m)"
    with h5py.File(folder / "grid.h5") as file:
        theta = file["q/theta"][:]
    assert isinstance(final.items[0], Map) and isinstance(drift.items[0], Map)
    np.testing.assert_array_equal(final.items[0].values, theta[:, :, -1])
    np.testing.assert_array_equal(sorted(one.y[-1] for one in family.items), sorted(theta[:, :, -1].flat))


def test_the_final_values_are_those_of_the_event_that_stopped_each_member(tmp_path):
    """The range v^2 sin(2a)/g of a projectile; its samples end before that."""
    (tmp_path / "throw.yaml").write_text(
        "parameters: {g: 10, v: 10, a: 0.5}\n"
        "coordinates: {x: {initial: 0, velocity: v*cos(a)}, y: {initial: 0, velocity: v*sin(a)}}\n"
        "lagrangian: (x_dot**2 + y_dot**2)/2 - g*y\n"
        "events: {ground: {when: y, direction: falling, action: stop}}\n"
        "solve: {stop: 1.5, samples: 4}\n"
    )
    lagrange("sweep", "throw.yaml", "--over", "a=0.3:1.3:5", "--outputs", "q", cwd=tmp_path)
    x, _ = panels(tmp_path, "throw_sweep.h5", "final")
    (curve,) = x.items
    times = np.minimum(2 * np.sin(curve.x), 1.5)  # the steepest throws have not ended
    np.testing.assert_allclose(curve.y, 10 * np.cos(curve.x) * times, rtol=1e-13)


def test_random_members_become_histograms(folder):
    final, *_ = panels(folder, "drawn.h5")
    with h5py.File(folder / "drawn.h5") as file:
        np.testing.assert_array_equal(final.items[0].values, file["q/theta"][:])
    assert isinstance(final.items[0], Histogram)


def test_a_section_leaves_out_the_coordinate_that_it_fixes(folder):
    (panel,) = panels(
        folder,
        "Henon-Heiles_section.h5"
        if (folder / "Henon-Heiles_section.h5").exists()
        else "henon_heiles_section.h5",
    )
    assert (panel.x, panel.y) == ("$y$", r"$\dot{y}$")
    assert isinstance(panel.items[0], Curve) and panel.items[0].points


def test_the_points_of_many_motions_are_in_one_plane_told_apart_by_colour(folder):
    (panel,) = panels(folder, "sections.h5")
    assert (panel.x, panel.y, panel.scale.label) == ("$y$", r"$\dot{y}$", "$y_{0}$")
    with h5py.File(folder / "sections.h5") as file:
        y, v = file["q/y"][:], file["v/y"][:]
    assert y.shape == (3, 15) and np.isnan(y).any()  # some motions have fewer
    assert [one.points for one in panel.items] == [True] * 3
    np.testing.assert_array_equal([one.x for one in panel.items], y)
    np.testing.assert_array_equal([one.y for one in panel.items], v)
    assert [one.shade for one in panel.items] == [0, 0.5, 1]
    with Result(str(folder / "sections.h5")) as result:
        (diagram,) = [
            one for one in page_of([result], PlotRequest(("diagram",), None, ())).panels if one.y == "$y$"
        ]
        np.testing.assert_array_equal(diagram.items[0].x, np.repeat([0, 0.1, 0.2], 15))
        np.testing.assert_array_equal(diagram.items[0].y, y.reshape(-1))
        (drift,) = page_of([result], PlotRequest(("drift",), None, ())).panels
        assert len(drift.items[0].x) == 3
        (over,) = page_of([result], PlotRequest((), "x_dot", ("h",))).panels
        assert len(over.items) == 3


def test_a_long_motion_keeps_its_extremes(folder, monkeypatch):
    monkeypatch.setattr(reading, "BUCKETS", 20)
    monkeypatch.setattr(reading, "PIECE", 64)
    with Result(str(folder / "run.h5")) as result:
        known = quantities(result)
        whole = result.read("v/theta")
        ((t, x),) = reading.over_time(result, known["t"], [known["theta_dot"]])
        times = result.read("t")
    assert len(x) <= 44 and (x.min(), x.max()) == (whole.min(), whole.max())
    assert set(zip(t, x)) <= set(zip(times, whole)) and (np.diff(t) >= 0).all()


def test_columns_of_a_dataset_are_read_together(tmp_path, monkeypatch):
    """A pass over the samples for all coordinates of a panel, however long the motion; all values stay."""
    chain = SYSTEMS / "n_pendulum.yaml"
    lagrange("solve", chain, "--stop", "2", "--samples", "401", "-o", "chain.h5", cwd=tmp_path)
    monkeypatch.setattr(reading, "BUCKETS", 40)
    monkeypatch.setattr(reading, "PIECE", 500)
    read, seen = Result.read, []
    with Result(str(tmp_path / "chain.h5")) as result:
        known = quantities(result)
        wanted = [known[f"theta[{i}]"] for i in range(5)]
        alone = [reading.over_time(result, known["t"], [one])[0] for one in wanted]
        monkeypatch.setattr(Result, "read", lambda *given: seen.append(given[1]) or read(*given))
        both = reading.over_time(result, known["t"], wanted)
        pieces = seen.count("t")
    assert 1 < pieces == seen.count("q/theta")
    for one, other in zip(alone, both):
        np.testing.assert_array_equal(one, other)


def test_units_are_written_as_they_are_read():
    assert unit_text("kg*m^2/s^2") == "kg\N{MIDDLE DOT}m$^{2}$/s$^{2}$"
    assert unit_text("$x$") == r"\$x\$"


def test_a_long_output_is_not_kept_while_it_is_read(folder, monkeypatch):
    """Of each part only the samples that are drawn stay in memory."""
    monkeypatch.setattr(reading, "PIECE", 20)
    monkeypatch.setattr(reading, "POINTS", 50)
    monkeypatch.setattr(reading, "BUCKETS", 20)
    read, seen, most = Result.read, [], 0

    def counted(self, path, part=...):
        nonlocal most
        found = read(self, path, part)
        seen.append(weakref.ref(found))
        most = max(most, sum(one() is not None for one in seen))
        return found

    with Result(str(folder / "run.h5")) as result:
        known = quantities(result)
        monkeypatch.setattr(Result, "read", counted)
        wanted = [known["theta"], known["theta_dot"], known["t"]]
        columns, step = reading.together(result, wanted)
        assert len(seen) > 20 and most <= 2 * len(wanted)
        np.testing.assert_array_equal(columns[0], read(result, "q/theta")[::step])
        seen.clear()
        most = 0
        reading.over_time(result, known["t"], [known["theta"]])
        reading.extremes(result, known["theta"])
        assert len(seen) > 20 and most <= 4


WIRE = """
coordinates: {{s: {{initial: 0.5}}}}
masses: {{bead: 1, nail: 2}}
embedding: {{bead: [{}], nail: [{}]}}
potential: s**2
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    ("bead", "nail", "axes"),
    [
        ("sin(s), cos(s), 2", "1, 1, 2", "xy"),
        ("sin(s), 2, cos(s)", "1, 2, 1", "xz"),
        ("-1, sin(s), cos(s)", "-1, 1, 1", "yz"),
        ("sin(s), cos(s), 2", "1, 1, 0", "xyz"),  # in two planes
        ("sin(s), cos(s), s", "1, 1, 0", "xyz"),
        ("sin(s), cos(s)", "1, 1", "xy"),
    ],
)
def test_a_path_is_drawn_in_its_plane_and_what_stands_as_a_point(tmp_path, bead, nail, axes):
    (tmp_path / "wire.yaml").write_text(WIRE.format(bead, nail))
    lagrange("solve", "wire.yaml", "--stop", "1", "--outputs", "q,positions", cwd=tmp_path)
    (path,) = panels(tmp_path, "wire.h5", "path")
    assert [path.x, path.y, *filter(None, [path.z])] == [f"${axis}$" for axis in axes]
    moving, standing = path.items
    with h5py.File(tmp_path / "wire.h5") as file:
        r = file["positions/bead"][:]
    shown = [moving.x, moving.y, *([] if moving.z is None else [moving.z])]
    np.testing.assert_array_equal(shown, r[:, ["xyz".index(axis) for axis in axes]].T)
    assert not moving.points and standing.points and len(standing.x) == 1


ROPE = """
sizes: {N: 1200}
parameters: {g: 9.81}
coordinates: {"y[i in range(N)]": {initial: "0.1*sin(i)"}}
masses: {"bead[i in range(N)]": 1}
embedding: {"bead[i in range(N)]": "[i, y[i]]"}
potential: sum(g*y[i] for i in range(N))
"""


def test_motions_of_many_particles_are_read_once_and_paths_that_are_too_short_are_points(
    tmp_path, monkeypatch
):
    """1200 beads fall by 1e-4 of the length of their row. At most 1000 paths are drawn, and 200 curves."""
    (tmp_path / "rope.yaml").write_text(ROPE)
    options = ("--stop", "0.15", "--samples", "9", "--outputs", "q,positions")
    lagrange("solve", "rope.yaml", *options, cwd=tmp_path)
    read = list[str]()
    monkeypatch.setattr(Result, "read", noting(read, Result.read))
    (path,) = panels(tmp_path, "rope.h5", "path")
    (over_time,) = panels(tmp_path, "rope.h5", "q")
    assert read.count("positions/bead") == read.count("q/y") == 1
    assert len(over_time.items) == 200
    assert [curve.x.tolist() for curve in path.items] == [[i, i] for i in range(0, 1200, 2)]
    assert all(curve.points and curve.y[1] < curve.y[0] - 0.1 for curve in path.items)


def test_datasets_that_are_too_large_for_a_plot_are_named(tmp_path, monkeypatch):
    """The positions of 1200 beads are 2400 numbers."""
    (tmp_path / "rope.yaml").write_text(ROPE)
    options = ("--stop", "0.15", "--samples", "9", "--outputs", "q,positions")
    lagrange("solve", "rope.yaml", *options, cwd=tmp_path)
    monkeypatch.setattr(quantity_names, "MOST_MEMBERS", 1200)
    assert panels(tmp_path, "rope.h5", "q")
    told = "positions/bead has 2400 numbers for each sample, and plots have at most 1200; read it with h5py"
    with pytest.raises(UsageError, match=f"--what path: in .*rope.h5, {told}"):
        panels(tmp_path, "rope.h5", "path")
    with pytest.raises(UsageError, match=f"--y bead\\[3\\].y: in .*rope.h5, {told}"):
        panels(tmp_path, "rope.h5", y=("bead[3].y",))


def noting(names, read):
    """``read``, which notes the paths of what is read."""

    def noted(result, path, *part):
        names.append(path)
        return read(result, path, *part)

    return noted
