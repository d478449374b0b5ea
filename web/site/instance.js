// An instance of the module: a run that advances step by step.

/** A refusal of the program, with the exit code that it would end with. */
export class Refusal extends Error {
    /** @param {string} message @param {number} code */
    constructor(message, code) {
        super(message);
        this.code = code;
    }
}

export class Instance {
    /** @param {WebAssembly.Module} module */
    constructor(module) {
        /** Places in the module's table of functions that nobody needs any more. @type {number[]} */
        const free = [];
        /** Adds the function of a module that was compiled at run time. @param {number} at @param {number} length */
        const install = (at, length) => {
            const { memory, __indirect_function_table: table } = this.calls;
            const code = new WebAssembly.Module(new Uint8Array(memory.buffer, at >>> 0, length));
            const place = free.pop() ?? table.grow(1);
            table.set(place, new WebAssembly.Instance(code, { oneiro: { memory } }).exports.run);
            return place;
        };
        /** @param {number} place */
        const remove = (place) => {
            this.calls.__indirect_function_table.set(place, null);
            free.push(place);
        };
        this.calls = new WebAssembly.Instance(module, { oneiro: { install, remove } }).exports;
    }

    /** Writes bytes to where the next call reads them. @param {Uint8Array} bytes */
    give(bytes) {
        const at = this.calls.input(bytes.length) >>> 0;
        new Uint8Array(this.calls.memory.buffer, at, bytes.length).set(bytes);
    }

    /** A copy of what a call returned. @param {string} name @param {...(number | bigint)} numbers @returns {Uint8Array} */
    take(name, ...numbers) {
        let code;
        try {
            code = this.calls[name](...numbers);
        } catch (error) {
            if (!(error instanceof WebAssembly.RuntimeError)) throw error;
            code = 70;
        }
        const [at, length] = [this.calls.output() >>> 0, this.calls.output_length() >>> 0];
        const bytes = new Uint8Array(this.calls.memory.buffer, at, length).slice();
        if (code !== 0) throw new Refusal(new TextDecoder().decode(bytes), code);
        return bytes;
    }

    /** @param {string} name @param {...(number | bigint)} numbers */
    json(name, ...numbers) {
        return JSON.parse(new TextDecoder().decode(this.take(name, ...numbers)));
    }

    /** Begins a run. @param {object} request @param {bigint} seed */
    open(request, seed) {
        this.give(new TextEncoder().encode(JSON.stringify(request)));
        return this.json('open', seed);
    }
}

/** A worker's part of a run that several advance together: number `part` of `parts`. */
export class Part {
    /** @param {WebAssembly.Module} module @param {number} part @param {number} parts */
    constructor(module, part, parts) {
        this.instance = new Instance(module);
        [this.part, this.parts] = [part, parts];
    }

    /** Begins the run. @param {object} request @param {bigint} seed */
    begin(request, seed) {
        return { about: this.instance.open(request, seed), ...this.next() };
    }

    /** Takes a step, given the fitness of all shared episodes. @param {Float32Array} fitness */
    advance(fitness) {
        if (this.shared > 0) {
            this.instance.give(new Uint8Array(fitness.buffer, fitness.byteOffset, fitness.byteLength));
            this.instance.take('tell');
        } else {
            this.instance.take('step');
        }
        return this.next();
    }

    /** Evaluates its part of the next step. */
    next() {
        this.shared = this.instance.calls.shared();
        const cut = (part) => Math.floor((Math.max(this.shared, 0) * part) / this.parts);
        const bytes = this.instance.take('evaluate', cut(this.part), cut(this.part + 1));
        return { shared: this.shared, fitness: new Float32Array(bytes.buffer), progress: this.instance.json('progress') };
    }

    table() {
        return new TextDecoder().decode(this.instance.take('table'));
    }

    /** Ends the run: the hash of its results, and its files. */
    finish() {
        const { result, files } = this.instance.json('finish');
        return { result, files: files.map((name, number) => [name, this.instance.take('file', number)]) };
    }
}

/** Answers a message to a worker, given the part that it has, if any. @returns {[Part, any]} */
export function answer(part, { call, given }) {
    try {
        if (call === 'examples' || call === 'selftest') return [part, new Instance(given).json(call)];
        if (call === 'begin') {
            part = new Part(given.module, given.part, given.parts);
            return [part, part.begin(given.request, given.seed)];
        }
        return [part, part[call](given)];
    } catch (error) {
        const code = error instanceof Refusal ? error.code : 70;
        return [part, { refused: String(error instanceof Refusal ? error.message : error), code }];
    }
}
