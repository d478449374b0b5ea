// web.mjs SITE PROGRAM: runs experiments in the module for browsers and in the program, and compares the hashes of their results: of
// one robot with 1, 2 and 8 workers, with and without vectors; of the optimisers; and of all shipped experiments, shortened. Compares operations
// between the module's codes. Prints speed, size and memory.
import assert from 'node:assert';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Worker } from 'node:worker_threads';
import { gzipSync } from 'node:zlib';

const [site, program] = process.argv.slice(2);
const { Instance, Part, Refusal } = await import(join(site, 'instance.js'));
const { Pool } = await import(join(site, 'pool.js'));
const folder = mkdtempSync(join(tmpdir(), 'oneiro-web-'));

const requested = (name, set = []) => ({ name: `${name}.toml`, text: readFileSync(`experiments/${name}.toml`, 'utf8'), set });

/** The hash of the program's run. */
function native({ name, set }, seed) {
    const out = join(folder, `${name}-${set.length}-${Math.random()}`);
    const settings = set.flatMap((line) => ['--set', line]);
    execFileSync(program, ['run', `experiments/${name}`, '--seed', String(seed), '--out', out, '--quiet', ...settings]);
    return JSON.parse(readFileSync(join(out, 'DONE'), 'utf8'));
}

/** The module's run, in this thread. */
function alone(module, request, seed) {
    const part = new Part(module, 0, 1);
    let answer = part.begin(request, seed);
    const began = performance.now();
    while (answer.shared >= 0) answer = part.advance(answer.fitness);
    const seconds = (performance.now() - began) / 1e3;
    return { ...part.finish(), seconds, steps: answer.progress.robot_steps, memory: part.instance.calls.memory.buffer.byteLength };
}

/** A worker's thread, as in a page. */
function worker() {
    const code = `const { parentPort, workerData } = require('node:worker_threads');
        let part;
        const loaded = import(workerData);
        parentPort.on('message', async (data) => {
            let said;
            [part, said] = (await loaded).answer(part, data);
            parentPort.postMessage(said);
        });`;
    const own = new Worker(code, { eval: true, workerData: join(site, 'instance.js') });
    const ask = (message) =>
        new Promise((resolve, reject) => {
            own.removeAllListeners();
            own.once('message', resolve);
            own.once('error', reject);
            own.postMessage(message);
        });
    return { ask, end: () => own.terminate() };
}

async function together(module, request, seed, workers) {
    const pool = new Pool(Array.from({ length: workers }, worker));
    await pool.begin(module, request, seed);
    const began = performance.now();
    while (!pool.isFinished) await pool.step();
    const seconds = (performance.now() - began) / 1e3;
    const { robot_steps: steps } = pool.progress;
    const finished = await pool.finish();
    pool.end();
    return { ...finished, seconds, steps };
}

const speed = ({ steps, seconds }) => `${(steps / seconds / 1e6).toFixed(1)} M steps/s, ${seconds.toFixed(2)} s`;
const modules = {};
for (const name of ['oneiro', 'oneiro-compose', 'oneiro-scalar']) {
    let bytes;
    try {
        bytes = readFileSync(join(site, `${name}.wasm`));
    } catch {
        continue;
    }
    console.log(`${name}.wasm: ${bytes.length} bytes, ${gzipSync(bytes, { level: 9 }).length} compressed`);
    modules[name] = await WebAssembly.compile(bytes);
}
const module = modules.oneiro;

const avoidance = requested('khepera-avoidance');
const expected = native(avoidance, 1);
for (const [name, own] of Object.entries(modules)) {
    const run = alone(own, avoidance, 1n);
    assert.equal(run.result, expected.result, name);
    console.log(`${name}: ${speed(run)}, ${(run.memory / 1e6).toFixed(1)} MB`);
    assert.deepEqual(run.files.map(([file]) => file).sort(), Object.keys(expected.files).sort());
}
assert.notEqual(alone(module, avoidance, 2n).result, expected.result, 'another seed is another run');
for (const workers of [1, 2, 8]) {
    const run = await together(module, avoidance, 1n, workers);
    assert.equal(run.result, expected.result, `${workers} workers`);
    console.log(`${workers} workers: ${speed(run)}`);
}

const short = ['cycles=40', 'evolution.population=12', 'evolution.generations=4', 'trials=3', 'evolution.finalists=0'];
const axes = (cells) =>
    'evolution.descriptors=[{measure="end_x_mm",least=0,greatest=600' +
    `${cells ? ',cells=60' : ''}},{measure="mean_speed_mm_s",least=0,greatest=80${cells ? ',cells=90' : ''}}]`;
const kinds = {
    genetic: ['evolution.parents=4'],
    random: [],
    'cma-es': [],
    'sep-cma-es': [],
    'open-es': [],
    'differential-evolution': [],
    novelty: [axes(false), 'evolution.parents=4'],
    'map-elites': [axes(true)],
};
for (const [kind, own] of Object.entries(kinds)) {
    const [name, set] = ['khepera-avoidance', [`evolution.kind=${kind}`, ...short, ...own]];
    const request = requested(name, set);
    const { result } = native(request, 3);
    assert.equal(alone(module, request, 3n).result, result, `${name} ${set[0]}`);
    assert.equal((await together(module, request, 3n, 2)).result, result, `${name} ${set[0]}, 2 workers`);
    console.log(`${name}, ${set[0]}: the program's hash`);
}

// Every operation and function, also by the code that is compiled there.
const { codes, compared, differing } = new Instance(modules['oneiro-compose']).json('selftest');
assert.deepEqual(differing, []);
assert.ok(compared > 500_000 && codes.includes('native128x16') && codes.includes('interpretedx1'), `${compared}, ${codes}`);
console.log(`${compared} results by ${codes.join(', ')}: none differs`);

// What is composed of parts is compiled there.
for (const { name, files: [[, text]] } of new Instance(module).json('examples')) {
    const isForaging = /^\[swarm/m.test(text);
    const set = isForaging ? ['swarm.minutes=30'] : ['cycles=60', 'evolution.episodes=2500', 'evolution.finalists=0'];
    const request = requested(name, set);
    const { result } = native(request, 3);
    const began = performance.now();
    const run = alone(modules['oneiro-compose'], request, 3n);
    assert.equal(run.result, result, name);
    console.log(`${name}: the program's hash after ${((performance.now() - began) / 1e3).toFixed(1)} s, ${speed(run)}`);
}

// Bad input gets the program's message and exit code.
for (const [text, message] of [
    ['populatoin = 3', 'populatoin'],
    ['[evolution]\npopulation = 0', 'allowed: 1 to'],
    ['[', 'e.toml:1:2'],
]) {
    const refused = (error) => error instanceof Refusal && error.code === 3 && error.message.includes(message);
    assert.throws(() => new Instance(module).open({ name: 'e.toml', text }, 1n), refused, text);
}
rmSync(folder, { recursive: true });
console.log('all hashes are those of the program');
