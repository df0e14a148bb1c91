"""The public packages of the corpus with their versions, and the choice of their files.

A choice is (pattern, most): paths inside the archive, below its top folder, that match the pattern. If more than `most`
match, `most` of them are spread over the sorted list. manifest.tsv contains the result; `collect --choose` updates it."""

import dataclasses
import os
import pathlib
import re

MANIFEST = pathlib.Path(__file__).resolve().parent / "manifest.tsv"
LARGEST = 30_000_000  # bytes of a file, unpacked from the archive


@dataclasses.dataclass(frozen=True)
class Package:
    client: str   # "debian": apt-get source; "pypi": pip download of the source distribution
    name: str
    version: str
    archive: str  # the file's name
    sha256: str
    choices: tuple

    @property
    def folder(self):
        """The folder of its files in the cache."""
        return f"{self.name}-{self.version}"


PACKED = r"(\.gz|\.bz2)?$"
MDA = "MDAnalysisTests/data/"
PACKAGES = (
    Package("pypi", "mdanalysistests", "2.11.0", "mdanalysistests-2.11.0.tar.gz", "5edeb5b01805da728b202103aa8d2b5974a37f1005ab1fe0150ed7d59702d2ea", (
        (MDA + r"dssp/.*\.pdb" + PACKED, 4),
        (MDA + r"(?!dssp/|windows/).*\.(pdb|ent|pdbx|cif|gro|pqr|pdbqt|mol2|sdf)" + PACKED, 200),
        (MDA + r"(?!windows/).*\.(xyz|lammpstrj|dump|data|data2|dcd|xtc|nc|ncdf)" + PACKED, 100),
        (MDA + r"windows/.*\.(pdb|lammpstrj)", 9),
        # Mostly formats that ParRay does not read.
        (MDA + r".*\.(trr|h5md|gsd|mmtf|txyz|arc|mdcrd|tng|dms|rst7|inpcrd|crd)$", 14),
        (MDA + r"dlpoly/(CONFIG|HISTORY)$", 2))),
    Package("pypi", "biopython", "1.88", "biopython-1.88.tar.gz", "9aaa31c0bda4d059f7b2ee00bfdb5cbb73ade3057aa4b737a7cc0187091d071a", (
        (r"Tests/PDB/.*\.(pdb|cif|ent)$", 60), (r"Tests/PQR/.*\.pqr$", 5), (r"Tests/(?!PDB).*\.ent$", 4),
        (r"Tests/PDB/.*\.(bcif\.gz|mmtf)$", 5))),
    Package("pypi", "gemmi", "0.7.5", "gemmi-0.7.5.tar.gz", "3328f26c8a8a0ef6a7fc8bb28e167818e324e4239dd4197d6b6066ae2b6315fe", ((r"tests/[^/]*\.(pdb|ent|cif)" + PACKED, 50),)),
    Package("pypi", "ase", "3.29.0", "ase-3.29.0.tar.gz", "ef4e2caa38169e3fbbc4164764a060d1877a6692519a4bed82521328eeb0d9aa", (
        (r"ase/test/testdata/.*\.(cif|xyz|data)$", 20), (r"ase/test/testdata/.*/POSCAR_example_1", 1))),
    Package("pypi", "meeko", "0.8.0", "meeko-0.8.0.tar.gz", "09a892bd796c1e1b72b73305f36b694cad99993d6f96acd85bb8d9341bc149d8", (
        (r".*\.pdbqt$", 12), (r".*\.sdf$", 8), (r".*\.pdb$", 8), (r".*\.(mol|pqr)$", 4))),
    Package("pypi", "qc-iodata", "1.0.1", "qc_iodata-1.0.1.tar.gz", "66eb8dcb7987f9d2a11a7dad28409d421bbd5033de944ce74b656a64c3fa6fd9", (
        (r".*\.(xyz|pdb|sdf|gro|mol2)$", 40), (r".*\.(poscar|POSCAR|crd)$", 2))),
    Package("debian", "openbabel", "3.1.1+dfsg-9", "openbabel_3.1.1+dfsg.orig.tar.xz", "4c35e6857529d0bc51f5b2b97aeec291d4124773786f4f4409466bef691353d4", (
        (r"test/files/[^/]*\.(mol2|cif|pdb|xyz)" + PACKED, 60), (r"test/files/[^/]*\.sdf\.gz$", 4),
        (r"test/.*\.(sdf|sd|mol)$", 16))),
    Package("debian", "rdkit", "202209.3-1", "rdkit_202209.3.orig.tar.xz", "f9e9db721e2ff9eee131dee2e9e3ddec79325f653fded6a0e6444be6055d3b84", (
        (r"Code/GraphMol/FileParsers/test_data/.*\.mol2$", 12), (r"Code/.*\.pdb$", 14), (r"Code/.*\.xyz$", 10),
        (r"Code/GraphMol/FileParsers/.*\.sdf" + PACKED, 12), (r"Code/GraphMol/FileParsers/.*\.mol" + PACKED, 14))),
    Package("debian", "gromacs", "2022.5-2", "gromacs_2022.5.orig.tar.gz", "083cc3c424bb93ffe86c12f952e3e5b4e6c9f6520de5338761f24b75e018c223", (
        (r"src/.*\.gro$", 26), (r"src/.*\.pdb$", 14), (r"src/.*\.xtc$", 5), (r"src/.*\.(g96|trr)$", 3))),
    Package("debian", "lammps", "20220106.git7586adbb6a+ds1-2", "lammps_20220106.git7586adbb6a+ds1.orig.tar.xz", "65146c615ad24d8b8bc64f4e05e86226a7f1fdb45c0b5ea9416562b9f3863082", (
        (r"(examples|bench|unittest|tools)/(.*/)?(data\.[^/]*|[^/]*\.data(\.gz)?)$", 36),
        (r"(examples|unittest|tools)/.*/dump\.(meoh|colloid|atom)$", 3),
        (r"(examples|tools)/.*\.(xyz|pdb|pdb1)$", 14), (r"tools/.*\.arc$", 1))),
    Package("debian", "apbs", "3.4.1-5", "apbs_3.4.1.orig.tar.gz", "644e6246fd37c9dd4172fc7be1763337082ab8584dbcd53e738c831b62c89bb2", (
        (r".*\.pqr$", 20), (r".*\.pdb$", 5), (r".*\.xyz$", 4), (r".*\.dcd$", 1))),
    Package("debian", "biojava4-live", "4.2.12+dfsg-8", "biojava4-live_4.2.12+dfsg.orig.tar.xz", "63ea99c016b4bbb87a62c9cb05d0dbc352845851c200b676821037d76c6021c7", (
        (r"biojava-structure/src/main/resources/.*chemcomp/.*\.cif\.gz$", 14),
        (r"biojava-structure/src/test/resources/.*\.(cif|pdb)" + PACKED, 16))),
    Package("debian", "openmm", "7.7.0+dfsg-9", "openmm_7.7.0+dfsg.orig.tar.xz", "a652bcb5653db7639ed844b3ad2f2986a20b273bfa0cfe462fadcf3cd2ef0302", (
        (r".*\.pdb$", 12), (r".*\.(gro|cif)$", 5))),
    Package("debian", "theseus", "3.3.0-14", "theseus_3.3.0.orig.tar.gz", "3cfd4f906717f9cb8e77f689fc97059b32df355c0696077034ea99a485e3f2fe", ((r".*\.pdb$", 8),)),
    Package("debian", "rasmol", "2.7.6.0-3", "rasmol_2.7.6.0.orig.tar.gz", "3e623692f66cc7a760527489ee0e10bebde5776092079a3c6bb6c6a63c83ecac", (
        (r"data/.*\.([pP][dD][bB]|[cC][iI][fF]|ent)" + PACKED, 12),)),
    Package("debian", "drawxtl", "5.5-6", "drawxtl_5.5.orig.tar.gz", "e33bddb99f349d02f2c889ab04116285daf2ee026c2a33e8129866ffc6eb5da4", ((r"examples/.*\.cif$", 4),)),
    Package("debian", "garlic", "1.6-3", "garlic_1.6.orig.tar.gz", "c99da419cb022d7120074baeaf922b3c66223fb7e78ef932e5a254fd6e0a0c8b", ((r".*\.pdb$", 4),)),
    Package("debian", "draco", "1.5.5+dfsg-2", "draco_1.5.5+dfsg.orig.tar.xz", "0d4ff5b218a2f9d836c6f44202918402591407b5f59a5103ec288c5600ab087f", ((r"testdata/.*\.ply$", 20),)),
    Package("debian", "assimp", "5.2.5~ds0-1", "assimp_5.2.5~ds0.orig.tar.xz", "ee20da341210d15296e74304ebaf88563734048401f71f008d7d6ae1da373e1d", ((r"test/models/.*\.ply$", 12),)),
    Package("debian", "openmesh", "9.0-4", "openmesh_9.0.orig.tar.gz", "4df84295f5cca86b1ae8bfee8ff4db5efb6850e4e5b571ad0199147176dea796", ((r"src/Unittests/.*\.ply$", 20),)),
)


def chosen(package, paths):
    """Returns the paths that the choices of a package select, sorted."""
    taken = set()
    for pattern, most in package.choices:
        matching = sorted(path for path in paths if re.fullmatch(pattern, path) and path not in taken)
        step = max(1.0, len(matching) / most)
        taken.update(matching[int(i * step)] for i in range(min(most, len(matching))))
    return sorted(taken)


def folder():
    """Returns the folder of the corpus."""
    cache = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
    return pathlib.Path(os.environ.get("PARRAY_CORPUS") or pathlib.Path(cache) / "parray-corpus")


def manifest():
    """Returns (sha256, folder of the package, path) of each file."""
    return [tuple(line.split("\t")) for line in MANIFEST.read_text().splitlines() if not line.startswith("#")]
