import { Pool } from './pool.js';

/** @param {string} id @returns {any} */
const at = (id) => document.getElementById(id);
/** A module of one vector instruction: engines without vectors refuse it. */
const VECTORS = new Uint8Array([
    0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);
/** Most steps between two drawings of the curve take this long, ms. */
const FRAME = 100;

/** Shipped experiments: of each its name, what it is about, and its files. @type {{ name: string, about: string, files: [string, string][] }[]} */
let examples = [];
let pool, about, finished;
let isRunning = false;

function say(text, isBad = false) {
    at('message').textContent = text;
    at('message').classList.toggle('bad', isBad);
}

/** Modules that this engine runs: the second also compiles parts, swarms and other robots, and is loaded when the first one refuses. */
const MODULES = WebAssembly.validate(VECTORS) ? ['oneiro', 'oneiro-compose'] : ['oneiro-scalar'];
/** @type {Map<string, WebAssembly.Module>} */
const loaded = new Map();

/** @param {string} name */
async function loadedModule(name) {
    // Plain file servers may not know the type of such files, which streaming compilation needs.
    const compile = async () => WebAssembly.compile(await (await fetch(`${name}.wasm`)).arrayBuffer());
    if (!loaded.has(name)) loaded.set(name, await compile());
    return loaded.get(name);
}

/** A worker that answers one message at a time. */
function worker() {
    const own = new Worker('worker.js', { type: 'module' });
    const ask = (message) =>
        new Promise((resolve) => {
            own.onmessage = ({ data }) => resolve(data);
            own.onerror = (event) => resolve({ refused: `a worker ended: ${event.message}`, code: 70 });
            own.postMessage(message);
        });
    return { ask, end: () => own.terminate() };
}

/** The fields of the files that the experiment names. @returns {HTMLTextAreaElement[]} */
const parts = () => [...at('files').querySelectorAll('textarea')];

function request() {
    const set = at('set').value.split('\n').map((line) => line.trim());
    const files = Object.fromEntries(parts().map((field) => [field.name, field.value]));
    return { name: `${at('example').value}.toml`, text: at('text').value, set: set.filter((line) => line !== ''), files };
}

/** Begins the run of what the form says. */
async function begin() {
    const seed = at('seed').value.trim();
    if (!/^\d{1,19}$/.test(seed)) throw new Error(`the seed is ${seed}; allowed: a whole number from 0 on`);
    const count = Math.min(Math.max(Math.trunc(at('workers').valueAsNumber) || 1, 1), 64);
    finished = undefined;
    at('done').hidden = true;
    for (const name of MODULES) {
        pool?.end();
        pool = new Pool(Array.from({ length: count }, worker));
        try {
            about = await pool.begin(await loadedModule(name), request(), BigInt(seed));
            break;
        } catch (error) {
            if (name === MODULES.at(-1)) throw error;
            say('Loading the compiler.');
        }
    }
    at('run').hidden = false;
    say(about.warnings.join('\n'));
}

function draw(table) {
    const rows = table.trim().split('\n').map((line) => line.split(','));
    const [x, y] = about.columns.map((name) => rows[0].indexOf(name));
    const points = rows.slice(1).map((row) => [Number(row[x]), Number(row[y])]).filter((point) => point.every(Number.isFinite));
    if (points.length === 0) return;
    const [low, high] = [Math.min(0, ...points.map((p) => p[1])), Math.max(...points.map((p) => p[1]), 1e-9)];
    const place = ([px, py]) =>
        `${(50 + (580 * px) / Math.max(about.length - 1, 1)).toFixed(1)},${(215 - (195 * (py - low)) / (high - low || 1)).toFixed(1)}`;
    const node = (name, attributes, text = '') => {
        const own = document.createElementNS('http://www.w3.org/2000/svg', name);
        Object.entries(attributes).forEach(([key, value]) => own.setAttribute(key, value));
        own.textContent = text;
        return own;
    };
    at('curve').replaceChildren(
        node('polyline', { points: points.map(place).join(' ') }),
        node('text', { x: 4, y: 20 }, high.toPrecision(4)),
        node('text', { x: 4, y: 218 }, low.toPrecision(4)),
        node('text', { x: 50, y: 234 }, `${about.unit} 0 to ${about.length - 1}`),
        node('text', { x: 630, y: 234, 'text-anchor': 'end' }, about.value),
    );
}

async function show(began) {
    const { done, best, robot_steps: steps } = pool.progress;
    const speed = began ? `, ${(steps / 1e3 / (performance.now() - began)).toFixed(1)} million robot steps a second` : '';
    at('progress').textContent = `${about.name}: ${about.unit} ${done} of ${about.length}, best ${best == null ? 'none' : Number(Number(best).toPrecision(6))}${speed}`;
    draw(await pool.table());
}

/** Quotes for a shell. */
const quoted = (word) => (/^[\w./=:-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

async function end() {
    finished = await pool.finish();
    const { name, set } = request();
    at('done').hidden = false;
    at('hash').textContent = finished.result;
    at('name').textContent = name;
    const settings = set.map((line) => ` --set ${quoted(line)}`).join('');
    at('command').textContent = `oneiro run ${name} --seed ${at('seed').value.trim()}${settings}`;
    at('file').replaceChildren(...finished.files.map(([file], number) => new Option(file, String(number))));
    const report = finished.files.find(([file]) => file === 'report.html');
    at('report').hidden = report === undefined;
    if (report) at('report').srcdoc = new TextDecoder().decode(report[1]);
    pool.end();
    pool = undefined;
}

/** Advances until the run has ended, or is paused, or for one step. */
async function advance(isOneStep) {
    isRunning = true;
    at('pause').disabled = false;
    at('evolve').disabled = at('step').disabled = true;
    try {
        if (!pool) await begin();
        const [began, before] = [performance.now(), pool.progress.robot_steps];
        let drawn = -Infinity;
        do {
            if (!pool.isFinished) await pool.step();
            if (performance.now() - drawn > FRAME) {
                drawn = performance.now();
                await show(before === 0 ? began : 0);
            }
        } while (isRunning && !isOneStep && !pool.isFinished);
        await show(before === 0 && !isOneStep ? began : 0);
        if (pool.isFinished) await end();
    } catch (error) {
        pool?.end();
        pool = undefined;
        say(error instanceof Error ? error.message : String(error), true);
    }
    isRunning = false;
    at('pause').disabled = true;
    at('evolve').disabled = at('step').disabled = false;
}

/** What the form says, for the address's fragment. */
function fragment() {
    const { name, text, set, files } = request();
    const edited = Object.entries(files).filter(([file, own]) => !shipped().some(([other, first]) => other === file && first === own));
    return new URLSearchParams({
        example: name.replace(/\.toml$/, ''), text, set: set.join('\n'), seed: at('seed').value, files: JSON.stringify(Object.fromEntries(edited)),
    }).toString();
}

/** The files of the chosen example, the experiment's own first. */
const shipped = () => examples.find(({ name }) => name === at('example').value)?.files ?? [];

/** Shows files, each in a field. @param {[string, string][]} files */
function showFiles(files) {
    at('files').replaceChildren(...files.map(([name, text]) => {
        const [own, head, field] = ['details', 'summary', 'textarea'].map((kind) => document.createElement(kind));
        head.textContent = name;
        Object.assign(field, { name, value: text, rows: 16, spellcheck: false, ariaLabel: name });
        field.addEventListener('input', changed);
        own.append(head, field);
        return own;
    }));
}

/** Whatever changes the experiment ends the run in progress. */
function changed() {
    pool?.end();
    pool = undefined;
    at('link').href = `#${fragment()}`;
}

function chosen() {
    const [[, text], ...files] = shipped();
    at('text').value = text;
    showFiles(files);
    changed();
}

async function prepare() {
    const helper = worker();
    examples = await helper.ask({ call: 'examples', given: await loadedModule(MODULES[0]) });
    helper.end();
    at('example').replaceChildren(...examples.map(({ name, about: words }) => new Option(`${name}: ${words}`, name)));
    at('workers').value = String(Math.min(navigator.hardwareConcurrency || 1, 8));
    const given = new URLSearchParams(location.hash.slice(1));
    if (examples.some(({ name }) => name === given.get('example'))) at('example').value = given.get('example');
    chosen();
    ['seed', 'set', 'text'].forEach((id) => given.has(id) && (at(id).value = given.get(id)));
    const files = Object.entries(JSON.parse(given.get('files') ?? '{}')).map(([name, text]) => [name, String(text)]);
    showFiles([...new Map([...shipped().slice(1), ...files])]);
    changed();
    at('example').addEventListener('change', chosen);
    at('selftest').addEventListener('click', async () => {
        say('Testing.');
        const helper = worker();
        const { refused, codes, compared, differing } = await helper.ask({ call: 'selftest', given: await loadedModule(MODULES.at(-1)) });
        helper.end();
        const wrong = differing?.length > 0 ? `These differ: ${differing.join(', ')}. Please report this browser.` : 'No bit differs.';
        say(refused ?? `${compared} results of operations and functions by ${codes.join(', ')}: ${wrong}`, refused !== undefined || differing.length > 0);
    });
    at('add').addEventListener('click', () => {
        const name = at('name-of-file').value.trim();
        const present = parts().map((field) => [field.name, field.value]);
        if (name !== '') showFiles([...new Map([[name, ''], ...present])]);
        changed();
    });
    ['text', 'set', 'seed', 'workers'].forEach((id) => at(id).addEventListener('input', changed));
    at('evolve').addEventListener('click', () => advance(false));
    at('step').addEventListener('click', () => advance(true));
    at('pause').addEventListener('click', () => (isRunning = false));
    at('save').addEventListener('click', () => {
        const [name, bytes] = finished.files[Number(at('file').value)];
        const link = document.createElement('a');
        link.href = URL.createObjectURL(new Blob([bytes]));
        link.download = name.split('/').at(-1);
        link.click();
        setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
    if (given.has('go')) await advance(false);
}

prepare().catch((error) => say(String(error), true));
