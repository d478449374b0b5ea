// What `run` of a WebAssembly module returns, as the exit code.
import { readFileSync } from "node:fs";

const { instance } = await WebAssembly.instantiate(readFileSync("program"));
process.exit(instance.exports.run());
