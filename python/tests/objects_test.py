"""Objects of ASE, MDAnalysis, OVITO and pandas keep what they hold, and files of other packages are read.

Tests of packages that are not there are skipped; packages_test.py says how to install them.
"""

import importlib.util
import os
import sys

OTHER = os.environ.get("PARRAY_PACKAGES_PYTHON", "")
if OTHER and "PARRAY_OBJECTS" not in os.environ:
    os.execve(OTHER, [OTHER, *sys.argv], {**os.environ, "PARRAY_OBJECTS": "1"})

import warnings

from support import SKIPPED, SMALL, SOURCE, Test, main, needs, np, parray

HELIX = SOURCE / "scenes/particles/helix.pdb"
LARGE = {"width": 300, "height": 200, "spp": 2}


class ObjectTest(Test):
    def setUp(self):
        super().setUp()
        warnings.simplefilter("ignore")

    def legend(self, source, by, **options):
        """The legend of a picture that is coloured by a column."""
        return parray.render(source, color_by=by, **{**SMALL, **options}).report["legends"][0]

    def names(self, source, by, **options):
        return [entry["name"] for entry in self.legend(source, by, **options)["entries"]]

    def assert_ends(self, legend, values):
        np.testing.assert_allclose((legend["low"], legend["high"]), (np.min(values), np.max(values)), rtol=1e-6, atol=1e-6)

    def assert_same(self, first, second):
        self.assertEqual(first.report["scene_sha256"], second.report["scene_sha256"])


@needs("ase")
class Ase(ObjectTest):
    def setUp(self):
        super().setUp()
        import ase.build
        from ase.calculators.emt import EMT

        self.atoms = ase.build.bulk("Cu", a=3.6, cubic=True) * (2, 2, 2)
        self.atoms.rattle(0.25, seed=2)
        self.atoms.positions = self.atoms.positions.round(4)
        self.atoms.calc = EMT()

    def test_the_cell_is_that_of_its_file(self):
        import ase.io

        ase.io.write(self.folder / "a.extxyz", self.atoms)
        for options in ({"cell": True}, {"view": "iso", "slice": "x=0%:50%", "cell": True}):
            found, expected = (parray.render(s, **options, **LARGE) for s in (self.atoms, self.folder / "a.extxyz"))
            self.assert_same(found, expected)
            np.testing.assert_array_equal(found.srgb(), expected.srgb())
        self.atoms.set_cell(None)
        self.refused(parray.InputError, "no cell", parray.render, self.atoms, cell=True, **LARGE)

    def test_arrays_tags_charges_momenta_and_results_are_columns(self):
        count = len(self.atoms)
        self.atoms.set_array("energy_pa", np.arange(count) ** 2.0)
        self.atoms.set_tags(range(count))
        self.atoms.set_initial_charges(np.linspace(-1, 1, count))
        self.atoms.set_momenta(self.atoms.positions)
        forces = self.atoms.get_forces()
        energies = self.atoms.get_potential_energies()
        for by, values in (("energy_pa", np.arange(count) ** 2), ("tags", range(count)), ("charge", [-1, 1]),
                           ("mass", [63.546 * 0.5, 63.546 * 1.5]), ("momenta_x", self.atoms.positions[:, 0]),
                           ("momenta", np.linalg.norm(self.atoms.positions, axis=1)), ("forces_z", forces[:, 2]), ("energies", energies)):  # fmt: skip
            with self.subTest(by):
                self.assert_ends(self.legend(self.atoms, by), values)
        self.assertLess(parray.render(self.atoms, select="tags < 3", **SMALL).report["spheres"], 6)

    def test_elements_are_symbols_even_if_only_hydrogen_is_there(self):
        import ase.build

        self.assertEqual(self.names(ase.build.molecule("H2"), "element"), ["H"])

    def test_residues_of_a_pdb_file_are_kept(self):
        import ase.io

        atoms = ase.io.read(HELIX)
        self.assert_ends(self.legend(atoms, "resid", select="protein"), [1, 12])
        self.assert_ends(self.legend(atoms, "occupancy"), [0.5, 1.5])

    def test_lists_and_trajectories_are_frames(self):
        from ase.io.trajectory import Trajectory

        other = self.atoms.copy()
        other.positions[:, 2] += 10
        with Trajectory(self.folder / "a.traj", "w") as file:
            file.write(self.atoms)
            file.write(other)
        for source in ([self.atoms, other], Trajectory(self.folder / "a.traj")):
            pictures = parray.render(source, color_by="z", **SMALL)
            ends = {p.report["legends"][0]["high"] for p in pictures}
            self.assertEqual((len(pictures), ends), (2, {other.positions[:, 2].max()}))
        self.assertEqual(len(parray.render(Trajectory(self.folder / "a.traj"), frames=[1], **SMALL)), 1)


@needs("MDAnalysis")
class MdAnalysis(ObjectTest):
    def setUp(self):
        super().setUp()
        import MDAnalysis

        self.universe = MDAnalysis.Universe(HELIX)

    def test_residues_chains_and_numbers_are_those_of_the_file(self):
        for by in ("chain", "residue", "atom", "element", "resid"):
            with self.subTest(by):
                self.assertEqual(self.legend(self.universe, by), self.legend(HELIX, by))
        self.universe.atoms.tempfactors = np.arange(68)
        self.universe.atoms.occupancies = np.linspace(0, 1, 68)
        self.universe.add_TopologyAttr("charges", np.linspace(-1, 1, 68))
        masses = self.universe.atoms.masses
        for by, values in (("b_factor", [0, 67]), ("occupancy", [0, 1]), ("charge", [-1, 1]), ("mass", masses)):
            self.assert_ends(self.legend(self.universe, by), values)

    def test_selections_are_those_of_the_file(self):
        for select in ("protein", "water", "resid 3:5", "backbone and not name CA", "same residue as within 4 of resname HOH"):
            found, expected = (parray.render(s, select=select, **SMALL).report["spheres"] for s in (self.universe, HELIX))
            self.assertEqual(found, expected)
        group = self.universe.select_atoms("resid 3:5")
        self.assert_ends(self.legend(group, "resid"), [3, 5])

    def test_the_box_is_kept(self):
        self.refused(parray.InputError, "no cell", parray.render, self.universe, cell=True, **LARGE)
        self.universe.dimensions = [40, 40, 50, 90, 90, 60]
        boxed = parray.render(self.universe, cell=True, view="front", **LARGE)
        self.assertLess(boxed.pixels.shape[0], 201)
        halves = [parray.render(self.universe, slice=part, **SMALL).report["spheres"] for part in ("z=0%:50%", "z=-50%:0%")]
        inside = self.universe.atoms.positions[:, 2]
        self.assertEqual(halves[0] - 2, ((inside >= 0) & (inside <= 25)).sum())

    def test_frames_share_one_camera(self):
        from MDAnalysis.coordinates.memory import MemoryReader

        first = self.universe.atoms.positions.copy()
        self.universe.load_new(np.stack([first, first * 2, first * 3]), format=MemoryReader)
        for frames, count in ((range(0, 3, 2), 2), ("all", 3)):
            pictures = parray.render(self.universe, frames=frames, color_by="x", **SMALL)
            ends = {p.report["legends"][0]["high"] for p in pictures}
            self.assertEqual((len(pictures), len(ends)), (count, 1))
            self.assertAlmostEqual(ends.pop(), 3 * float(first[:, 0].max()), places=3)
        self.assert_ends(self.legend(self.universe, "x", frame="last"), 3 * first[:, 0])
        for frame in (3, -4, "first"):
            self.refused(parray.InputError, "from 0 to 2", parray.render, self.universe, frame=frame, **SMALL)

    def test_types_that_are_numbers_stay_types(self):
        import MDAnalysis

        universe = MDAnalysis.Universe.empty(4, n_residues=2, atom_resindex=[0, 0, 1, 1], trajectory=True)
        universe.atoms.positions = np.eye(4)[:, :3] * 3
        universe.add_TopologyAttr("types", ["1", "2", "1", "2"])
        universe.add_TopologyAttr("resids", [5, 9])
        universe.add_TopologyAttr("masses", [12.0, 1.0, 12.0, 1.0])
        self.assertEqual(self.names(universe, "type"), ["1", "2"])
        self.assert_ends(self.legend(universe, "resid"), [5, 9])


@needs("ovito")
class Ovito(ObjectTest):
    def setUp(self):
        super().setUp()
        from ovito.data import DataCollection, ParticleType, SimulationCell
        from ovito.pipeline import Pipeline, StaticSource

        grid = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3)
        base = np.array([[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]])
        self.positions = 3.6 * (grid[:, None] + base).reshape(-1, 3) + 1
        data = DataCollection()
        particles = data.create_particles(count=len(self.positions))
        particles.create_property("Position", data=self.positions)
        types = particles.create_property("Particle Type", data=np.arange(len(self.positions)) % 2 + 1)
        types.types.append(ParticleType(id=1, name="big", color=(1, 0.5, 0.25), radius=0.8))
        types.types.append(ParticleType(id=2, name="small", color=(0.25, 0.5, 1), radius=0.5))
        particles.create_property("Force", data=self.positions)
        data.objects.append(SimulationCell(pbc=(True, True, True)))
        data.cell_[:, :3] = np.diag([14.4] * 3)
        data.cell_[:, 3] = (1, 1, 1)
        self.pipeline = Pipeline(source=StaticSource(data=data))

    def test_the_cell_and_its_corner_are_kept(self):
        small = np.arange(256) % 2 == 1
        colors = parray.srgb_to_linear(np.where(small[:, None], [0.25, 0.5, 1], [1, 0.5, 0.25]))
        same = parray.Particles(
            self.positions, np.where(small, 0.5, 0.8), colors, cell=np.diag([14.4] * 3), origin=(1, 1, 1)
        )
        found, expected = (parray.render(s, cell=True, view="front", **LARGE) for s in (self.pipeline, same))
        self.assertEqual(found._repr_png_(), expected._repr_png_())
        half = parray.render(self.pipeline, slice="x=0%:49%", crystal=False, **SMALL)
        self.assertEqual(half.report["spheres"] - 2, 128)

    def test_types_and_properties_are_columns_with_legends(self):
        from ovito.modifiers import CommonNeighborAnalysisModifier, ExpressionSelectionModifier

        self.assertEqual(self.names(self.pipeline, "type"), ["big", "small"])
        self.pipeline.modifiers.append(CommonNeighborAnalysisModifier())
        self.pipeline.modifiers.append(ExpressionSelectionModifier(expression="Position.X > 5"))
        self.assertEqual(self.names(self.pipeline, "Structure Type"), ["FCC"])
        self.assert_ends(self.legend(self.pipeline, "Force.X"), self.positions[:, 0])
        self.assert_ends(self.legend(self.pipeline, "force"), np.linalg.norm(self.positions, axis=1))
        chosen = parray.render(self.pipeline, select="selection = 1 and structure_type = 1", crystal=False, **SMALL)
        self.assertEqual(chosen.report["spheres"] - 2, (self.positions[:, 0] > 5).sum())

    def test_residues_of_a_pdb_file_are_kept(self):
        from ovito.io import import_file

        pipeline = import_file(str(HELIX))
        for select in ("protein", "resname CYS", "name CA"):
            found, expected = (parray.render(s, select=select, **SMALL).report["spheres"] for s in (pipeline, HELIX))
            self.assertEqual(found, expected)
        self.assertIn("A", self.names(pipeline, "chain"))

    def test_displacements_and_frames_share_one_range(self):
        from ovito.io import import_file
        from ovito.modifiers import CalculateDisplacementsModifier

        lines = [f"2\n\nC 0 0 0\nC {x} 0 0\n" for x in (1, 2, 5)]
        (self.folder / "run.xyz").write_text("".join(lines))
        pipeline = import_file(str(self.folder / "run.xyz"))
        pipeline.modifiers.append(CalculateDisplacementsModifier())
        for frames in ([0, 1, 2], "all"):
            pictures = parray.render(pipeline, frames=frames, color_by="Displacement Magnitude", **SMALL)
            self.assertEqual([p.report["legends"][0]["high"] for p in pictures], [4, 4, 4])


@needs("pandas")
class Pandas(ObjectTest):
    def setUp(self):
        super().setUp()
        import pandas

        self.positions = np.random.default_rng(3).uniform(0, 5, (30, 3))
        self.table = pandas.DataFrame(self.positions, columns=["x", "y", "z"])
        self.table["Speed [m/s]"] = np.arange(30)
        self.table["phase"] = pandas.Categorical(["melt", "solid", "gas"] * 10)

    def test_columns_keep_their_names(self):
        self.assert_ends(self.legend(self.table, "speed"), [0, 29])
        self.assertEqual(self.names(self.table, "phase"), ["gas", "melt", "solid"])
        self.assert_same(parray.render(self.table, 0.2, **SMALL), parray.render(self.positions, 0.2, **SMALL))
        self.assert_same(parray.render(self.table[["x", "y", "z"]], 0.2, **SMALL), parray.render(self.positions, 0.2, **SMALL))

    def test_radii_elements_and_colours_are_columns_too(self):
        table = self.table.assign(radius=0.3, red=255, green=128, blue=0)
        expected = parray.render(self.positions, 0.3, np.array([255, 128, 0], np.uint8), **SMALL)
        self.assert_same(parray.render(table, **SMALL), expected)
        self.assertEqual(self.names(self.table.assign(element="Au"), "element"), ["Au"])

    def test_missing_values_are_not_known_and_odd_columns_do_no_harm(self):
        import pandas

        table = self.table.assign(count=pandas.array([None, *range(29)], "Int64"), day=pandas.Timestamp("2026-01-01"))
        table["list"] = [[1, 2]] * 30
        legend = self.legend(table, "count")
        self.assertEqual((legend["high"], legend["entries"][0]["count"]), (28, 1))

    def test_a_series_gives_the_colour_and_the_title(self):
        legend = self.legend(self.positions, self.table["Speed [m/s]"])
        self.assertEqual((legend["title"], legend["high"]), ("speed", 29))
        self.assertEqual(len(self.names(self.positions, self.table["phase"])), 3)


class OtherFiles(ObjectTest):
    def setUp(self):
        super().setUp()
        self.positions = np.random.default_rng(4).uniform(1, 9, (40, 3))

    def assert_column(self, name, by, values, **options):
        self.assert_ends(self.legend(self.folder / name, by, **options), values)

    @needs("h5py")
    def test_snapshots_of_gadget_are_read(self):
        import h5py

        with h5py.File(self.folder / "snap.hdf5", "w") as file:
            file.create_group("Header").attrs["BoxSize"] = 10.0
            for kind, some in (("PartType0", self.positions[:25]), ("PartType4", self.positions[25:])):
                file[f"{kind}/Coordinates"] = some
                file[f"{kind}/Velocities"] = some
            file["PartType0/Density"] = self.positions[:25, 0]
        path = self.folder / "snap.hdf5"
        self.assert_column("snap.hdf5", "density", self.positions[:25, 0])
        self.assert_column("snap.hdf5", "velocities_y", self.positions[:, 1])
        self.assertEqual(self.names(path, "type"), ["gas", "stars"])
        self.assertEqual(parray.render(path, slice="x=0%:50%", **SMALL).report["spheres"] - 2, (self.positions[:, 0] <= 5).sum())
        (self.folder / "other.h5").write_bytes(path.read_bytes())
        with h5py.File(self.folder / "other.h5", "a") as file:
            del file["PartType0"], file["PartType4"]
        self.refused(parray.InputError, "neither PartType*/Coordinates", parray.render, self.folder / "other.h5")

    @needs("h5py")
    def test_frames_of_h5md_are_read(self):
        import h5py

        with h5py.File(self.folder / "a.h5", "w") as file:
            file["particles/all/position/value"] = np.stack([self.positions, 2 * self.positions])
            file["particles/all/box/edges"] = [20.0, 20, 20]
            file["particles/all/charge"] = self.positions[:, 2]
        self.assert_column("a.h5", "x", 2 * self.positions[:, 0], frame="last")
        self.assert_column("a.h5", "charge", self.positions[:, 2], frame=1)
        parray.render(self.folder / "a.h5", cell=True, **LARGE)
        self.assertEqual(len(parray.render(self.folder / "a.h5", frames=[0, 1], **SMALL)), 2)
        self.refused(parray.InputError, "no frame 2: it has 2", parray.render, self.folder / "a.h5", frame=2)

    @needs("astropy")
    def test_tables_of_astronomers_are_read(self):
        from astropy.table import Table

        x, y, z = self.positions.T
        Table({"x": x, "y": y, "z": z, "Mag": y}).write(self.folder / "a.fits")
        Table({"x": x, "y": y, "z": z, "Mag": y}).write(self.folder / "a.vot", format="votable")
        for name in ("a.fits", "a.vot"):
            self.assert_column(name, "mag", y)

    @needs("laspy")
    def test_point_clouds_of_scanners_are_read(self):
        import laspy

        cloud = laspy.create(point_format=3, file_version="1.2")
        cloud.x, cloud.y, cloud.z = self.positions.T
        cloud.red = cloud.green = cloud.blue = np.arange(40, dtype="u2") * 1000
        cloud.intensity = np.arange(40, dtype="u2")
        cloud.write(self.folder / "a.las")
        self.assert_column("a.las", "intensity", [0, 39])
        found = parray.sources.particles_of(self.folder / "a.las")
        self.assertEqual(found.colors[:, 0].tolist(), (np.arange(40) * 1000 // 257).tolist())

    @needs("pandas", "pyarrow")
    def test_parquet_and_feather_are_read(self):
        import pandas

        table = pandas.DataFrame(self.positions, columns=["x", "y", "z"]).assign(speed=np.arange(40))
        table.to_parquet(self.folder / "a.parquet")
        table.to_feather(self.folder / "a.feather")
        for name in ("a.parquet", "a.feather"):
            self.assert_column(name, "speed", [0, 39])

    @needs("gsd")
    def test_frames_of_hoomd_are_read(self):
        import gsd.hoomd

        frame = gsd.hoomd.Frame()
        frame.particles.N = 40
        frame.particles.position = self.positions.astype("f4") - 5
        frame.particles.types, frame.particles.typeid = ["A", "B"], [0, 1] * 20
        frame.particles.diameter = [0.6] * 40
        frame.configuration.box = [10, 10, 10, 0, 0, 0]
        with gsd.hoomd.open(self.folder / "a.gsd", "w") as file:
            file.append(frame)
        self.assertEqual(self.names(self.folder / "a.gsd", "type"), ["A", "B"])
        half = parray.render(self.folder / "a.gsd", slice="x=0%:50%", **SMALL)
        self.assertEqual(half.report["spheres"] - 2, (self.positions[:, 0] <= 5).sum())

    @needs("MDAnalysis")
    def test_coordinates_of_charmm_amber_and_namd_are_read(self):
        import MDAnalysis

        atoms = MDAnalysis.Universe(HELIX).atoms
        for name in ("a.crd", "a.coor"):
            atoms.write(self.folder / name)
        numbers = [f"{x:8.3f}" for x in atoms.positions.ravel()]
        lines = ["".join(numbers[i : i + 10]) for i in range(0, len(numbers), 10)]
        (self.folder / "a.mdcrd").write_text("\n".join(["title", *lines, *lines, ""]))
        for name, options in (("a.crd", {}), ("a.coor", {"topology": HELIX}), ("a.mdcrd", {"topology": HELIX, "frame": 1})):
            self.assert_ends(self.legend(self.folder / name, "resid", select="protein", **options), [1, 12])
        frames = parray.render(self.folder / "a.mdcrd", topology=HELIX, frames=[0, 1], color_by="chain", **SMALL)
        self.assertEqual(len(frames), 2)
        scene = {"version": 1, "camera": {"look_from": [9, 9, 99], "look_at": [0, 0, 0], "vfov": 20},
                 "particles": [{"file": self.folder / "a.mdcrd", "topology": HELIX, "frame": 1, "select": "resname CYS"}]}  # fmt: skip
        self.assertEqual(parray.render(scene, **SMALL).report["spheres"], 13)
        self.refused(parray.InputError, "names as topology", parray.render, self.folder / "a.coor")
        words = ["render", "a.mdcrd", "--topology", HELIX, "--frame=1", "--color-by", "resid", "-q", "-o", "a.png", "--spp", 1]
        self.assertEqual(self.run_module(*words).returncode, 0)

    @needs("ase")
    def test_crystals_of_ase_are_read(self):
        import ase.build
        import ase.io

        crystal = ase.build.bulk("Cu", a=3.6, cubic=True)
        ase.io.write(self.folder / "POSCAR", crystal)
        ase.io.write(self.folder / "a.traj", [crystal, crystal * (2, 1, 1)])
        for name, frame, count in (("POSCAR", None, 4), ("a.traj", 0, 4), ("a.traj", 1, 8), ("a.traj", "last", 8)):
            picture = parray.render(self.folder / name, frame=frame, crystal=False, **SMALL)
            self.assertEqual(picture.report["spheres"] - 2, count)
        whole = parray.render(self.folder / "POSCAR", **SMALL)  # with the copies on the cell's faces
        self.assertEqual(whole.report["spheres"] - 2, 14)
        parray.render(self.folder / "POSCAR", cell=True, **LARGE)
        self.refused(parray.InputError, "no frame 5", parray.render, self.folder / "a.traj", frame=5)


if __name__ == "__main__":
    if not any(importlib.util.find_spec(name) for name in ("ase", "MDAnalysis", "ovito", "pandas", "h5py")):
        print("skipped: needs packages from PyPI, which packages_test.py lists")
        sys.exit(SKIPPED)
    main()
