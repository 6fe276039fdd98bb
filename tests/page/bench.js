// A simulated rig, the service and a browser, for tests: the ports are the kernel's choice, all files lie in a folder of
// their own that goes with them.
import { execFile, spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { chromium } from 'playwright-core';

const ROOT = fileURLToPath(new URL('../../', import.meta.url));
const BIN = join(ROOT, process.env.DWELL_BUILD ?? 'build', 'bin');
const CHROMIUM = process.env.DWELL_CHROMIUM ?? '/usr/bin/chromium';
// For something to come that must come; what is slow on a loaded machine is late, not wrong.
export const PATIENCE_MS = 60_000;

export const TOKEN = '0123456789abcdef0123456789abcdef';

// Resolves once the condition, a function that may be asynchronous, holds.
export async function until(condition, patience_ms = PATIENCE_MS) {
  for (const deadline = Date.now() + patience_ms; !(await condition()); await new Promise((done) => setTimeout(done, 100)))
    if (Date.now() > deadline) throw new Error(`never: ${condition}`);
}

// What dwellctl prints.
export const dwellctl = async (...options) => (await promisify(execFile)(join(BIN, 'dwellctl'), options, { maxBuffer: 1e8 })).stdout;

// A port that nobody listens on now.
async function freePort() {
  const server = createServer().listen(0, '127.0.0.1');
  await once(server, 'listening');
  const { port } = server.address();
  server.close();
  await once(server, 'close');
  return port;
}

const running = new Set();
process.on('exit', () => running.forEach((child) => child.kill('SIGKILL')));

class Program {
  output = '';
  #child;

  constructor(name, options) {
    this.#child = spawn(join(BIN, name), options, { stdio: ['pipe', 'pipe', 'pipe'] });
    running.add(this.#child);
    this.ended = once(this.#child, 'exit').then(() => running.delete(this.#child));
    for (const stream of [this.#child.stdout, this.#child.stderr]) {
      stream.on('data', (bytes) => {
        this.output += bytes;
        this.onOutput?.();
      });
    }
  }

  // What the group of `pattern` matches in the output, once it does.
  async said(pattern) {
    const deadline = Date.now() + PATIENCE_MS;
    for (;;) {
      const match = this.output.match(pattern);
      if (match) return match[1];
      if (this.#child.exitCode !== null || Date.now() > deadline) throw new Error(`no ${pattern} in:\n${this.output}`);
      await Promise.race([new Promise((done) => (this.onOutput = done)), this.ended, new Promise((done) => setTimeout(done, 1000))]);
    }
  }

  say(line) {
    this.#child.stdin.write(`${line}\n`);
  }
  signal(name) {
    this.#child.kill(name);
  }
  async end(signal = 'SIGTERM') {
    this.#child.kill('SIGCONT');
    this.#child.kill(signal);
    await this.ended;
  }
}

export class Bench {
  // rig: options of rigsim; edit: changes the text of the rig file, given the folder; files: put there, by name.
  static async begin({ rig = [], edit = (text) => text, files = {} } = {}) {
    const bench = new Bench();
    bench.folder = await mkdtemp(join(tmpdir(), 'dwell-page-'));
    for (const [name, bytes] of Object.entries(files)) await writeFile(join(bench.folder, name), bytes, { mode: 0o600 });
    bench.rigOptions = ['--unit', 'mm', '--noise', '0.001', ...rig];
    await bench.startRig();
    let text = await readFile(join(ROOT, 'config/rigs/clamped.toml'), 'utf8');
    text = edit(text.replace(/^port .*/m, `port = ${bench.rigPort}`).replace(/^rate .*/m, 'rate = 200'), bench.folder);
    // The service has the same port, and so the same rig file, when it is started again.
    bench.rigText = text.replace(/^listen .*/m, `listen = "127.0.0.1:${await freePort()}"`);
    await bench.startService();
    return bench;
  }

  async startRig(port = 0) {
    this.rig = new Program('rigsim', ['--tcp', `127.0.0.1:${port}`, ...this.rigOptions, '--stopped']);
    this.rigPort = await this.rig.said(/^tcp .*:(\d+)$/m);
  }

  async startService() {
    const path = join(this.folder, 'rig.toml');
    await writeFile(path, this.rigText);
    this.service = new Program('dwelld', ['--config', path, '--control', join(this.folder, 'control')]);
    this.port = await this.service.said(/serving rig.* port (\d+)/);
    this.url = `http://127.0.0.1:${this.port}`;
  }

  async get(path) {
    return (await fetch(this.url + path)).json();
  }

  async end() {
    await Promise.all([this.rig?.end(), this.service?.end()]);
    await rm(this.folder, { recursive: true, force: true });
  }
}

// Options of Bench.begin() for the clamped bench played from a recording that rigsim made with these options: whatever
// the computer is busy with meanwhile, the readings and their instants are the same.
export async function recordingOf(options) {
  const csv = (await promisify(execFile)(join(BIN, 'rigsim'), ['--unit', 'mm', '--noise', '0.001', '--rate', '200', '--csv', '-', ...options], { maxBuffer: 1e8 })).stdout;
  const played = '[[device]]\nname = "amplifier"\ndriver = "replay"\nfile = "recording.csv"\n\n';
  const wired = /^(device|station|table|register|type|order) .*\n/gm;
  return {
    edit: (text) => text.slice(0, text.indexOf('[[device]]')) + played + text.slice(text.indexOf('[[channel]]')).replace(wired, ''),
    files: { 'recording.csv': csv },
  };
}

// Options of Bench.begin() for a clamped chain of so many equal masses: a channel on the table, one on each, and the load
// cell. It settles within 30 s.
export function chainOf(masses) {
  const list = (count, value) => Array(count).fill(value).join(',');
  const channel = (place, register) => `
[[channel]]
name = "${place === masses + 1 ? 'reaction' : `y${place}`}"
device = "amplifier"
measures = "${place === masses + 1 ? 'force' : 'displacement'}"
at = ${place === masses + 1 ? '"ground"' : place}
unit = "${place === masses + 1 ? 'N' : 'mm'}"
station = 1
table = "input"
register = ${register}
type = "float32"
order = "abcd"
`;
  return {
    rig: ['--masses', list(masses, 5), '--stiffness', list(masses + 1, 30_000), '--damping', list(masses + 1, 60)],
    edit: (text) => text.slice(0, text.indexOf('[[channel]]')).replace(/^masses .*/m, `masses = [${list(masses, 5)}]`)
      .replace(/^mass_u .*/m, `mass_u = [${list(masses, 0.003)}]`) +
      Array.from({ length: masses + 2 }, (_, place) => channel(place, 2 * place)).join(''),
  };
}

export const SIZES = { phone: { width: 360, height: 780 }, desk: { width: 1440, height: 900 }, wall: { width: 1920, height: 1080 } };

export const openBrowser = (options = []) => chromium.launch({ executablePath: CHROMIUM, args: ['--headless', '--no-sandbox',
  '--disable-gpu', '--disable-background-networking', '--disable-component-update', '--disable-sync', '--no-first-run', ...options] });
