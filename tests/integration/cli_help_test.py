"""What the commands print: help, facts about scenes, progress."""

import contextlib
import hashlib
import json
import os
import pty
import re
import subprocess
import unittest

from cli_usage_test import CliTest
from farm import BIN, SCENES, run

RENDER_OPTIONS = ["--width", "--height", "--spp", "--max-depth", "--seed", "--precision",
                  "--accelerator", "--isa", "--schedule", "--row-order", "--sampler", "--adaptive",
                  "--target-error", "--target-half-width", "--time-limit", "--passes",
                  "--transparent"]
LABEL_OPTIONS = ["--legend", "--legend-title", "--scale-bar", "--unit", "--time-stamp", "--cell", "--text", "--font-size",
                 "--width-mm", "--dpi", "--labels"]
FINISHING_OPTIONS = ["--outline", "--depth-cue"]
PARTICLE_OPTIONS = ["--frame", "--topology", "--alternatives", "--crystal", "--replicate", "--wrap", "--whole", "--center",
                    "--material", "--radius", "--select", "--slice", "--hide",
                    "--color-by", "--colormap", "--range", "--color-scale", "--radius-by", "--show",
                    "--stick-radius", "--bonds", "--arrows", "--arrow-scale", "--solid-cell",
                    "--view", "--style", "--projection",
                    "--up", "--azimuth", "--elevation", "--zoom"]
COORDINATOR = ["--coordinator", "PARRAY_COORDINATOR", "--keys", "PARRAY_KEYS"]
OPTIONS = {
    "render": RENDER_OPTIONS + PARTICLE_OPTIONS + FINISHING_OPTIONS + LABEL_OPTIONS + [
                                "--background", "--quality", "--views", "--like", "--output", "--aov", "--denoise", "--error-map", "--report", "--threads", "--quiet", "--progress",
                                "--preview", "--display", "--on-end"],
    "submit": RENDER_OPTIONS + PARTICLE_OPTIONS + FINISHING_OPTIONS + LABEL_OPTIONS + COORDINATOR + ["--background", "--quality", "--like", "--wait", "--output", "--aov", "--denoise", "--error-map", "--report",
                                              "--name", "--priority", "--max-failures", "--quiet", "--progress",
                                              "--frames", "--camera-path",
                                              "--preview", "--display", "--on-end"],
    "film": RENDER_OPTIONS + PARTICLE_OPTIONS + FINISHING_OPTIONS + LABEL_OPTIONS + COORDINATOR + [
        "--background", "--quality", "--output", "--fps", "--report", "--denoise", "--frames", "--turntable",
        "--camera-path", "--count", "--moving-noise", "--threads", "--farm", "--priority", "--quiet"],
    "jobs": COORDINATOR + ["--user", "--name", "--sort", "--order", "--limit", "--json"],
    "show": COORDINATOR + ["--json"],
    "watch": COORDINATOR + ["--quiet", "--progress", "--preview", "--display", "--on-end"],
    "cancel": COORDINATOR + ["--json"],
    "requeue": COORDINATOR + ["--json"],
    "forget": COORDINATOR + ["--json"],
    "priority": COORDINATOR + ["--json"],
    "audit": COORDINATOR + ["--json"],
    "replay": COORDINATOR + ["--json"],
    "fetch": COORDINATOR + ["--output", "--report", "--aov", "--error-map", "--partial", "--raw"],
    "workers": COORDINATOR + ["--host", "--json"],
    "validate": RENDER_OPTIONS + PARTICLE_OPTIONS + ["--background", "--json"],
    "convert": PARTICLE_OPTIONS + LABEL_OPTIONS + ["--width", "--height", "--transparent", "--expand"],
    "compare": ["--output", "--json"],
    "verify": ["--pixels", "--all", "--seed", "--threads", "--json"],
    "doctor": ["--json", "--extremes"],
}


class Talk(CliTest):
    def test_every_command_lists_every_option(self):
        for command, options in OPTIONS.items():
            text = run("help", command, "--all").stdout
            for option in options:
                self.assertIn(option, text, command)
            known = {*options, "--help", "--wait"}
            self.assertLessEqual(set(re.findall(r"--[a-z][a-z-]+", text)), known, command)

    def test_commands_list_the_channels_that_they_can_write(self):
        for command, lacks in (("render", set()), ("submit", set()), ("fetch", {"depth", "normal", "albedo", "sphere", "cost"})):
            described = re.search(r"(?ms)^  --aov .*?^  --error-map", run("help", command, "--all").stdout)[0]
            named = {"depth", "normal", "albedo", "sphere", "cost", "samples", "half-width"}
            self.assertEqual({name for name in named if f"{name}:" in described or f"{name}," in described}, named - lacks)

    def test_parray_alone_prints_the_help(self):
        result = run()
        self.assertEqual(result.returncode, 0)
        self.assertEqual(result.stdout, run("--help").stdout)
        for command in OPTIONS:
            self.assertRegex(result.stdout, rf"\n  {command} +\w")
        self.assertRegex(run("--version").stdout, r"\Aparray \d+\.\d+\.\d+\n\Z")

    def test_validate_says_what_the_scene_requires(self):
        result = run("validate", self.scene, "--json")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        facts = json.loads(result.stdout)
        self.assertEqual((facts["spheres"], facts["diffuse"], facts["metal"], facts["dielectric"]),
                         (6, 2, 2, 2))
        self.assertEqual((facts["smallest_radius"], facts["largest_radius"], facts["extent"]),
                         (0.2, 100, 100))
        self.assertEqual(facts["features"],
                         ["diffuse", "metal", "fuzz", "dielectric", "lens", "many-radii"])
        self.assertIn(facts["precision"], ("f32", "f64"))
        self.assertIn(facts["accelerator"], ("linear", "bvh"))
        self.assertGreater(facts["accelerator_bytes"], 0)
        text = run("validate", self.scene).stdout
        for part in (facts["precision_reason"], facts["accelerator_reason"], facts["scene_sha256"]):
            self.assertIn(part, text)

    def test_every_scene_that_ships_is_valid(self):
        for scene in sorted(SCENES.glob("*.json")):
            result = run("validate", scene)
            self.assertEqual((result.returncode, result.stderr), (0, ""))

    def read_terminal(self, main):
        """What was written to it; one read() may return a part only."""
        text = b""
        with contextlib.suppress(OSError):  # the system's word for the end
            while part := os.read(main, 100000):
                text += part
        return text.decode()

    def test_a_terminal_gets_a_bar_and_a_log_gets_lines(self):
        arguments = [BIN / "parray", "render", self.scene, "-o", self.path("a.png")]
        for term, bar in (("xterm", True), ("dumb", False)):
            main, terminal = pty.openpty()
            result = subprocess.run(arguments, stderr=terminal, stdout=subprocess.PIPE, check=False,
                                    env={**os.environ, "TERM": term})
            os.close(terminal)
            text = self.read_terminal(main)
            os.close(main)
            self.assertEqual(result.returncode, 0)
            self.assertEqual("\r[" in text, bar)
            self.assertIn("100.0 %", text)
            self.assertNotIn("\x1b", text)
        result = run(*arguments[1:])
        self.assertEqual(result.stderr, "scene.json: 100.0 %  done\n")
        self.assertEqual(run(*arguments[1:], "--quiet").stderr, "")

    def test_programs_get_json_lines(self):
        result = run("render", self.scene, "-o", self.path("a.png"), "--progress", "json")
        lines = [json.loads(line) for line in result.stderr.splitlines()]
        self.assertEqual(set(lines[-1]), {"state", "progress", "samples_per_second", "seconds_left",
                                          "waits_for", "error"})
        self.assertEqual((lines[-1]["state"], lines[-1]["progress"], lines[-1]["seconds_left"]), ("done", 1, 0))
        self.assertGreater(lines[-1]["error"]["rmse"], 0)
        self.assertEqual(run("render", self.scene, "-o", self.path("a.png"), "--progress", "pie").returncode, 2)

    def test_the_same_picture_is_the_same_file(self):
        arguments = ["render", self.scene, "-q", "-o"]
        run(*arguments, self.path("a.png"))
        run(*arguments, self.path("b.png"), "--threads", "1")
        digests = {hashlib.sha256(self.path(name).read_bytes()).hexdigest()
                   for name in ("a.png", "b.png")}
        self.assertEqual(len(digests), 1)

if __name__ == "__main__":
    unittest.main()
