"""Files that the corpus has LAMMPS make."""
def make(where):
    pass
