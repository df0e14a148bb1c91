#include "cli/commands/manual.h"

#include <map>

namespace parray::commands {
namespace {

constexpr const char* render_manual = R"(# Accuracy
Every picture comes with its error: the root mean square, over pixels and channels, of its distance
from the picture that endless samples would give, in linear radiance, with an interval that holds
95 % of the time. It is measured: the samples with even and with odd numbers are two independent
pictures, and what they differ by is what each of them errs by. The last line says it, `error`
of the report has it, and a target is met by the upper end of the interval.

- `--target-error`, `--target-half-width`, `--time-limit` and `--spp` may stand together: whichever
  comes first ends the render, `stopped_by` of the report says which.
- The first three go in passes and are adaptive: from 32 samples a pixel on these go where they
  serve most, if that is well paid. `--adaptive off` spreads them evenly, `--adaptive on` does the
  same to `--spp`.
- What the clock has decided is in the report's `passes`: the same command with `--passes` instead
  of `--time-limit` gives the same bits again.
- A time limit includes denoising, extra channels, the error map and writing. Steps that do not fit
  into it are left out, and a line names each.
- Where a time limit is short for the picture, what could not be traced is filled from what was:
  the last line and the report say so, and channel `samples` has 0 there.
- With fewer than 2 samples a pixel there is no error to state.

`--error-map` draws each pixel's 95 % half-width, of its worst channel, as colours on a logarithmic
scale with a legend below.

# The same bits
A picture is a function of the scene, its settings and its seed, and of nothing else: not of
threads, workers, schedules, accelerators, instruction sets or crashes. `--like` takes all that
decides the bits from a picture that was rendered before.

# Denoising
`--denoise` filters the picture by what the pixels around show, by albedo, normal and depth of what
is first seen, and says the error that is left. The error and hash of the picture as its samples
make it stay in the report, and in an EXR file that picture itself: channels `raw.R`, `raw.G`,
`raw.B`. `--target-error` counts the denoised picture then.

# Extra channels
`--aov` writes named channels into an EXR file, beside R, G and B, whose bits stay the same. Depth,
normal, albedo, sphere and cost are traced for them, with the camera rays and paths of the first
16 samples of each pixel.

- `depth` (`Z`): mean distance of what is first met from the plane of the camera, along the
  direction in which it looks, in the scene's unit. +inf: only sky
- `normal` (`N.X`, `N.Y`, `N.Z`): mean unit normal there, in the scene's axes, on the side that
  is seen. The sky counts as 0
- `albedo` (`albedo.R`, `.G`, `.B`): mean albedo there: the material's, 1 for glass. The sky
  counts as 0
- `sphere` (`sphere`): number of the sphere that the first sample meets, as a whole number
  (EXR's UINT): from 0, those of `spheres` first, then the particles; duplicates that were left
  out do not count. In the portrait of a bare file 0 and 1 are ground and flag, so that particle
  n is n + 2. 4294967295: sky
- `cost` (`cost`): mean number of ray segments of a sample: where the time goes
- `samples` (`samples`): number of samples that its mean is of, as a whole number; also without
  `--aov` where pixels differ
- `half-width` (`half_width.R`, `.G`, `.B`): half of the length of its 95 % interval, linear
  radiance

# Transparent pictures
`--transparent on`, or `transparent` of the scene's `image`, leaves the background out. Alpha is the
share of a pixel's camera rays that meet something, over all its samples; an EXR file has
premultiplied colours and channel `A`, a PNG file unassociated 8-bit RGBA. A portrait has no ground
then. The sky behind gives back the opaque picture, whose hash, `image_sha256`, and error stay in the
report. It takes the scene: `render`, `submit --wait -o` and `parray-mpi`; a series and HTTP refuse it.

# Finishing
`--outline` draws dark lines where spheres end before others that are farther away, `--depth-cue`
lets what is far fade into the background: of PNG pictures, after they were traced. Styles of
portraits and a scene's section `finishing` ask for them, too. They need the scene: `fetch`, HTTP and
series leave them out.

# Labels
`--legend`, `--scale-bar`, `--text` and the like draw on a PNG picture once it is traced. An EXR file
keeps what was traced; `image_sha256` and the report are the same with and without them. `--width-mm`
and `--dpi` are the size in print: letters have 8 points there, unless `--font-size` says otherwise,
and the file says how large it is (`pHYs`). What cannot be drawn, or does not fit, is refused before
anything is traced. A scene's section `labels` asks for the same.

# Previews
`--preview` keeps a picture file up to date, and ends as a copy of the picture. The first is there
as soon as every pixel has a sample, or before; later ones as often as a fiftieth of the time
allows, ten times a second at most.

# Scenes
A scene is one JSON file; `scenes/schema/scene.v1.schema.json` is its definition. A file of
particles (PLY, CSV, XYZ, LAMMPS dumps and data files, PDB, PDBQT, PQR, GRO, SDF, MOL2, CIF, DCD,
XTC, TRR, AMBER NetCDF; told by what is in it) is rendered as a portrait: every particle in the picture, on a pale ground, lit from the upper left, 1200 x 900 pixels and 256 samples. `--view` says
from which side: `front` (x to the right, z up), `back`, `left`, `right`, `top` (x to the right, y
up), `bottom`, `iso`, or the axis that points at the viewer (`+x`); `auto` shows molecules along
their principal axes, flat groups face on, all others from above and aside. `--style` says what is
around them: `studio`, `publication`, `flat` or `night`. To change more, make a scene of it with
`parray convert`.

# Report
`--report` writes one JSON object:

- `image_sha256`: of the float32 little-endian RGB pixels, top row first
- `scene_sha256`: of the scene's binary form, whatever file format it was read from
- `width`, `height`, `samples_per_pixel`, `max_depth`, `seed`: settings that decide the picture;
  `samples_per_pixel` is the mean where pixels differ
- `precision`, `precision_reason`: `f32`, `mixed` or `f64`, and why
- `sampler`, `adaptive`, `passes`: the rest of them: where samples lie, and the samples of each
  pass; with `--spp` alone there are no passes
- `target_error`, `target_half_width`, `time_limit`: limits that were asked for; 0: none
- `least_samples`, `most_samples`: of any pixel
- `filled_pixels`, `fill_block`: pixels without a sample, which show another; side of the
  largest block that one traced pixel fills (1: none)
- `error`: `rmse`, `low`, `high`: see "Accuracy"; `half_width_p50`,
  `half_width_p99` of all pixels' and channels' 95 % intervals; `method`; `truncation`: the most
  that `max_depth` may have cut off the mean radiance (the mean throughput of the paths that it
  ended, times the largest radiance of the sky). `null` with fewer than 2 samples a pixel
- `denoised`: with `--denoise` only: `rmse`, `low`, `high` and `image_sha256` of the denoised
  picture; the time that it took is `seconds.denoise`
- `transparent`: of a transparent picture only: `image_sha256`, of its premultiplied RGB, then
  alpha, float32 little-endian; `covered`, the mean of alpha
- `stopped_by`: `samples`, `error`, `half-width`, `time` or `passes`: what ended the render
- `accelerator`, `isa`, `schedule`, `row_order`: how it was computed; never changes a bit
- `legends`: what the particles' colours mean, where a rule colours them: `title`, `unit`, of a scale
  `low`, `high` and `stops`, of categories `entries` with `name`, `color` (linear RGB) and `count`
- `spheres`, `features`: what the scene required
- `duplicates_removed`: spheres of the scene file that only repeat another's centre and radius
- `notes`: what was guessed, dropped or left out of files of particles, if anything was: a list of
  `file`, `key`, `count` and `text`
- `accelerator_bytes`: memory of the accelerator, positions and radii included
- `threads`, `workers`: that contributed
- `checked_share`: share of the cells, 0 to 1, that another machine or the referee traced, too, with
  the same bits
- `flag`: what was found wrong with results and mended; empty: nothing
- `samples`, `rays`, `samples_per_second`, `rays_per_second`: a ray is one segment of a path;
  rates are of tracing: `seconds.render` less `seconds.build`
- `seconds`: `load`, `submit` (the scene's identity and settings), `render` (`build`, and
  `deciding` on the next pass, are parts of it), `aovs`, `denoise` and `transparent` if there are
  any, `write`, `other` (waiting for a turn, making the image and its error), `total`
- `mpi`: of `parray-mpi` only: `mode`, `transport` (`window`, `messages`, or `memory` for one
  rank), `leases`, mean time of taking a lease and of handing in a result in microseconds,
  `copies` of ranges traced again, `duplicate_cells`, `mismatched_cells`, `corrupt_results`,
  `faulty_ranks` (that returned wrong bits: `rank`, `host`, `retraced_cells`, `restarted`,
  `left_out`), and for each of `ranks` its host, threads, samples, leases and time spent tracing
  (`normalized_seconds`: over that of the whole render); `row_seconds` with `--row-seconds`
- `aovs`: extra channels in the picture, with `--aov` only; the time that they took is
  `seconds.aovs`; `channel_samples` of each pixel are in those that are traced
- `nonfinite_samples`, `nonfinite_pixels`, `nonfinite`: samples that were not finite, and pixels
  that have some; the first 20 of these with `x`, `y`, `samples` and `first_sample`. They are
  left out of the mean; if there are any, the exit status is 1
- `version`, `trace_version`: of ParRay, and of the rules that decide the bits of a picture, sample
  counts included: pictures of one trace version have the same bits
)";

constexpr const char* convert_manual =
    R"(From a scene file it writes a self-contained one, every particle among its spheres: read back, it
is the same scene to the last bit. From a file of particles it writes its portrait, as a scene that
refers to the file; with `--expand` one that has every particle as a sphere.

# Particles
Each item of `particles` in a scene names a file, relative to the scene file's folder. Its
particles become spheres after those of `spheres`. What they get is said by two keys:

- `material`: `"by-element"`: a diffuse surface of the element's colour
- `material`: `"by-type"`: the material that has the type's name in `materials`, or else one of
  seven colours that people with any colour vision tell apart (Okabe and Ito), in turn
- `material`: `"column"`: a diffuse surface of the file's colour
- `material`: any other text: the material of that name
- `material`: nothing: the first of `column`, `by-element`, `by-type` that the file supports
- `radius`: a number: it
- `radius`: `"by-element"`: the element's van der Waals radius, in angstrom
- `radius`: `"column"`: the file's radius
- `radius`: nothing: the first of `column`, `by-element` that the file supports
- `alternatives`: `"best"` (default): of an atom's alternative locations, and of sites of a crystal
  that exclude each other, the one of the highest occupancy, the first of equals
- `alternatives`: `"all"`: all of them
- `alternatives`: a letter: those so called, and the best where there is none of that name

A column that the file lacks is an error that lists those that it has. A portrait, and
`parray convert`, help themselves where a scene would not: without any column for it, the material
is `plain`, and the radius is half the spacing of a lattice of as many particles.
)";

constexpr const char* validate_manual =
    R"(A scene is read strictly: an unknown key, a number out of its range or an impossible camera is one
line with file, line, place and remedy, and exit status 2. What is printed tells the spheres and
materials, which features the picture requires, how far rounding moves surfaces, and what `auto`
picks for precision and accelerator, and why. Of spheres with exactly the same centre and radius
only the first stays, and a warning says so.
)";

constexpr const char* plan_manual =
    R"(Traces parts of the picture and prints the command that gets to the error soonest, or to the least
error in the time, with the time, the error and the samples a pixel to expect, each with a 95 %
confidence interval. The command recommended has `--target-error` or `--time-limit`, so that it keeps
the goal even where the plan is wrong. An alternative with `--spp` follows, with the probability
that it keeps the goal, and a table of all ways. `--confidence` is the required probability.

The probe takes half of the render's time, or 1 s if that is more, and at most `--probe-seconds`.
Where rendering takes less time than planning took, a line says so. Options of the picture, and `--threads`, mean what they do for `parray render`.

`--workers` or `--speeds` plan for a farm: the `parray submit` command, and the time that its
workers take, by the coordinator's own leases. All pixels count as equally dear then, and the
network and sending the scene come on top.

An error that rounding, or the most samples that there may be, put out of reach is refused with one
that can be had.
)";

constexpr const char* tradeoff_manual =
    R"(Renders the scene a few hundred times in small. The first line printed is the command with the
cheapest settings for the error asked, as measured on this machine. A sentence says what it takes,
and how long the scene's own settings take for the same error. The tables follow.

- It tries samples a pixel from 16 on by doubling, of both samplers; adaptive targets; some numbers
  of samples denoised; depths; precisions; accelerators; and what `--also` names: a line along each knob,
  not all products. Settings take turns, each with 2 to 16 seeds of its own.
- Errors are against a reference in f64, of independent samples and four times the depth, in two
  halves, so that the reference's own error does not count.
- The picture has 200 pixels on the shorter side at most: the error of a pixel hardly depends on how
  many there are, and time is in proportion.
- Every render is kept as it is done: after Ctrl-C the same command goes on. A longer
  `--time-budget` adds to what there is; another scene, size or processor needs another directory
  or `--restart`.

# Files
- `tradeoff.csv`, `tradeoff.json`: a row for each setting: seconds with quartiles, RMSE with its
  standard deviation, what the pictures claimed and how often that held, and the error's parts:
  noise, depth, precision, 8 bits.
- `farms.csv`: the same settings' times for 1, 4, 16 and 64 workers, modelled.
- `plots`: convergence, the front of time and error, the error's parts, how often intervals hold,
  the modelled fronts, as PDF, SVG and PNG, with gnuplot's scripts and data.
- `runs.csv`: every render.
)";

constexpr const char* compare_manual =
    R"(For each picture of the reference's size, over all channels of linear RGB: MSE; RMSE; PSNR, for a
peak of 1; relMSE, the mean of (F - R)^2 / (R^2 + 0.01); SMAPE, the mean of |F - R| / (|F| + |R| +
0.01); the mean, the 99.9th percentile and the largest of |F - R| with its pixel; the bias, the mean
of F - R; and whether every bit is the same. FLIP (Andersson et al. 2020) is what a viewer sees who
flips between the two on a screen, from 0 to 1; HDR-FLIP (2021) is the same at all exposures, for
EXR against EXR only. `--json` prints every number, with its formula.

Pixels that are not finite are left out; a warning counts them, and the exit status is 1.

`-o` draws white less V, the sum of |F - R| over all pictures, not scaled; black is a sum of 1 or
more.
)";

constexpr const char* verify_manual =
    R"(A picture carries its recipe: all that decides its bits, and its error. Without SCENE its pixels are
compared with the hash in the file. With SCENE, pixels picked at random are traced again, each with
its own number of samples, and their bits are compared, of a PNG file the 8-bit values that they
become. Of N pixels at random at least one is wrong with a probability of 1 - (1 - s)^N where a
share s of all is: 299 find 1 % with 95 %.

Never checked are extra channels, the error, and how samples were allotted. PNG has no room for the
samples of each pixel: of an adaptive one only the hash is checked; `parray render --like` makes it
again.

The exit status is 0 if nothing is wrong, 1 if something is, and 2 where the picture has no recipe,
SCENE is another scene, or the tracer has changed since.
)";

constexpr const char* submit_manual =
    R"(Prints the number of the job alone on stdout. Options of the picture mean what they do for
`parray render`, and give the same bits; `parray-render(1)` explains them, and the report.

# Series
A series is shown and steered as one job, and counts as one for limits; each frame is a job of its
own. Frames are numbered scenes or particle files (`scene-####.json`), one scene along a camera
path, or the frames of a trajectory that the scene names. A frame that cannot be read, or fails, has
a line at the end and status 1; the others go on. The same command run again goes on where it was.

- A camera path is a JSON file, each camera as in a scene, with a smooth curve through all of them:

    {"cameras": [{"frame": 0, "look_from": [9, 2, 3], "look_at": [0, 0, 0], "vfov": 40},
                 {"frame": 60, "look_from": [3, 2, 9], "look_at": [0, 0, 0], "vfov": 40}]}

- A trajectory is a file of several frames under `particles` (XYZ, LAMMPS dump, DCD, XTC, TRR,
  AMBER netCDF, models of PDB), with its `topology` if it has no names of its own; frames count from 0. One with `"frame": N` of its own stays at that.

# Several people
Each user gets as much of the workers' time as the others, however many jobs each has. Of one user's
jobs the one of higher priority goes first, then the older; but a quarter of what the user gets goes
to the job with the least work left.
)";

constexpr const char* jobs_manual =
    R"(ERROR is that of a job that is done; on the way to a target it says how far it is. A job that waits
says for what on stderr: workers, memory, room on the disk.
)";

constexpr const char* show_manual =
    R"(Of a job that has ended it says, too, where its time went: tracing, until workers had the scene,
between leases, at the end.
)";

constexpr const char* requeue_manual = R"(It goes on with the rows that it has.
)";

constexpr const char* fetch_manual =
    R"(The picture's hash is compared with the one that the coordinator states. There is no scene to trace
extra channels from: of `--aov` only samples and half-width can be had, and the picture keeps its
background.
)";

constexpr const char* audit_manual =
    R"(Follows the job's journal and says whether every cell of every pass was merged exactly once, by whom,
and that the picture is the one that its report states. The exit status is 1 if not.
)";

constexpr const char* replay_manual =
    R"(Deals the recorded costs of a job's cells out again, by each schedule and to 1 to 16 times as many
workers, in virtual time.
)";

constexpr const char* workers_manual =
    R"(A worker that was drained finishes what it has and gets no more; `readmit` gives it leases again, also
one that was quarantined for wrong bits. Both count for workers that come later, and outlive the
coordinator. A quarantine is that of a machine (its key, else its address), which `readmit` takes for a
name, too. That of an address ends by itself after 24 hours.
)";

constexpr const char* keygen_manual =
    R"(Beyond its own machine a coordinator listens to keys only. Everything is encrypted (CURVE), both
sides know whom they talk to, and who has no key on the list `DIR/allowed` is not heard at all.

- A key has a role: `worker` traces; `client` submits, looks at all and steers its own jobs; `admin`
  steers everybody's.
- A running coordinator follows changes within a second.
- Files with a secret that others on the machine can read are refused.

# Files
- `DIR/coordinator.key`, `DIR/worker.key`, `DIR/admin.key`: secret keys of the coordinator, of
  workers, and of whoever has the farm.
- `DIR/NAME.key`: that of NAME; give it to them by a safe way.
- `DIR/allowed`: the list.
)";

constexpr const char* doctor_manual =
    R"(Looks, in a few seconds: at the processor's rounding and floating-point mode; at every instruction
set's kernels, in every precision, which have to trace a built-in picture to its pinned bits; at hits
on spheres over 24 decades of radii; at threads; at libraries and the files that they write; at
ZeroMQ, also with keys; and at an `mpirun` of two ranks. The exit status is 1 if something failed;
what is merely missing, such as MPI, is skipped.
)";

constexpr const char* parray_manual =
    R"(A picture is a function of the scene, its settings and its seed, and of nothing else: the same bits
on any machine, with any number of threads, workers or ranks. Every picture comes with its error.

`parray render` renders here. A farm is one `parray-coordinator` and any number of `parray-worker`,
which people hand scenes to by `parray submit`. `parray-mpi` is a farm inside one mpirun.

# Files
`share/parray/scenes` where ParRay is installed has scenes to try, and the schema of a scene file.
)";

constexpr const char* mpi_manual =
    R"(Renders to the same bits as `parray render`, with every option of it; `parray-render(1)` explains
them, and the report. No rank is spent on coordination: ranks take leases by themselves, by atomic
operations on a window of rank 0's memory, put their rows there, and rank 0 traces with the rest.
Each rank has its share of its machine's processors as threads.

- A rank that stalls delays nobody for long: idle ranks trace its cells again. Between the passes of
  a picture with a target or a time limit all ranks have to meet: there it is waited for,
  `--patience` seconds at most.
- A rank that dies takes the job with it, as MPI has it, but not the work: finished rows are kept
  every 10 seconds (`--checkpoint`) in `IMAGE.state`, or in the directory of `--state`, and the same
  command goes on from there with any number of ranks. So does `parray-coordinator --state`.
- `--mode` picks how ranks share the work: `window`; `messages`, what that falls back to where MPI's
  windows do not work; `static`, `openmp` and `sequential` to compare with. None changes a bit.
- As root, mpirun wants `--allow-run-as-root`; for more ranks than cores, `--oversubscribe`. What
  Debian's Open MPI needs so that windows reach across machines, and so that a rank is not bound to
  a single core, parray-mpi sets by itself, unless you have.
- Of more than 256 ranks, groups take their leases from a rank of their own (`--ledger-ranks`). Give
  ranks four threads or more then.
- Memory at rank 0: about 160 bytes a pixel and the scene, in passes up to 240 and up to 256 MB of
  rows that wait; elsewhere the scene, a few megabytes, and in passes 8 bytes a pixel.
)";

}  // namespace

std::string manual_of(const std::string& command) {
  static const std::map<std::string, const char*> manuals = {
      {"render", render_manual}, {"convert", convert_manual},   {"validate", validate_manual},
      {"plan", plan_manual},     {"tradeoff", tradeoff_manual}, {"compare", compare_manual},
      {"verify", verify_manual}, {"submit", submit_manual},     {"jobs", jobs_manual},
      {"show", show_manual},     {"requeue", requeue_manual},   {"fetch", fetch_manual},
      {"audit", audit_manual},   {"replay", replay_manual},     {"workers", workers_manual},
      {"keygen", keygen_manual}, {"doctor", doctor_manual},     {"parray", parray_manual},
      {"mpi", mpi_manual},
  };
  const auto found = manuals.find(command);
  return found == manuals.end() ? "" : found->second;
}

}  // namespace parray::commands
