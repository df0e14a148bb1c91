"""With the real ASE, MDAnalysis, OVITO, pip, mypy and Jupyter, none of which Debian's Python has.

    python3 -m venv DIR
    DIR/bin/pip install ase MDAnalysis ovito mypy nbclient ipykernel flit_core pandas h5py astropy laspy lazrs pyarrow gsd pillow
    PARRAY_PACKAGES_PYTHON=DIR/bin/python ctest --preset release -R python.packages
"""

import os
import sys

OTHER = os.environ.pop("PARRAY_PACKAGES_PYTHON", "")
if OTHER:
    os.execv(OTHER, [OTHER, *sys.argv])

import importlib.util
import subprocess
import unittest.mock
import warnings

from support import BIN, PYTHON, SKIPPED, SMALL, SOURCE, Test, needs, np, parray

HELIX = SOURCE / "scenes/particles/helix.pdb"


def same(test, first, second):
    """Pictures of one scene."""
    test.assertEqual(first.report["scene_sha256"], second.report["scene_sha256"])
    test.assertEqual(first.report["image_sha256"], second.report["image_sha256"])


@needs("ase")
class Ase(Test):
    def test_atoms_are_what_their_file_is(self):
        import ase.io
        atoms = ase.io.read(SOURCE / "scenes/particles/caffeine.xyz")
        same(self, parray.render(atoms, **SMALL), parray.render(SOURCE / "scenes/particles/caffeine.xyz", **SMALL))

    def test_radii_and_colors_replace_the_elements(self):
        import ase.build
        slab = ase.build.fcc111("Cu", (4, 4, 2), vacuum=5)
        positions = slab.get_positions()
        colors = np.full((len(slab), 3), 0.5)
        same(self, parray.render(slab, 1.2, colors, crystal=False, **SMALL), parray.render(positions, 1.2, colors, **SMALL))
        self.assertEqual(parray.render(slab, crystal=False, **SMALL).report["spheres"], len(slab) + 2)


@needs("MDAnalysis")
class MdAnalysis(Test):
    def setUp(self):
        super().setUp()
        warnings.simplefilter("ignore", DeprecationWarning)
        import MDAnalysis
        self.universe = MDAnalysis.Universe(HELIX)

    def test_a_universe_has_the_atoms_and_elements_of_its_file(self):
        found = parray.render(self.universe, **SMALL)
        same(self, found, parray.render(self.universe.atoms.positions, elements=self.universe.atoms.elements, **SMALL))
        of_file = parray.render(HELIX, **SMALL)  # whose positions MDAnalysis keeps as float32
        self.assertEqual(found.report["spheres"], of_file.report["spheres"])
        self.assertLess(np.abs(np.mean(found) - np.mean(of_file)), 0.01)

    def test_a_group_is_its_atoms_only(self):
        group = self.universe.select_atoms("name CA")
        self.assertEqual(parray.render(group, **SMALL).report["spheres"], len(group) + 2)

    def test_frames_are_those_of_the_trajectory(self):
        from MDAnalysis.coordinates.memory import MemoryReader
        first = self.universe.atoms.positions.copy()
        self.universe.load_new(np.stack([first, first * 2, first[::-1]]), format=MemoryReader)
        elements = self.universe.atoms.elements
        for frame, positions in enumerate((first, first * 2, first[::-1])):
            same(self, parray.render(self.universe, frame=frame, **SMALL),
                 parray.render(positions, elements=elements, **SMALL))
            self.assertEqual(self.universe.trajectory.frame, frame)

    def test_without_elements_the_types_that_it_guesses_count(self):
        import MDAnalysis
        universe = MDAnalysis.Universe.empty(3, trajectory=True)
        universe.atoms.positions = [[0, 0, 0], [2, 0, 0], [0, 2, 0]]
        same(self, parray.render(universe, **SMALL), parray.render(universe.atoms.positions, **SMALL))
        universe.add_TopologyAttr("types", ["C", "O", "N"])
        same(self, parray.render(universe, **SMALL),
             parray.render(universe.atoms.positions, elements=["C", "O", "N"], **SMALL))


@needs("ovito")
class Ovito(Test):
    def setUp(self):
        super().setUp()
        from ovito.data import DataCollection, ParticleType
        from ovito.pipeline import Pipeline, StaticSource
        self.data = DataCollection()
        particles = self.data.create_particles(count=20)
        self.positions = np.random.default_rng(2).uniform(0, 10, (20, 3))
        particles.create_property("Position", data=self.positions)
        self.kinds = np.array([1] * 8 + [2] * 12)
        types = particles.create_property("Particle Type", data=self.kinds)
        types.types.append(ParticleType(id=1, name="Cu", color=(1, 0.5, 0.25), radius=0.8))
        types.types.append(ParticleType(id=2, name="Zr", color=(0.25, 0.5, 1)))  # of no radius
        self.pipeline = Pipeline(source=StaticSource(data=self.data))

    def test_colours_and_radii_are_those_that_it_shows(self):
        first = self.kinds == 1
        encoded = np.where(first[:, None], (1, 0.5, 0.25), (0.25, 0.5, 1))
        radii = np.where(first, 0.8, self.data.particles.vis.radius)
        names = np.where(first, "Cu", "Zr")
        expected = parray.render(self.positions, radii, parray.srgb_to_linear(encoded), elements=names, **SMALL)
        same(self, parray.render(self.pipeline, **SMALL), expected)
        same(self, parray.render(self.pipeline.compute(), **SMALL), expected)

    def test_modifiers_of_a_pipeline_count(self):
        from ovito.modifiers import ColorCodingModifier, DeleteSelectedModifier, ExpressionSelectionModifier
        self.pipeline.modifiers.append(ColorCodingModifier(property="Position.X"))
        self.pipeline.modifiers.append(ExpressionSelectionModifier(expression="ParticleType == 1"))
        self.pipeline.modifiers.append(DeleteSelectedModifier())
        shown = self.pipeline.compute().particles
        expected = parray.render(np.asarray(shown.positions), shown.vis.radius,
                                 parray.srgb_to_linear(np.asarray(shown.colors)), elements=["Zr"] * 12, **SMALL)
        same(self, parray.render(self.pipeline, **SMALL), expected)
        self.assertEqual(expected.report["spheres"], 12 + 2)

    def test_data_without_particles_is_refused(self):
        from ovito.data import DataCollection
        self.refused(parray.InputError, "have no particles", parray.render, DataCollection())


@needs("mypy")
class Types(Test):
    def mypy(self, *arguments):
        return subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", self.folder / "cache", *arguments],
                              cwd=PYTHON, capture_output=True, text=True, check=False)

    def test_the_package_is_clean_in_strict_mode(self):
        done = self.mypy("--config-file", PYTHON / "pyproject.toml")
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_a_users_mistakes_are_found(self):
        user = self.folder / "user.py"
        user.write_text("import numpy as np\nimport parray\n"
                        "picture = parray.render(np.zeros((1, 3)), 1.0, width=3, camera={'vfov': 30})\n"
                        "reveal_type(picture.error)\n"
                        "parray.render('a.xyz', widht=3)\n"
                        "parray.Farm('http://x').submit('a.xyz', sampler='sobl')\n")
        with unittest.mock.patch.dict(os.environ, MYPYPATH=str(PYTHON / "src")):
            done = self.mypy("--strict", user)
        errors = [line for line in done.stdout.splitlines() if ": error: " in line]
        self.assertEqual(len(errors), 2, done.stdout)
        self.assertIn("user.py:5", errors[0])
        self.assertIn("user.py:6", errors[1])
        self.assertIn("parray.picture.Error", done.stdout)


@needs("pip", "flit_core")
class Installed(Test):
    def test_pip_installs_it_with_its_types_and_leaves_nothing_beside_the_sources(self):
        import shutil
        unwanted = shutil.ignore_patterns("*.egg-info", "build", "__pycache__")
        copy = shutil.copytree(PYTHON, self.folder / "python", ignore=unwanted)
        before = sorted(copy.rglob("*"))
        target = self.folder / "target"
        subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation",
                        "--target", target, copy], check=True, capture_output=True)
        self.assertEqual(sorted(copy.rglob("*")), before)
        self.assertTrue((target / "parray/py.typed").exists())
        done = subprocess.run([sys.executable, "-c", "import parray; print(parray.__file__, parray.__version__)"],
                              env={**os.environ, "PYTHONPATH": str(target)}, capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout, f"{target}/parray/__init__.py 0.2.0\n")


@needs("nbclient", "ipykernel", "ase")
class Notebook(Test):
    def test_the_notebook_runs_and_shows_bar_and_picture(self):
        import nbclient
        import nbformat
        notebook = nbformat.read(PYTHON / "examples/notebook.ipynb", as_version=4)
        with unittest.mock.patch.dict(os.environ, PARRAY_BIN=str(BIN), PYTHONPATH=str(PYTHON / "src")):
            nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3",
                                    resources={"metadata": {"path": str(self.folder)}}).execute()
        html = [output["data"]["text/html"] for cell in notebook.cells if cell.cell_type == "code"
                for output in cell.outputs if "text/html" in output.get("data", {})]
        self.assertTrue(any("<progress value=\"1" in text and "done" in text for text in html), html)
        self.assertTrue(any("<figure><img src=\"data:image/png;base64," in text for text in html))


class Examples(Test):
    def test_the_examples_run(self):
        """Each without the packages that are not there."""
        for script in sorted((PYTHON / "examples").glob("*.py")):
            imports = [line.split()[1].split(".")[0] for line in script.read_text().splitlines()
                       if line.startswith(("import ", "from "))]
            missing = [name for name in imports if importlib.util.find_spec(name) is None]
            with self.subTest(script.name):
                if missing or "Farm(" in script.read_text():
                    continue
                environment = {**os.environ, "PARRAY_BIN": str(BIN), "PYTHONPATH": str(PYTHON / "src")}
                done = subprocess.run([sys.executable, script], cwd=self.folder, env=environment, capture_output=True,
                                      text=True, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("<Picture", done.stdout)


if __name__ == "__main__":
    if not any(importlib.util.find_spec(name) for name in ("ase", "MDAnalysis", "ovito", "mypy")):
        print("skipped: needs packages from PyPI:" + (__doc__ or ""))
        sys.exit(SKIPPED)
    unittest.main(verbosity=1)
