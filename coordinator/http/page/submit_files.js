// The files that the user chose, and the jobs that they make: a scene with the files that it refers to, or a
// particle file, alone or with its topology.

const largestRead = 64e6;  // bytes; larger scenes are not read
const defaultsOfScene = {width: 1200, height: 800, samples_per_pixel: 500, max_depth: 10, seed: 1};
const defaultsOfParticles = {width: 1200, height: 900, samples_per_pixel: undefined, max_depth: 10, seed: 1};

const namesLack = /\.(dcd|xtc|trr|nc|ncdf|netcdf)$/i;  // trajectories without elements and names
const namesHave = /\.(pdb|gro|psf|prmtop|parm7|cif|pdbqt|mol2|data)(\.gz)?$/i;

const isScene = file => /\.json$/i.test(file.name);
const base = path => path.replace(/^.*[\\/]/, '');
const positive = value => Number.isInteger(value) && value >= 0;

/** Reads a scene. Returns {numbers, files}: its settings, and the names of the files that it refers to.
 *  Returns undefined if the scene is too large or wrong; the server reports what is wrong. */
async function readScene(file) {
  if (file.size > largestRead) return undefined;
  try {
    const {image = {}, render = {}, particles = []} = JSON.parse(await file.text());
    const given = Object.entries({...image, ...render}).filter(([name, value]) => name in defaultsOfScene && positive(value));
    const items = Array.isArray(particles) ? particles : [particles];
    const files = items.flatMap(item => [item?.file, item?.topology]).filter(name => typeof name === 'string').map(base);
    return {numbers: {...defaultsOfScene, ...Object.fromEntries(given)}, files: new Set(files)};
  } catch {
    return undefined;
  }
}

export class ChosenFiles {
  #entries = [];  // {file, scene, content, place}; place: undefined (automatic), 'own', or an entry that uses it
  #changed;

  /** `changed()` is called when a scene has been read. */
  constructor(changed) {
    this.#changed = changed;
  }

  get size() {
    return this.#entries.length;
  }

  get scenes() {
    return this.#entries.filter(entry => entry.scene);
  }

  /** Returns the entries that can use `entry`: scenes, and particle files that need a topology. */
  usersOf(entry) {
    return entry.scene ? [] : this.#entries.filter(other => other !== entry && (other.scene || (namesLack.test(other.file.name) && !namesLack.test(entry.file.name))));
  }

  /** Returns the trajectory whose topology `entry` must be: there is one of each. */
  #trajectoryOf(entry) {
    const trajectories = this.#entries.filter(({file}) => namesLack.test(file.name));
    const topologies = this.#entries.filter(({file}) => namesHave.test(file.name));
    return trajectories.length === 1 && topologies.length === 1 && topologies[0] === entry ? trajectories : [];
  }

  add(files) {
    for (const file of files) {
      const entry = {file, scene: isScene(file)};
      entry.read = entry.scene ? readScene(file).then(content => {
        entry.content = content;
        this.#changed();
      }) : undefined;
      this.#entries = [...this.#entries.filter(other => other.file.name !== file.name), entry];
    }
  }

  remove(entry) {
    this.#entries = this.#entries.filter(other => other !== entry);
    for (const other of this.#entries) if (other.place === entry) other.place = undefined;
  }

  /** Waits until all scenes have been read. */
  async ready() {
    await Promise.all(this.#entries.map(entry => entry.read));
  }

  /** Returns the scenes or the trajectory that a particle file is a part of. */
  ownersOf(entry) {
    if (entry.scene || entry.place === 'own') return [];
    if (entry.place) return [entry.place];
    const owners = this.scenes.filter(({content}) => content?.files.has(entry.file.name));
    const [only, more] = this.scenes;
    if (owners.length) return owners;
    return only && !more && !only.content ? [only] : this.#trajectoryOf(entry);
  }

  /** Returns the jobs in the order of the files: {lead, parts, missing, numbers}. `missing`: names of files that
   *  the scene refers to and that were not chosen. `numbers`: settings without options. */
  jobs() {
    const present = new Set(this.#entries.map(({file}) => file.name));
    return this.#entries.filter(entry => entry.scene || !this.ownersOf(entry).length).map(lead => ({
      lead, parts: this.#entries.filter(entry => this.ownersOf(entry).includes(lead)),
      missing: [...lead.content?.files ?? []].filter(name => !present.has(name)),
      numbers: lead.scene ? lead.content?.numbers ?? defaultsOfScene : defaultsOfParticles}));
  }
}
