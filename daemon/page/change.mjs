// The stream's event `change` merged into the dwell at hand, as docs/api.schema.json has it: objects are merged, entries
// of phasors and elements by their name, all else is replaced.

const NAMES = { phasors: 'channel', elements: 'k' };

const isObject = (x) => typeof x === 'object' && x !== null && !Array.isArray(x);

// The merged object, or null where the change does not fit: the next whole one comes within a second.
function merged(target, change) {
  const result = { ...target };
  for (const [key, value] of Object.entries(change)) {
    if (!(key in target)) return null;
    const name = NAMES[key];
    if (name) {
      if (!Array.isArray(value) || !Array.isArray(target[key])) return null;
      const entries = [...target[key]];
      for (const entry of value) {
        const at = entries.findIndex((candidate) => candidate[name] === entry[name]);
        const both = at < 0 ? null : merged(entries[at], entry);
        if (!both) return null;
        entries[at] = both;
      }
      result[key] = entries;
    } else if (isObject(value) && isObject(target[key])) {
      result[key] = merged(target[key], value);
      if (!result[key]) return null;
    } else {
      result[key] = value;
    }
  }
  return result;
}

export function applyChange(dwell, change) {
  if (!dwell || dwell.index !== change.index || dwell.state !== change.state) return null;
  return merged(dwell, change);
}
