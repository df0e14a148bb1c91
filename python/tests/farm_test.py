"""parray.Farm against a real coordinator and worker. Skipped, with a word, where the coordinator serves no HTTP."""

import asyncio
import contextlib
import os
import struct
import subprocess
import sys

from support import BIN, SCENE, SKIPPED, SMALL, SOURCE, Test, cloud, main, np, parray

os.environ.setdefault("PARRAY_BIN_DIR", str(BIN))
os.environ.setdefault("PARRAY_SOURCE_DIR", str(SOURCE))
sys.path.insert(0, str(SOURCE / "tests/integration"))
import farm as integration
import web

HELIX = SOURCE / "scenes/particles/helix.pdb"
LONG = {"width": 400, "height": 300, "spp": 100000}


def serves_http():
    if not (BIN / "parray-coordinator").exists():
        return False
    said = subprocess.run([BIN / "parray-coordinator", "--help"], capture_output=True, text=True, check=False)
    return "--http " in said.stdout


class FarmTest(Test):
    def setUp(self):
        super().setUp()
        self.start()

    def start(self, *options, token=None):
        self.processes = web.Web(*options, log_level="info")
        self.addCleanup(self.processes.close)
        self.processes.start_coordinator()
        self.farm = parray.Farm(f"http://{self.processes.web}", token)

    def start_worker(self):
        self.processes.start_worker("w", 2)


class Renders(FarmTest):
    def test_a_farm_makes_the_bits_of_this_machine(self):
        """Of arrays, elements, files, scenes and scenes that name arrays."""
        self.start_worker()
        positions, radii, colors = cloud()
        named = {**SCENE, "particles": [{"file": np.array([[0, 0, 2.0]]), "radius": 0.2, "material": "a"},
                                        {"file": HELIX, "radius": 0.1}]}
        residues = parray.Particles(positions, elements=["C"] * len(positions), numbers={"resid": range(len(positions))},
                                    texts={"chain": ["A", "B"] * (len(positions) // 2)})  # fmt: skip
        cases = (((positions, radii, colors), {}), ((residues,), {"color_by": "chain"}),
                 ((positions,), {"elements": ["C"] * len(positions)}), ((HELIX,), {}),
                 ((SCENE,), {}), ((named,), {}), ((SOURCE / "scenes/glass.json",), {}),
                 ((positions, radii), {"material": {"type": "dielectric", "ior": 1.5}, "camera": {"vfov": 40}}),
                 ((SCENE,), {"adaptive": True, "seed": 3, "sampler": "independent"}))
        for arguments, options in cases:
            with self.subTest(arguments=arguments, options=options):
                here = parray.render(*arguments, **SMALL, **options)
                there = self.farm.render(*arguments, **SMALL, **options)
                self.assertEqual(there.report["image_sha256"], here.report["image_sha256"])
                self.assertEqual(there.pixels.tobytes(), here.pixels.tobytes())
                self.assertEqual(there.error, here.error)

    def test_bad_input_has_the_text_of_the_command_line(self):
        for arguments, options, text in (((SCENE,), {"width": 0}, "options: /width: "), ((SCENE,), {"target_error": -1.0}, "options: /target_error: "),
                                         (([HELIX, HELIX],), {}, "call submit() for each"),
                                         (({**SCENE, "camera": {}},), {}, "missing key"),
                                         (({**SCENE, "cammera": {}},), {}, "camera")):
            self.refused(parray.InputError, text, self.farm.submit, *arguments, **options)


class Jobs(FarmTest):
    def test_a_job_is_steered_and_its_picture_seen_on_the_way(self):
        self.assertEqual(self.farm.workers(), [])
        job = self.farm.submit(SCENE, **LONG, name="long", priority=60, progressive=True)
        self.assertEqual((job.show()["name"], job.show()["priority"]), ("long", 60))
        self.assertIn("worker", integration.wait_for(lambda: job.progress.waits_for, "a word for what it waits for"))
        self.start_worker()
        integration.wait_for(lambda: job.progress.done > 0, "progress")
        integration.wait_for(lambda: job.show()["whole"], "a picture")
        self.assertEqual([worker["name"] for worker in self.farm.workers()], ["w"])
        so_far = job.picture()
        self.assertEqual(so_far.shape, (300, 400, 3))
        self.assertGreater(so_far.pixels.max(), 0)
        self.assertEqual(job.png()[:4], b"\x89PNG")
        self.assertEqual(struct.unpack_from(">2I", job.thumbnail(), 16), (64, 48))
        self.assertIn("%", job._repr_html_())
        job.set_priority(10)
        self.assertEqual(job.show()["priority"], 10)
        job.pause()
        self.assertEqual(job.state, "paused")
        job.resume()
        with self.assertRaises(TimeoutError):
            job.wait(timeout=0.2)
        job.cancel()
        self.refused(parray.RenderError, f"job {job.id} was cancelled", job.wait)
        job.requeue()
        self.assertIn(job.state, ("queued", "running"))
        self.assertEqual([j.id for j in self.farm.jobs(["queued", "running"])], [job.id])
        job.cancel()
        job.forget()
        self.assertRaises(parray.ParRayError, job.show)
        self.assertEqual(self.farm.jobs(), [])

    def test_tasks_wait_side_by_side_and_cancel_what_they_render(self):
        self.start_worker()

        async def work():
            first, second = (self.farm.submit(SCENE, seed=seed, **SMALL) for seed in (1, 2))
            pictures = await asyncio.gather(first, second.wait_async(timeout=60))
            self.assertNotEqual(*(p.report["image_sha256"] for p in pictures))
            seen = asyncio.Event()
            loop = asyncio.get_running_loop()
            tell = lambda _: loop.call_soon_threadsafe(seen.set)
            task = asyncio.create_task(self.farm.render_async(SCENE, **LONG, progress=tell))
            await asyncio.wait_for(seen.wait(), 60)
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task
            self.assertTrue(task.cancelled())

        asyncio.run(work())
        self.assertEqual([job.state for job in self.farm.jobs()], ["cancelled", "done", "done"])


class Tokens(FarmTest):
    def setUp(self):
        Test.setUp(self)
        keys = self.folder / "keys"
        for arguments in ((keys,), (keys, "--name", "ann")):
            self.assertEqual(integration.run("keygen", *arguments).returncode, 0)
        made = integration.run("keygen", keys, "--token", "ann")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.start("--keys", keys, token=made.stdout.strip())

    def test_a_farm_with_keys_wants_a_token_and_knows_whose_it_is(self):
        job = self.farm.submit(SCENE, **SMALL)
        self.assertEqual(job.show()["user"], "ann")
        for token in (None, "guessed"):
            self.refused(parray.RenderError, "token", parray.Farm, self.farm.url, token)
            self.refused(parray.RenderError, "token", parray.Farm(self.farm.url, token, check=False).submit, SCENE)


class Options(FarmTest):
    def test_files_and_objects_with_options_need_no_program_here_and_have_its_bits(self):
        self.start_worker()
        positions, _, _ = cloud()
        residues = parray.Particles(positions, elements=["C"] * len(positions), numbers={"resid": range(len(positions))},
                                    texts={"chain": ["A", "B"] * (len(positions) // 2)})  # fmt: skip
        cases = ((HELIX, {"select": "resid 1:5", "color_by": "element", "view": "front", "zoom": 1.1}),
                 (residues, {"select": "chain A", "color_by": "chain", "show": [{"select": "resid 1:3", "radius": 2}]}))
        for source, options in cases:
            here = parray.render(source, **SMALL, **options)
            with self.without_program():
                there = self.farm.render(source, **SMALL, **options)
            self.assertEqual(there.report["image_sha256"], here.report["image_sha256"])

    def test_a_trajectory_becomes_a_series_and_a_plan_stores_nothing(self):
        run = self.folder / "run.xyz"
        run.write_text("".join(f"2\nf\nO 0 0 0\nO {1 + i / 4} 0 0\n" for i in range(6)))
        plan = self.farm.plan(run, **SMALL, frames="all")
        self.assertGreater(plan["thread_seconds"], 0)
        self.assertEqual(list(self.farm.jobs()), [])
        for frames, numbers in (("all", range(6)), (range(1, 6, 2), [1, 3, 5]), ("0:5:5", [0, 5]), (4, [4])):
            series = self.farm.submit(run, **SMALL, frames=frames).show()
            self.assertEqual([entry["frame"] for entry in series["frame_list"]], list(numbers))
        self.refused(parray.InputError, "equal distances", self.farm.submit, run, frames=[0, 1, 5])
        self.refused(parray.InputError, "only a file", self.farm.submit, *cloud(), frames="all")
        self.refused(parray.InputError, "use submit()", self.farm.render, run, frames="all")

    @contextlib.contextmanager
    def without_program(self):
        kept = {name: os.environ.pop(name, None) for name in ("PARRAY_BIN", "PATH")}
        try:
            yield
        finally:
            os.environ.update({name: value for name, value in kept.items() if value is not None})


class Document(FarmTest):
    def test_keywords_are_the_options_of_the_servers_document(self):
        served = self.farm._http.json("GET", "/api/v1/openapi.json")
        options = served["components"]["schemas"]["Options"]["properties"]
        ours = set(parray.options.names_of(parray.options.SubmitOptions))
        local = {"values", "elements", "camera", "sky"}  # the package itself makes a scene of these
        self.assertEqual(ours - local, set(options) - {"radius"})  # whose name here is radii


if __name__ == "__main__":
    if not serves_http():
        print("skipped: no parray-coordinator that serves HTTP")
        sys.exit(SKIPPED)
    main()
