// Workers that advance a run together. Each has an instance and a part of the episodes; no memory is shared.
import { Refusal } from './instance.js';

export class Pool {
    /** @param {{ ask: (message: object) => Promise<any>, end: () => void }[]} workers */
    constructor(workers) {
        this.workers = workers;
    }

    /** Asks all workers, and waits for all answers. @param {string} call @param {(worker: number) => any} given */
    async all(call, given) {
        const answers = await Promise.all(this.workers.map((worker, number) => worker.ask({ call, given: given(number) })));
        const refused = answers.find((answer) => answer.refused !== undefined);
        if (refused) throw new Refusal(refused.refused, refused.code);
        return answers;
    }

    /** Begins a run. @param {WebAssembly.Module} module @param {object} request @param {bigint} seed */
    async begin(module, request, seed) {
        const parts = this.workers.length;
        this.answers = await this.all('begin', (part) => ({ module, part, parts, request, seed }));
        return this.answers[0].about;
    }

    get isFinished() {
        return this.answers[0].shared < 0;
    }

    /** Steps done, the best fitness, and robot-steps of all workers. */
    get progress() {
        const steps = this.answers.map((answer) => answer.progress.robot_steps);
        return { ...this.answers[0].progress, robot_steps: steps.reduce((sum, own) => sum + own) };
    }

    /** Takes a step. */
    async step() {
        const parts = this.answers.map((answer) => answer.fitness);
        const fitness = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
        parts.reduce((at, part) => (fitness.set(part, at), at + part.length), 0);
        this.answers = await this.all('advance', () => fitness);
    }

    /** The table of steps so far. @returns {Promise<string>} */
    async table() {
        return this.workers[0].ask({ call: 'table', given: null });
    }

    /** Ends the run: the hash of its results, and its files. */
    async finish() {
        const finished = await this.workers[0].ask({ call: 'finish', given: null });
        if (finished.refused !== undefined) throw new Refusal(finished.refused, finished.code);
        return finished;
    }

    end() {
        this.workers.forEach((worker) => worker.end());
    }
}
