"""`import ricochet`: runs, results, errors, the notebook; with real processes."""
import importlib.util, json, math, os, pathlib, re, subprocess, sys, tempfile, tomllib, unittest

source = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(source / "coupler/python"))
import ricochet
from ricochet import command, result, scene

bars = source / "configs/two_bars.toml"


class Scratch(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)


class Toml(unittest.TestCase):
    def test_is_read_back_as_it_was(self):
        given = {"model": "bar", "body": [{"name": "a\"\\\n\x7fé", "mesh": {"elements": [1, 2], "start_m": -0.5}},
                                         {"name": "b", "traction": [{"surface": "end"}]}],
                 "time": {"step_s": 1e-8, "end_s": 1.0}, "partition": {"implicit_length_m": {"a b": 1e300}},
                 "flag": True, "empty": [], "nothing": {}}
        self.assertEqual(tomllib.loads(scene.to_toml(given)), given)

    def test_every_shipped_scene_is_read_back_as_it_was(self):
        paths = list((source / "configs").glob("*.toml"))
        self.assertGreater(len(paths), 5)
        for path in paths:
            given = tomllib.loads(path.read_text())
            self.assertEqual(tomllib.loads(scene.to_toml(given)), given, path)

    def test_refuses_what_is_no_value(self):
        for value, error in [(None, TypeError), ({1: 2}, TypeError), (math.inf, ValueError), (math.nan, ValueError)]:
            with self.assertRaises(error):
                scene.to_toml({"key": value})

    def test_changes_become_arguments(self):
        self.assertEqual(scene.set_arguments({"time__step_s": 1e-8, "coupling": {"protocol": "kim"},
                                              "body.a.mesh.elements": [2, 3]}),
                         ["--set", "time.step_s=1e-08", "--set", 'coupling.protocol="kim"', "--set",
                          "body.a.mesh.elements=[2, 3]"])


class Run(Scratch):
    def test_of_a_file_with_changes(self):
        lines = []
        run = ricochet.run(bars, self.folder / "out", progress=lines.append, time__end_s=100e-6)
        self.assertEqual(run.summary["status"], "done")
        self.assertAlmostEqual(run.history["time_s"][-1], 100e-6, delta=2e-6)
        self.assertIn("done: ", run.text)

    def test_of_a_dict_is_that_of_its_file(self):
        given = tomllib.loads(bars.read_text())
        of_dict = ricochet.run(given, self.folder / "dict", progress=None)
        of_file = ricochet.run(bars, self.folder / "file", progress=None)
        self.assertEqual(list(of_dict.history["contact_force_n"]), list(of_file.history["contact_force_n"]))
        self.assertTrue((self.folder / "dict/dict.toml").is_file())
        ricochet.run(given, self.folder / "dict", progress=None)  # a file of this package is replaced

    def test_of_a_dict_leaves_files_of_others(self):
        (self.folder / "dict").mkdir()
        (self.folder / "dict/dict.toml").write_text("mine")
        with self.assertRaisesRegex(FileExistsError, "dict.toml is not of this package"):
            ricochet.run({"model": "bar"}, self.folder / "dict")

    def test_paths_of_a_dict_count_from_the_working_folder(self):
        given = scene.with_absolute_paths({"body": [{"mesh": {"gmsh": "a.msh"}, "interface_nodes": "b"}],
                                           "participant": [{"executable": "c"}, {"executable": "./c"}]})
        here = os.getcwd()
        self.assertEqual(given, {"body": [{"mesh": {"gmsh": f"{here}/a.msh"}, "interface_nodes": f"{here}/b"}],
                                 "participant": [{"executable": "c"}, {"executable": f"{here}/c"}]})

    def test_momentum_is_exchanged(self):
        """Equal bars fly back at each other's speed, within the energy that the coarse mesh loses."""
        history = ricochet.run(bars, self.folder / "out", progress=None).history
        left, right = (history[f"velocity_mean_{body}_m_s"][-1] for body in ("left", "right"))
        self.assertAlmostEqual(left, -5.13588, delta=0.3)
        self.assertAlmostEqual(left + right, 0.0, places=9)

    def test_errors_have_code_and_text(self):
        with self.assertRaises(ricochet.SceneError) as caught:
            ricochet.run(self.folder / "none.toml", progress=None)
        self.assertEqual(caught.exception.exit_code, 2)
        self.assertEqual(caught.exception.text, f"{self.folder}/none.toml: no such scene file")
        with self.assertRaisesRegex(ricochet.SceneError, "did you mean \"step_s\""):
            ricochet.check(bars, time__stp_s=1.0)
        for code, kind in [(3, "Unstable"), (4, "Participant"), (5, "Protocol"), (6, "Model"), (7, "Machine"), (130, "Ricochet")]:
            self.of_program(f"echo 'note' >&2; echo 'ricochet: it broke' >&2; exit {code}")
            with self.assertRaises(getattr(ricochet, kind + "Error")) as caught:
                ricochet.check(bars)
            self.assertEqual((caught.exception.exit_code, caught.exception.text), (code, "it broke"))

    def of_program(self, text):
        path = self.folder / "program"
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)
        before = os.environ["RICOCHET"]
        self.addCleanup(os.environ.__setitem__, "RICOCHET", before)
        os.environ["RICOCHET"] = str(path)

    def test_an_error_of_progress_ends_the_command(self):
        self.of_program("trap 'echo ended > \"$0.ended\"; exit 130' INT; echo step 1/2 >&2; while :; do sleep 0.05; done")

        def progress(line):
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            ricochet.run(bars, self.folder / "out", progress=progress)
        self.assertTrue((self.folder / "program.ended").is_file())

    def test_the_program_is_found(self):
        before = os.environ.pop("RICOCHET")
        self.addCleanup(os.environ.__setitem__, "RICOCHET", before)
        self.assertEqual(command.program(), str(source / "ricochet"))
        installed = self.folder / "lib/python/site/ricochet/command.py"
        self.addCleanup(setattr, command, "__file__", command.__file__)
        command.__file__ = str(installed)
        path = os.environ["PATH"]
        self.addCleanup(os.environ.__setitem__, "PATH", path)
        os.environ["PATH"] = str(pathlib.Path(before).parent)
        self.assertEqual(command.program(), before)
        os.environ["PATH"] = str(self.folder)
        with self.assertRaisesRegex(FileNotFoundError, "found no command ricochet"):
            command.program()

    def test_a_program_that_does_not_start_is_named(self):
        self.of_program("")
        (self.folder / "program").chmod(0o644)
        with self.assertRaisesRegex(ricochet.RicochetError, "cannot start"):
            ricochet.check(bars)

    def test_check_of_a_dict_says_what_check_of_its_file_says(self):
        self.assertIn("left", ricochet.check(bars))
        self.assertIn("left", ricochet.check(tomllib.loads(bars.read_text())))

    def test_a_scene_is_drawn_before_it_runs(self):
        for number, scene in enumerate([bars, tomllib.loads(bars.read_text())]):
            page = ricochet.draw(scene, self.folder / f"drawn_{number}", height=400, coupling__protocol="kim")
            self.assertRegex(page._repr_html_(), r'(?s)^<iframe srcdoc="[^"]*before it runs[^"]*" width="100%" height="400"')
            self.assertIn("scene.html", repr(page))


class Results(Scratch):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.run_ = ricochet.run(bars, pathlib.Path(cls.scratch.name) / "out", progress=None)

    def test_are_columns_by_name(self):
        run = ricochet.Result(self.run_.folder)
        force, pairs = run.history["contact_force_n"], run.contact["contact_force_n"]
        self.assertEqual(len(force), len(run.history["time_s"]))
        self.assertEqual(list(force), list(pairs))
        self.assertNotIn("energy_kinetic_j", list(run.contact))
        self.assertEqual(len(run.contact), sum(1 for _ in run.contact))
        with self.assertRaisesRegex(KeyError, "has no column 'force'"):
            run.history["force"]
        with self.assertRaisesRegex(KeyError, "no column of these"):
            run.contact["energy_kinetic_j"]
        self.assertIn("contact_force_n", repr(run.history))
        self.assertIn("Result(", repr(run))

    def test_are_lists_without_numpy(self):
        numpy, result.numpy = result.numpy, None
        self.addCleanup(setattr, result, "numpy", numpy)
        self.assertIsInstance(ricochet.Result(self.run_.folder).history["time_s"], list)

    def test_cells_that_are_empty_or_no_numbers(self):
        (self.folder / "a.csv").write_text("a,b\n1,x\n,y\n")
        table = result.Table(self.folder / "a.csv")
        self.assertTrue(math.isnan(table["a"][1]))
        self.assertEqual(table["b"], ["x", "y"])

    def test_are_frames_where_pandas_is(self):
        if not importlib.util.find_spec("pandas"):
            with self.assertRaises(ImportError):
                self.run_.history.frame()
            return
        self.assertEqual(list(self.run_.history.frame().columns), list(self.run_.history))
        self.assertEqual(list(self.run_.contact.frame().columns), list(self.run_.contact))

    def test_a_file_that_is_not_there_names_the_key_that_makes_it(self):
        with self.assertRaisesRegex(FileNotFoundError, r"\[\[output.probe\]\]"):
            ricochet.Result(self.run_.folder).probes
        with self.assertRaisesRegex(FileNotFoundError, "output.axial_stress_every"):
            ricochet.Result(self.run_.folder).axial_stress
        with self.assertRaisesRegex(FileNotFoundError, "has no summary.json"):
            ricochet.Result(self.folder)

    def test_the_report_is_shown(self):
        page = self.run_.show(height=300)
        self.assertRegex(page._repr_html_(), r'(?s)^<iframe srcdoc="[^"]*" width="100%" height="300"')
        self.assertIn("report.html", repr(page))


class Study(Scratch):
    def test_of_a_dict(self):
        study = ricochet.study({"scene": bars, "methods": ["all_explicit"], "quantities": ["peak_force"],
                                "vary": [{"time.step_s": [2e-6, 1e-6]}], "reference": {"exact": "impedance_theory"}},
                               self.folder / "study", progress=None)
        self.assertEqual(list(study.results["method"]), ["all_explicit"] * 2)
        self.assertEqual(study.description["methods"], ["all_explicit"])
        self.assertEqual(study.result(0).summary["protocol"], "all_explicit")
        self.assertIn("results in ", study.text)


class Notebook(Scratch):
    def test_its_cells_run_in_order(self):
        notebook = json.loads((source / "docs/impact.ipynb").read_text())
        self.assertEqual((notebook["nbformat"], [c for c in notebook["cells"] if c.get("outputs")]), (4, []))
        cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
        (self.folder / "docs").mkdir()
        (self.folder / "configs").symlink_to(source / "configs")
        done = subprocess.run([sys.executable, "-c", "\n".join(cells)], cwd=self.folder / "docs", capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(source / "coupler/python")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("separation after 30.89 us", done.stdout)


class Pages(unittest.TestCase):
    def test_the_page_names_what_the_package_has(self):
        page = (source / "docs/python.md").read_text()
        for name in ricochet.__all__:
            self.assertIn(name, page)

    def test_the_version_is_that_of_the_project(self):
        version = re.search(r"project\(ricochet.*?VERSION ([0-9.]+)", (source / "CMakeLists.txt").read_text(), re.S)[1]
        for package in ["coupler/python", "common/participant/python"]:
            self.assertEqual(tomllib.loads((source / package / "pyproject.toml").read_text())["project"]["version"], version)


if __name__ == "__main__":
    unittest.main()
